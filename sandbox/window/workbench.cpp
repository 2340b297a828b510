// SPDX-License-Identifier: MIT
#include "sandbox/window/workbench.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sandbox/errors.h"
#include "sandbox/painter.h"
#include "sandbox/window/recording.h"

namespace skerry::sandbox {
namespace {

namespace fs = std::filesystem;

constexpr double kMessageSeconds = 5;
constexpr double kLookSeconds = 0.25;

fs::file_time_type time_of(const std::string& path) {
  std::error_code error;
  const fs::file_time_type time = fs::last_write_time(path, error);
  return error ? fs::file_time_type{} : time;
}

}  // namespace

Methods methods_of(const World& world) {
  const WorldConfig& config = world.config();
  return {config.solver, config.stepper, config.broad_phase, config.impact_law};
}

Workbench::Workbench(std::vector<DemoFile> demos, const DemoOptions& options)
    : demos_(std::move(demos)), options_(options) {
  panels.demos = panels.focus_search = true;
}

Workbench::~Workbench() = default;

void Workbench::say(const std::string& text, bool trouble) {
  message_ = Message{text, trouble, kMessageSeconds};
}

/// Whatever a script or a file does wrong is told, not thrown.
void Workbench::guarded(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& error) {
    time_.play(false);
    say(error.what(), true);
  }
}

void Workbench::load(const std::string& path, const DemoOptions& options) {
  // Before the text is read: what is written meanwhile is loaded next time.
  const fs::file_time_type written = time_of(path);
  auto fresh = std::make_unique<Player>(path, options);
  written_ = written;
  const bool other = !player_ || player_->demo().path() != fresh->demo().path();
  if (other) {
    overlays_ = fresh->demo().picture().overlays;
    fit_view = true;
    panels.demos = false;
  }
  player_ = std::move(fresh);
  selection = {};
  highlighted_ = {};
  player_->observe(needs_of(overlays_));
  if (ghost_) set_ghost(other ? std::nullopt : std::optional(ghost_methods_));
  if (other) ghost_methods_ = {};
  ++revision_;
}

void Workbench::open(const std::string& path) {
  guarded([&] {
    const bool same = player_ && player_->demo().path() == path;
    DemoOptions options = same ? player_->options() : options_;
    // Parameters of the command line are those of the first demo.
    if (!same && player_) options.parameters.clear();
    load(path, options);
    time_.play(true);
  });
}

void Workbench::restart() {
  if (player_) open(player_->demo().path());
}

void Workbench::watch_file(double seconds) {
  if (!player_ || (since_look_ += seconds) < kLookSeconds) return;
  since_look_ = 0;
  const std::string path = player_->demo().path();
  const fs::file_time_type now = time_of(path);
  if (now == written_ || now == fs::file_time_type{}) return;
  written_ = now;
  const std::optional<Message> before = message_;
  message_.reset();
  open(path);
  if (!message_) say(path + " was saved: loaded again");
}

void Workbench::set_parameter(const std::string& name, const std::string& text) {
  guarded([&] {
    DemoOptions options = player_->options();
    std::erase_if(options.parameters, [&](const auto& given) { return given.first == name; });
    options.parameters.emplace_back(name, text);
    load(player_->demo().path(), options);
  });
}

void Workbench::advance(double seconds) {
  if (message_ && (message_->seconds_left -= seconds) <= 0) message_.reset();
  if (!player_) return;
  guarded([&] {
    for (std::uint64_t due = time_.steps_for(seconds, player_->demo().dt()); due > 0; --due) {
      player_->advance();
      if (ghost_) ghost_->advance();
    }
  });
  follow_with_ghost();
}

/// Where an error has stopped one of the two, the other does not go on alone; a ghost that cannot follow
/// goes.
void Workbench::follow_with_ghost() {
  if (!ghost_ || ghost_->step() == player_->step()) return;
  guarded([&] {
    try {
      ghost_->seek(player_->step());
    } catch (...) {
      ghost_.reset();
      throw;
    }
  });
}

void Workbench::follow_selection() {
  if (!player_) return;
  if (const SelectionText& wanted = player_->demo().picture().selection; wanted != highlighted_) {
    highlighted_ = wanted;
    guarded([&] { selection = resolve(wanted, player_->demo().world()); });
  }
  // A held body is not made to fall behind the hand by steps that are made again.
  guarded([&] { player_->follow(selection.body, time_.playing() || player_->hand().holds()); });
}

void Workbench::seek(std::uint64_t step) {
  if (!player_) return;
  guarded([&] {
    player_->seek(step);
    if (ghost_) ghost_->seek(step);
  });
  follow_with_ghost();
}

void Workbench::scrub(std::uint64_t step) {
  time_.play(false);
  if (player_ && step != player_->step()) seek(step);
}

void Workbench::step(int steps) {
  if (!player_) return;
  const std::uint64_t now = player_->step();
  const auto back = static_cast<std::uint64_t>(std::max(0, -steps));
  scrub(steps < 0 ? now - std::min(now, back) : now + static_cast<std::uint64_t>(steps));
}

