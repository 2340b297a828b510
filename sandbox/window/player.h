// SPDX-License-Identifier: MIT
//
// A demo that can be stepped back, scrubbed and pushed about.
//
//   keyframes   0 . . . . . . . 16 . . . . . . . 32 . . . . . . .
//   inputs            ^grab ^drag     ^release
//   states      0 ----------------------------------------> end      each with its hash
//                                  ^ step()
//
// Any state is reached from the keyframe before it by making the steps again, with the user's inputs where
// they were; the hashes prove that it is the same state by the bit. An input in the past forgets what came
// after it. When the keyframes take too much memory every second one goes, so all states stay in reach.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sandbox/demo.h"
#include "sandbox/history.h"
#include "sandbox/window/user_input.h"

namespace skerry::sandbox {

struct PlayerLimits {
  std::uint64_t spacing = 16;                   ///< steps between keyframes, at first
  std::size_t memory = std::size_t{256} << 20;  ///< [bytes] of keyframes
};

class Player {
 public:
  /// @throws what Demo throws
  Player(const std::string& path, const DemoOptions& options, PlayerLimits limits = {});
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  const Demo& demo() const { return *demo_; }
  const DemoOptions& options() const { return options_; }
  const History& history() const { return *history_; }
  const Hand& hand() const { return hand_; }
  /// Overlays may need more; the states do not depend on it.
  void observe(Observe what) { demo_->observe(what); }

  /// Keeps the equations of the island that this body is in; none: of the largest one. Those of the present
  /// step are found by making it again, unless `soon`: then the next step brings them.
  void follow(BodyId body, bool soon);

  std::uint64_t step() const { return demo_->steps_done(); }
  /// The last state that is known.
  std::uint64_t end() const { return hashes_.size() - 1; }
  /// The state hash after `step` steps. @pre step <= end()
  std::uint64_t hash(std::uint64_t step) const { return hashes_[step]; }
  /// Steps at which something worth a mark happened: notes of the script and the user's inputs.
  const std::vector<UserInput>& inputs() const { return inputs_; }
  /// First step whose state came out differently when it was made again; none: all were the same.
  std::optional<std::uint64_t> divergence() const { return divergence_; }
  std::size_t keyframes() const { return keyframes_.size(); }
  std::size_t keyframe_bytes() const { return bytes_; }

  /// One step on: made again while in the past, new at the end. @throws ScriptError; then the state is the
  /// one before the step
  void advance();
  /// Goes to the state after `step` steps; beyond the end new steps are made. @throws ScriptError
  void seek(std::uint64_t step);
  /// Gives inputs that will be made when their steps come. @pre nothing was done yet
  void play_inputs(std::vector<UserInput> inputs);
  /// Does something to the world now. In the past this forgets the states after it.
  void input(UserInput input);
  /// Forgets the states and inputs after this state, as `input` does.
  void forget_future();

 private:
  struct Keyframe {
    DemoState demo;
    History history;
    Hand hand;
  };
  static std::size_t bytes_of(const Keyframe& frame);
  void arrive();
  void apply_inputs();
  void apply(const UserInput& input);
  void forget_after(std::uint64_t step);
  DemoOptions printing_once(const DemoOptions& options);
  void keep();

  bool again_ = false;  ///< the step that is being made was made before
  DemoOptions options_;
  PlayerLimits limits_;
  std::unique_ptr<Demo> demo_;
  std::unique_ptr<History> history_;
  Hand hand_;
  std::vector<std::uint64_t> hashes_;  ///< by step, from 0; before the inputs of that step
  std::vector<UserInput> inputs_;      ///< by step
  std::vector<Keyframe> keyframes_;    ///< by step; the first is that of step 0
  std::uint64_t spacing_;
  std::size_t bytes_ = 0;
  std::optional<std::uint64_t> divergence_;
};

}  // namespace skerry::sandbox
