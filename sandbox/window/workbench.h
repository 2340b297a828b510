// SPDX-License-Identifier: MIT
//
// What the window works on, without the window: the open demo, its ghost, time, camera, pointer, and what is
// shown. Keys and buttons call these functions; tests call them too.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/style.h"
#include "sandbox/demo_files.h"
#include "sandbox/selection.h"
#include "sandbox/window/player.h"
#include "sandbox/window/time_control.h"

namespace skerry::sandbox {

/// Names of solver, stepper, broad phase and impact law.
struct Methods {
  std::string solver, stepper, broad_phase, impact_law;
  std::vector<std::string> words() const { return {solver, stepper, broad_phase, impact_law}; }
  friend bool operator==(const Methods&, const Methods&) = default;
};
Methods methods_of(const World& world);

/// Parts of the window that come and go.
struct Panels {
  bool help = false, demos = false, settings = false;
  std::string search;         ///< in the list of demos
  bool focus_search = false;  ///< the list was just opened
};

/// A sentence for the user, shown for some seconds.
struct Message {
  std::string text;
  bool trouble = false;
  double seconds_left = 0;
};

class Workbench {
 public:
  /// @param demos for the list. @param folder of --demos, as given
  Workbench(std::vector<DemoFile> demos, const DemoOptions& options);
  ~Workbench();

  // --- The demo. Without one the list of demos is open.
  bool has_demo() const { return player_ != nullptr; }
  const std::vector<DemoFile>& demos() const { return demos_; }
  /// Opens a script; if it cannot be loaded the present demo stays and the reason is the message.
  void open(const std::string& path);
  /// The same script again, from its beginning.
  void restart();
  /// Reloads when the file has changed since it was opened; looks at most every quarter of a second.
  void watch_file(double seconds);
  /// Starts again with another value. @param text as on the command line
  void set_parameter(const std::string& name, const std::string& text);
  Player& player() { return *player_; }
  const Player& player() const { return *player_; }

  // --- Time
  TimeControl& time() { return time_; }
  const TimeControl& time() const { return time_; }
  /// Makes the steps that are due. @param seconds on the wall since the last frame
  void advance(double seconds);
  void step(int steps);  ///< forwards or back; pauses
  void seek(std::uint64_t step);
  void scrub(std::uint64_t step);  ///< as seek; pauses

  /// The matrix shows the island of the selected body.
  void follow_selection();

  // --- Methods, and a second run of the same scene with others
  void set_methods(const Methods& methods);
  bool has_ghost() const { return ghost_ != nullptr; }
  const Player& ghost() const { return *ghost_; }
  const Methods& ghost_methods() const { return ghost_methods_; }
  void set_ghost(const std::optional<Methods>& methods);
  void toggle_ghost();
  /// Largest distance between a body and its ghost [m].
  double ghost_distance() const;

  // --- What a user does to the world
  void grab(BodyId body, Vec2 at);
  void drag(Vec2 at);
  void release();
  void spawn(Vec2 at);
  void remove_selected();
  void hold_selected();  ///< where it is, or lets it go
  SpawnKind spawn_kind = SpawnKind::Disc;

  // --- What is shown
  const std::vector<std::string>& overlays() const { return overlays_; }
  bool shows(const std::string& overlay) const;
  void toggle_overlay(const std::string& name);
  /// Grows when the overlays, the demo or the theme change.
  int revision() const { return revision_; }
  render::Theme theme() const { return theme_; }
  void set_theme(render::Theme theme);
  render::Camera camera;
  bool fit_view = true;  ///< the camera is to be placed again
  Selection selection;
  Panels panels;

  void say(const std::string& text, bool trouble = false);
  const std::optional<Message>& message() const { return message_; }

  // --- Files
  void save_recording();  ///< DEMO.skerry in the working directory
  bool take_screenshot = false;
  bool record_video = false;
  bool quit = false;
  /// A name that is not taken: "stack.png", "stack-2.png", ...
  std::string free_name(const std::string& ending) const;

 private:
  void load(const std::string& path, const DemoOptions& options);
  void input(const UserInput& input);
  void guarded(const std::function<void()>& act);
  void let_go_of_the_past();
  void follow_with_ghost();
  bool has_loose_selection() const;

  std::vector<DemoFile> demos_;
  DemoOptions options_;
  std::unique_ptr<Player> player_, ghost_;
  SelectionText highlighted_;  ///< by the script, as it was last taken over
  Methods ghost_methods_;
  bool pulling_ = false;  ///< the user holds a body now, not only in the past that is shown
  TimeControl time_;
  std::vector<std::string> overlays_;
  render::Theme theme_ = render::Theme::Light;
  int revision_ = 0;
  std::optional<Message> message_;
  std::filesystem::file_time_type written_{};
  double since_look_ = 0;
};

}  // namespace skerry::sandbox
