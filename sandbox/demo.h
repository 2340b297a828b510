// SPDX-License-Identifier: MIT
//
// A loaded demo: what its script says of itself, its world, and its checks. It is stepped, not drawn, here.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "physics/world.h"
#include "sandbox/selection.h"

namespace skerry::sandbox {

struct BridgeView;  // sandbox/bridge_view.h

/// The part of the world that the picture shows.
struct View {
  Vec2 centre;        ///< [m]
  double height = 0;  ///< [m]
  double width = 0;   ///< [m]; 0: follows from the picture's shape
};

/// A number, or one of several words, that the command line and the window may change.
struct Parameter {
  std::string name;
  std::string unit;
  double value = 0, standard = 0, low = 0, high = 0;
  std::vector<std::string> choices;  ///< when not empty: the words; `value` is the index from 0

  /// The value as people write it.
  std::string text() const;
};

enum class CheckState : std::uint8_t {
  Waiting,
  Holds,
  Fails,
  Unmeasured  ///< a body was removed, and the function of the check fails without it
};

/// One `expect` of a script.
struct Check {
  std::string what;
  std::string unit;
  std::string place;         ///< file:line of the `expect`
  std::optional<double> at;  ///< [s]; without it: at the end of the run
  bool always = false;       ///< after every step
  std::optional<double> below, above, equals;
  double within = 0;  ///< tolerance of `equals`
  int function = 0;   ///< registry reference
  CheckState state = CheckState::Waiting;
  double value = 0;  ///< last measured, or (always) the first that fails
  double time = 0;   ///< when [s]

  bool accepts(double measured) const;
  /// For example "below 1e-06 m".
  std::string condition() const;
};

/// A column of the CSV series and of plots.
struct Watch {
  std::string what;
  std::string unit;
  int function = 0;
};

/// Words shown in the picture from a moment on.
struct Note {
  double time = 0;  ///< [s]
  std::string text;
};

/// What the command line changes.
struct DemoOptions {
  std::uint64_t seed = 1;
  std::optional<double> dt{};       ///< [s]
  std::optional<double> seconds{};  ///< length of the run
  std::optional<std::uint64_t> steps{};
  std::optional<double> accuracy{};  ///< `WorldConfig::accuracy`
  std::optional<double> budget{};  ///< of an island and a step, millions of `SolveWork::visits`; 0: unlimited
  std::optional<double> flow_work{};    ///< `WorldConfig::flow_work`
  std::optional<double> sleep_speed{};  ///< `WorldConfig::sleep_speed` [m/s]
  int threads = 1;
  std::optional<std::string> solver{}, broad_phase{}, impact_law{}, stepper{};
  std::vector<std::pair<std::string, std::string>> parameters{};  ///< name, value as typed
  std::function<void(std::string_view)> print{};                  ///< lines that the script prints
};

/// What the steps of a run did, summed.
struct RunTotals {
  std::uint64_t islands_by_events = 0, islands_by_time_stepping = 0, islands_at_rest = 0,
                islands_in_flight = 0, islands_in_flow = 0, islands_in_one_piece = 0;
  std::uint64_t substeps = 0, inner_steps = 0, rejected_steps = 0, force_solves = 0, events_found = 0,
                impacts = 0, fallbacks = 0;
  double error_estimate = 0;  ///< sum over the steps of the largest estimate of an island
};

/// A point of a body that leaves a trace.
struct TracedPoint {
  BodyId body;
  Vec2 local;  ///< in the body's frame, from its centre of mass [m]
  friend bool operator==(const TracedPoint&, const TracedPoint&) = default;
};

/// Colours that a script gave to bodies.
class BodyColors {
 public:
  /// @param color  index into `color_names()`, -1: the usual one
  void set(BodyId body, int color);
  int of(BodyId body) const;

