// SPDX-License-Identifier: MIT
#include "sandbox/window/player.h"

#include <algorithm>

namespace skerry::sandbox {
Player::Player(const std::string& path, const DemoOptions& options, PlayerLimits limits)
    : options_(options),
      limits_(limits),
      demo_(std::make_unique<Demo>(path, printing_once(options))),
      history_(std::make_unique<History>(*demo_, true, kFlashSeconds)),
      spacing_(std::max<std::uint64_t>(1, limits.spacing)) {
  hashes_.push_back(demo_->world().state_hash());
  keep();
}

Player::~Player() = default;

/// What a script prints is printed when it happens first, not when the step is made again.
DemoOptions Player::printing_once(const DemoOptions& options) {
  DemoOptions once = options;
  if (options.print)
    once.print = [this, print = options.print](std::string_view line) {
      if (!again_) print(line);
    };
  return once;
}

std::size_t Player::bytes_of(const Keyframe& frame) {
  return frame.demo.bytes() + frame.history.bytes();
}

void Player::keep() {
  const std::uint64_t now = step();
  if (now % spacing_ != 0 || (!keyframes_.empty() && keyframes_.back().demo.step() >= now)) return;
  keyframes_.push_back({demo_->save(), *history_, hand_});
  bytes_ += bytes_of(keyframes_.back());
  while (bytes_ > limits_.memory && keyframes_.size() > 2) {
    spacing_ *= 2;
    std::erase_if(keyframes_, [&](const Keyframe& frame) { return frame.demo.step() % spacing_ != 0; });
    bytes_ = 0;
    for (const Keyframe& frame : keyframes_) bytes_ += bytes_of(frame);
  }
}

/// At a new state, before its inputs.
void Player::arrive() {
  const std::uint64_t now = step(), hash = demo_->world().state_hash();
  if (now < hashes_.size()) {
    if (hash != hashes_[now] && (!divergence_ || now < *divergence_)) divergence_ = now;
  } else {
    hashes_.push_back(hash);
  }
  keep();
  apply_inputs();
}

void Player::apply_inputs() {
  const auto first = std::lower_bound(inputs_.begin(), inputs_.end(), step(),
                                      [](const UserInput& input, std::uint64_t s) { return input.step < s; });
  for (auto input = first; input != inputs_.end() && input->step == step(); ++input) apply(*input);
}

void Player::apply(const UserInput& input) {
  if (input.kind == InputKind::Remove) demo_->body_was_removed();
  apply_input(input, demo_->material(), demo_->world_for_input(), hand_);
}

void Player::advance() {
  const std::uint64_t before = step();
  again_ = before < end();
  try {
    hand_.pull(demo_->world_for_input(), demo_->dt());
    demo_->step();
    history_->update(*demo_);
    if (step() == demo_->total_steps()) demo_->finish();
  } catch (...) {
    // Half a step is no state: it could not be made again.
    seek(before);
    throw;
  }
  arrive();
}

void Player::follow(BodyId body, bool soon) {
  if (history_->followed_body() == body) return;
  history_->follow_body(body);
  if (!soon && step() > 0) seek(step());
}

void Player::seek(std::uint64_t target) {
  const BodyId followed = history_->followed_body();
  // From before the state: its last step is made, so that the report of it is whole.
  auto from =
      std::lower_bound(keyframes_.begin(), keyframes_.end(), target,
                       [](const Keyframe& frame, std::uint64_t step) { return frame.demo.step() < step; });
  if (from != keyframes_.begin()) --from;
  // From here on when that is nearer than the keyframe.
  if (target <= step() || from->demo.step() > step()) {
    demo_->restore(from->demo);
    *history_ = from->history;
    history_->follow_body(followed);
    hand_ = from->hand;
    arrive();
  }
  while (step() < target) advance();
}

void Player::forget_after(std::uint64_t last) {
  hashes_.resize(last + 1);
  std::erase_if(inputs_, [&](const UserInput& input) { return input.step > last; });
  std::erase_if(keyframes_, [&](const Keyframe& frame) { return frame.demo.step() > last; });
  bytes_ = 0;
  for (const Keyframe& frame : keyframes_) bytes_ += bytes_of(frame);
  if (divergence_ && *divergence_ > last) divergence_.reset();
}

void Player::forget_future() {
  forget_after(step());
}

void Player::play_inputs(std::vector<UserInput> inputs) {
  inputs_ = std::move(inputs);
  apply_inputs();
}

void Player::input(UserInput input) {
  input.step = step();
  apply(input);
  forget_after(step());
  // Only the last of several drags before one step is felt.
  if (input.kind == InputKind::Drag && !inputs_.empty() && inputs_.back().step == input.step &&
      inputs_.back().kind == InputKind::Drag) {
    inputs_.back() = input;
    return;
  }
  inputs_.push_back(std::move(input));
}

}  // namespace skerry::sandbox
