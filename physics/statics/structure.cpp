// SPDX-License-Identifier: MIT
#include "physics/statics/structure.h"

#include <cmath>
#include <stdexcept>

#include "physics/text.h"

namespace skerry::statics {
namespace {

[[noreturn]] void fail(const char* what, std::size_t index, const std::string& why) {
  throw std::invalid_argument(std::string(what) + ' ' + std::to_string(index + 1) + ": " + why);
}

void check_index(const char* what, std::size_t index, const char* of, int value, std::size_t count) {
  if (value < 0 || static_cast<std::size_t>(value) >= count) {
    fail(what, index,
         std::string("no ") + of + ' ' + std::to_string(value + 1) + ", there are " + std::to_string(count));
  }
}

void check_at_least_zero(const char* what, std::size_t index, const char* name, double value) {
  if (!(value >= 0)) fail(what, index, std::string(name) + " must not be negative, got " + to_text(value));
  if (!std::isfinite(value)) fail(what, index, std::string(name) + " must be finite, got " + to_text(value));
}

}  // namespace

void validate(const Structure& s) {
  for (std::size_t i = 0; i < s.nodes.size(); ++i) {
    if (!is_finite(s.nodes[i].at))
      fail("node", i,
           "position must be finite, got " + to_text(s.nodes[i].at.x) + ", " + to_text(s.nodes[i].at.y));
  }
  for (std::size_t i = 0; i < s.members.size(); ++i) {
    const Member& m = s.members[i];
    check_index("member", i, "node", m.a, s.nodes.size());
    check_index("member", i, "node", m.b, s.nodes.size());
    if (m.a == m.b) fail("member", i, "both ends are node " + std::to_string(m.a + 1));
    const double length = member_length(s, static_cast<int>(i));
    if (!(length > 0)) fail("member", i, "its ends must be apart, got a length of " + to_text(length));
    check_at_least_zero("member", i, "modulus", m.modulus);
    check_at_least_zero("member", i, "area", m.area);
    check_at_least_zero("member", i, "second_moment", m.second_moment);
    check_at_least_zero("member", i, "depth", m.depth);
    check_at_least_zero("member", i, "density", m.density);
    if (!(m.strength > 0)) fail("member", i, "strength must be positive, got " + to_text(m.strength));
  }
  std::vector<char> supported(s.nodes.size(), 0);
  for (std::size_t i = 0; i < s.supports.size(); ++i) {
    const Support& support = s.supports[i];
    check_index("support", i, "node", support.node, s.nodes.size());
    if (!std::isfinite(support.angle))
      fail("support", i, "angle must be finite, got " + to_text(support.angle));
    if (supported[static_cast<std::size_t>(support.node)]++)
      fail("support", i, node_label(s, support.node) + " has a support already");
  }
}

void validate(const Structure& s, const Load& load) {
  for (std::size_t i = 0; i < load.nodes.size(); ++i) {
    check_index("load", i, "node", load.nodes[i].node, s.nodes.size());
    if (!is_finite(load.nodes[i].force))
      fail("load", i, "force must be finite, got " + to_text(load.nodes[i].force));
    if (!std::isfinite(load.nodes[i].moment))
      fail("load", i, "moment must be finite, got " + to_text(load.nodes[i].moment));
  }
  for (std::size_t i = 0; i < load.spans.size(); ++i) {
    check_index("span load", i, "member", load.spans[i].member, s.members.size());
    if (!is_finite(load.spans[i].force))
      fail("span load", i, "force must be finite, got " + to_text(load.spans[i].force));
    if (!(load.spans[i].share >= 0 && load.spans[i].share <= 1))
      fail("span load", i, "share must be from 0 to 1, got " + to_text(load.spans[i].share));
  }
  for (std::size_t i = 0; i < load.lines.size(); ++i) {
    check_index("line load", i, "member", load.lines[i].member, s.members.size());
    if (!is_finite(load.lines[i].force_per_length))
      fail("line load", i, "force_per_length must be finite, got " + to_text(load.lines[i].force_per_length));
  }
}

Load self_weight(const Structure& s, Vec2 gravity) {
  Load load;
  for (std::size_t i = 0; i < s.members.size(); ++i) {
    const double weight = s.members[i].density * s.members[i].area;
    if (weight > 0) load.lines.push_back({static_cast<int>(i), weight * gravity});
  }
  return load;
}

std::string node_label(const Structure& s, int node) {
  const std::string& name = s.nodes[static_cast<std::size_t>(node)].name;
  return "node " + (name.empty() ? std::to_string(node + 1) : name);
}

double member_length(const Structure& s, int member) {
  const Member& m = s.members[static_cast<std::size_t>(member)];
  return length(s.nodes[static_cast<std::size_t>(m.b)].at - s.nodes[static_cast<std::size_t>(m.a)].at);
}

double buckling_load(const Structure& s, int member) {
  const Member& m = s.members[static_cast<std::size_t>(member)];
  if (m.kind != MemberKind::Bar || !(m.modulus * m.second_moment > 0)) return kInfinity;
  const double length = member_length(s, member);
  return kPi * kPi * m.modulus * m.second_moment / (length * length);
}

}  // namespace skerry::statics