 private:
  struct Given {
    BodyId body;
    int color;
  };
  std::vector<Given> given_;  // by slot: what takes the place of a body that was removed has not its colour
};

/// How a script wants to be shown.
struct Picture {
  std::optional<View> view;
  std::vector<std::string> overlays;    ///< of `show`
  std::optional<double> impulse_scale;  ///< impact arrows [N s / m]
  std::optional<double> force_scale;    ///< arrows of resting forces [N / m]
  BodyColors colors;
  SelectionText selection;          ///< of `highlight`
  std::vector<TracedPoint> traced;  ///< of `show`; none: the first bodies that move
  double strobe = 0;  ///< traced bodies are shown at multiples of this [s]; 0: only where they are
};

/// What runs may be: beyond these a number is a slip of the hand, and counts of steps would not be exact.
inline constexpr double kShortestStep = 1e-9, kLongestStep = 1e6;  // [s]
inline constexpr double kLongestRun = 1e9;                         // [s]
inline constexpr std::uint64_t kMostSteps = 1'000'000'000'000;

/// Steps of `dt` up to `time` [s]: 4 s in steps of 1/60 s are 240, though 4 * 60 may round to
/// 240.00000000000003.
std::uint64_t steps_until(double time, double dt);

/// FNV-1a of a text's bytes.
std::uint64_t text_hash(std::string_view text);

/// How the bodies can be coloured in a script; the index is what `BodyColors` holds.
const std::vector<std::string>& color_names();

/// A demo at a moment; made and understood by Demo only.
class DemoState {
 public:
  std::uint64_t step() const;  ///< steps done
  std::size_t bytes() const;   ///< memory, roughly

 private:
  friend class Demo;
  std::shared_ptr<const struct DemoMoment> moment_;
};

class Demo {
 public:
  /// Runs the script at `path`. @throws ScriptError for a missing file or an error in it, UsageError for
  /// options that it does not have or values outside their range.
  Demo(const std::string& path, const DemoOptions& options);
  ~Demo();
  Demo(Demo&&) noexcept;

  const std::string& name() const;  ///< file name without folder and `.lua`
  const std::string& path() const;
  std::uint64_t script_hash() const;  ///< of the text that was run; the file may have changed since
  const std::string& title() const;
  const std::string& lesson() const;  ///< one sentence
  double seconds() const;             ///< length of the run
  double dt() const;                  ///< length of a step [s]
  std::uint64_t total_steps() const;  ///< in `seconds`
  const Picture& picture() const;
  const std::vector<Parameter>& parameters() const;
  const std::vector<Check>& checks() const;
  const std::vector<Watch>& watches() const;
  /// Notes up to now, in the order of time.
  const std::vector<Note>& notes() const;

  const World& world() const;
  const std::vector<BridgeView>& bridges() const;
  /// Turns observers on for overlays; those that the script needs stay on.
  void observe(Observe what);
  /// Callbacks of the script, one step of the world, then the checks that are due. @throws ScriptError
  void step();
  std::uint64_t steps_done() const;
  double time() const;  ///< steps times dt [s]
  const RunTotals& totals() const;
  /// Observes the paths within steps from now on, so that `show_at` may go between them.
  void keep_paths();
  /// The moment that pictures show [s]: within the last step, until the next one; without `keep_paths` always
  /// its end.
  void show_at(double time);
  double shown_time() const;
  /// State of a body at that moment.
  BodyState shown(std::size_t slot) const;
  /// Whether the paths within steps are observed, for this or for an overlay.
  bool knows_paths() const;
  /// State of a body at a time within the last step [s]; where paths are not observed, or it has been removed
  /// since, that at its end.
  BodyState state_at(std::size_t slot, double time) const;
  /// Evaluates what waits for the end. Checks at a later time stay `Waiting`, and all of them when the run is
  /// shorter than the script says.
  void finish();
  /// Whether a check fails or the world had to stop a body whose state was not finite.
  bool failed() const;
  /// Current values of the watches.
  std::vector<double> watch_values();

  /// Everything that later steps depend on: the world, the variables of the script, what it noted and
  /// checked. For `restore` of this very demo.
  DemoState save() const;
  /// Goes back (or forth) to a state that `save` of this demo gave; the next steps are those that followed
  /// it, bit by bit. @throws std::invalid_argument for a state of another demo
  void restore(const DemoState& state);
  /// The world for what a user does to it between steps.
  World& world_for_input();
  /// A user removed a body that the script may still name: from now on its functions may fail without ending
  /// the run. The first error is noted, checks that fail so are `Unmeasured`.
  void body_was_removed();
  /// Material of shapes that do not say otherwise.
  const Material& material() const;
  /// Takes a world that a demo of the same script came to; checks at earlier times are dropped.
  /// @throws std::invalid_argument if it has other bodies
  void adopt(World world);
  /// Whether the script does something while it runs (`on_step`, `at`).
  bool has_callbacks() const;
  /// Calls what the script does before every step (`on_step`), and what attracts does, so that forces wait
  /// for the next one. Others than `step` may for a last look: the next step would do it again. @return
  /// whether there is any
  bool call_before_step();

 private:
  std::unique_ptr<struct Script> script_;
};

}  // namespace skerry::sandbox