void Workbench::set_methods(const Methods& methods) {
  if (!player_) return;
  let_go_of_the_past();
  guarded([&] {
    player_->input({.kind = InputKind::Methods, .methods = methods.words()});
    // Its methods stay, but what the user did later is no more.
    if (ghost_) ghost_->forget_future();
  });
  ++revision_;
}

void Workbench::set_ghost(const std::optional<Methods>& methods) {
  ghost_.reset();
  if (!methods || !player_) return;
  ghost_methods_ = *methods;
  guarded([&] {
    DemoOptions options = player_->options();
    options.print = {};  // the scene itself prints the same
    auto ghost = std::make_unique<Player>(player_->demo().path(), options);
    // The same scene and the same hand, other methods from the beginning.
    std::vector<UserInput> inputs{{.kind = InputKind::Methods, .methods = methods->words()}};
    for (const UserInput& input : player_->inputs())
      if (input.kind != InputKind::Methods) inputs.push_back(input);
    ghost->play_inputs(std::move(inputs));
    ghost->seek(player_->step());
    ghost_ = std::move(ghost);
  });
}

void Workbench::toggle_ghost() {
  if (!player_) return;
  if (ghost_) {
    set_ghost(std::nullopt);
    return;
  }
  Methods other = ghost_methods_.solver.empty() ? methods_of(player_->demo().world()) : ghost_methods_;
  // Without a choice: what most engines do.
  if (ghost_methods_.solver.empty()) other.solver = "pgs";
  set_ghost(other);
}

double Workbench::ghost_distance() const {
  if (!ghost_ || !player_) return 0;
  const BodyArrays& a = player_->demo().world().bodies();
  const BodyArrays& b = ghost_->demo().world().bodies();
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (a.alive[i] && b.alive[i] && a.type[i] == BodyType::Dynamic)
      largest = std::max(largest, length(a.position[i] - b.position[i]));
  }
  return largest;
}

/// In the past a body may hang at a hand whose release is about to be forgotten: then it lets go now.
void Workbench::let_go_of_the_past() {
  if (!pulling_ && player_->hand().holds()) input({.kind = InputKind::Release});
}

void Workbench::input(const UserInput& given) {
  if (!player_) return;
  if (given.kind != InputKind::Grab && given.kind != InputKind::Release) let_go_of_the_past();
  guarded([&] {
    player_->input(given);
    if (ghost_) ghost_->input(given);
  });
}

void Workbench::grab(BodyId body, Vec2 at) {
  pulling_ = true;
  input({.kind = InputKind::Grab, .body = body, .at = at});
}

void Workbench::drag(Vec2 at) {
  if (pulling_ && player_ && player_->hand().holds() && player_->hand().target() != at)
    input({.kind = InputKind::Drag, .at = at});
}

void Workbench::release() {
  if (std::exchange(pulling_, false) && player_ && player_->hand().holds())
    input({.kind = InputKind::Release});
}

void Workbench::spawn(Vec2 at) {
  // A thirtieth of the view: visible, and not in the way.
  input({.kind = InputKind::Spawn, .at = at, .spawn = spawn_kind, .size = camera.height / 30});
}

void Workbench::remove_selected() {
  if (!has_loose_selection()) return;
  input({.kind = InputKind::Remove, .body = selection.body});
  selection = {};
}

void Workbench::hold_selected() {
  if (has_loose_selection()) input({.kind = InputKind::Hold, .body = selection.body});
}

bool Workbench::has_loose_selection() const {
  return player_ && selection.body && is_loose(player_->demo().world(), selection.body, player_->inputs());
}

bool Workbench::shows(const std::string& overlay) const {
  return std::find(overlays_.begin(), overlays_.end(), overlay) != overlays_.end();
}

void Workbench::toggle_overlay(const std::string& name) {
  if (shows(name))
    std::erase(overlays_, name);
  else
    overlays_.push_back(name);
  ++revision_;
  if (!player_) return;
  player_->observe(needs_of(overlays_));
  // A state that stands still is made again, so that there is something to see.
  if (!time_.playing() && player_->step() > 0) seek(player_->step());
}

void Workbench::set_theme(render::Theme theme) {
  theme_ = theme;
  ++revision_;
}

std::string Workbench::free_name(const std::string& ending) const {
  const std::string name = player_ ? player_->demo().name() : "skerry";
  std::string path = name + ending;
  for (int i = 2; fs::exists(path); ++i) path = name + '-' + std::to_string(i) + ending;
  return path;
}

void Workbench::save_recording() {
  if (!player_) return;
  guarded([&] {
    const std::string path = free_name(".skerry");
    const Recording recording = record(*player_);
    write_bytes(path, sandbox::save_recording(recording));
    const std::string text = path + ": " + std::to_string(recording.steps()) + " steps; ";
    std::error_code error;
    const bool changed =
        !fs::exists(recording.path, error) || file_hash(recording.path) != recording.script_hash;
    say(text + (changed ? "it needs the script as it was loaded, and " + recording.path + " has changed since"
                        : "skerry replay " + path));
  });
}

}  // namespace skerry::sandbox
