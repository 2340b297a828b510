// SPDX-License-Identifier: MIT
#include "physics/user_events.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "physics/root.h"
#include "physics/world.h"

namespace skerry {
namespace {

// Parts of a step at whose ends signs are compared.
constexpr int kParts = 8;
// Share of a time by which a difference of two is rounded.
constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();

struct Root {
  double time;
  bool rising;
  EventAction action;
};

/// Throws what `interpolated` throws if the paths of the last step are not known; any body tells.
void require_paths(const World& world, double begin) {
  const auto& alive = world.bodies().alive;
  const auto first = std::find_if(alive.begin(), alive.end(), [](auto one) { return one != 0; });
  if (first == alive.end()) return;
  (void)world.interpolated(world.body_id(static_cast<std::size_t>(first - alive.begin())), begin);
}

}  // namespace

int UserEvents::add(EventMeasure measure, EventAction action) {
  if (!measure || !action)
    throw std::invalid_argument(std::string("UserEvents::add: empty ") + (measure ? "action" : "measure"));
  watched_.push_back({next_, std::move(measure), std::move(action)});
  return next_++;
}

void UserEvents::remove(int number) {
  const auto found = std::find_if(watched_.begin(), watched_.end(),
                                  [number](const Watched& one) { return one.number == number; });
  if (found == watched_.end())
    throw std::invalid_argument("UserEvents::remove: no event " + std::to_string(number));
  watched_.erase(found);
}

int UserEvents::look(const World& world) {
  const StepReport& report = world.report();
  if (report.step == 0 || watched_.empty()) return 0;
  double begin = report.time - report.h;
  // A step begins where the last one ended, which rounding may put into it again: twice would be a root
  // there.
  if (std::abs(looked_ - begin) <= kRounding * report.time) begin = looked_;
  looked_ = report.time;
  const double part = (report.time - begin) / kParts;
  require_paths(world, begin);
  std::vector<Root> roots;
  for (const Watched& one : watched_) {
    const auto end_of = [&](int k) { return k == kParts ? report.time : begin + k * part; };
    double before = one.measure(begin);
    for (int k = 1; k <= kParts; ++k) {
      const double from = end_of(k - 1), to = end_of(k), value = one.measure(to);
      // A zero belongs to the part that ends with it.
      if ((before > 0 && value <= 0) || (before < 0 && value >= 0)) {
        const double sign = before > 0 ? 1 : -1;
        const double after = falling_root([&](double t) { return sign * one.measure(from + t); }, 0,
                                          sign * before, to - from, sign * value);
        roots.push_back({from + after, before < 0, one.action});
      }
      before = value;
    }
  }
  std::stable_sort(roots.begin(), roots.end(), [](const Root& x, const Root& y) { return x.time < y.time; });
  for (const Root& root : roots) root.action(root.time, root.rising);
  return static_cast<int>(roots.size());
}

}  // namespace skerry
