// SPDX-License-Identifier: MIT
#include "physics/solver/joint_lines.h"

#include <algorithm>
#include <cmath>

#include "physics/disjoint_sets.h"
#include "physics/index.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Joints of a tree from which on it is one. Those of a person, ten, are answered as soon by some sweeps more.
constexpr int kLong = 11;
// Joints at one body at most, whose rows are all coupled with each other.
constexpr int kMostAtABody = 8;
// What is left of a row's own part, one, is rounding.
constexpr double kDependent = 1e-10;

}  // namespace

void JointLines::clear() {
  joints_.clear();
}

void JointLines::choose(std::span<const Joint> joints, int ground) {
  clear();
  if (joints.size() < kLong) return;
  DisjointSets trees(at(ground));
  Spare<std::vector<int>> degree;
  degree->assign(at(ground), 0);
  Spare<std::vector<std::uint8_t>> of_tree;
  of_tree->assign(joints.size(), 0);
  const auto is_full = [&](int body) { return body != ground && (*degree)[at(body)] >= kMostAtABody; };
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Joint& joint = joints[i];
    if (is_full(joint.a) || is_full(joint.b)) continue;
    if (joint.a != ground && joint.b != ground && !trees.join(joint.a, joint.b)) continue;
    for (const int body : {joint.a, joint.b})
      if (body != ground) ++(*degree)[at(body)];
    (*of_tree)[i] = 1;
  }
  const auto tree_of = [&](const Joint& joint) {
    return at(trees.root(joint.a != ground ? joint.a : joint.b));
  };
  Spare<std::vector<int>> size;
  size->assign(at(ground), 0);
  for (std::size_t i = 0; i < joints.size(); ++i) (*size)[tree_of(joints[i])] += (*of_tree)[i];
  Spare<std::vector<Joint>> chosen;
  for (std::size_t i = 0; i < joints.size(); ++i)
    if ((*of_tree)[i] != 0 && (*size)[tree_of(joints[i])] >= kLong) chosen->push_back(joints[i]);
  if (!chosen->empty()) order(*chosen, ground);
}

/// From the leaves inwards: those of the ground, then those of bodies of which one is left, in turn, so that
/// the two ends of a chain are gone through side by side.
void JointLines::order(std::span<const Joint> chosen, int ground) {
  Spare<std::vector<int>> beginning, of_body, left, queue;
  beginning->assign(at(ground) + 1, 0);
  left->assign(at(ground), 0);
  for (const Joint& joint : chosen)
    for (const int body : {joint.a, joint.b})
      if (body != ground) ++(*beginning)[at(body) + 1];
  for (std::size_t k = 0; k < at(ground); ++k) (*beginning)[k + 1] += (*beginning)[k];
  of_body->resize(at(beginning->back()));
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    for (const int body : {chosen[i].a, chosen[i].b})
      if (body != ground) (*of_body)[at((*beginning)[at(body)] + (*left)[at(body)]++)] = static_cast<int>(i);
  }
  Spare<std::vector<int>> place;  // in the order
  place->assign(chosen.size(), -1);
  const auto eliminate = [&](int i) {
    (*place)[at(i)] = static_cast<int>(joints_.size());
    joints_.push_back(chosen[at(i)]);
    for (const int body : {chosen[at(i)].a, chosen[at(i)].b})
      if (body != ground && --(*left)[at(body)] == 1) queue->push_back(body);
  };
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i].a == ground || chosen[i].b == ground) eliminate(static_cast<int>(i));
  queue->clear();
  for (int body = 0; body < ground; ++body)
    if ((*left)[at(body)] == 1) queue->push_back(body);
  for (std::size_t next = 0; next < queue->size(); ++next) {
    const int body = (*queue)[next];
    for (int k = (*beginning)[at(body)]; k < (*beginning)[at(body) + 1]; ++k)
      if ((*place)[at((*of_body)[at(k)])] < 0) eliminate((*of_body)[at(k)]);
  }

  // Which rows are coupled: those before a row in its joint, and those of joints before it at its bodies.
  rows_.clear();
  entries_.clear();
  first_.clear();
  joint_of_.clear();
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    first_.push_back(static_cast<int>(rows_.size()));
    for (int r = 0; r < joints_[k].count; ++r) {
      rows_.emplace_back();
      joint_of_.push_back(static_cast<int>(k));
    }
  }
  first_.push_back(static_cast<int>(rows_.size()));
  Spare<std::vector<int>> before;
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    before->clear();
    for (const int body : {joints_[k].a, joints_[k].b}) {
      if (body == ground) continue;
      for (int i = (*beginning)[at(body)]; i < (*beginning)[at(body) + 1]; ++i) {
        const int other = (*place)[at((*of_body)[at(i)])];
        if (other < static_cast<int>(k)) before->push_back(other);
      }
    }
    std::sort(before->begin(), before->end());
    for (int row = first_[k]; row < first_[k + 1]; ++row) {
      rows_[at(row)].first = static_cast<int>(entries_.size());
      for (const int other : *before)
        for (int i = first_[at(other)]; i < first_[at(other) + 1]; ++i) entries_.push_back({i, 0});
      for (int i = first_[k]; i < row; ++i) entries_.push_back({i, 0});
      rows_[at(row)].end = static_cast<int>(entries_.size());
    }
  }
}

void JointLines::take(std::size_t joint, const Rows& from) {
  for (int r = 0; r < joints_[joint].count; ++r) {
    Row& row = rows_[at(first_[joint] + r)];
    row.low = from.low[r];
    row.high = from.high[r];
    row.b = from.b[r];
    row.speed = from.speed[r];
  }
}

/// Entry of Q Q' of rows of two joints that have a body in common, or of one.
double JointLines::coupling(std::size_t row, std::size_t other) const {
  const Joint &p = joints_[at(joint_of_[row])], &q = joints_[at(joint_of_[other])];
  const Row &x = rows_[row], &y = rows_[other];
  double sum = 0;
  if (p.a == q.a) sum += dot3(x.low, y.low);
  if (p.a == q.b) sum += dot3(x.low, y.high);
  if (p.b == q.a) sum += dot3(x.high, y.low);
  if (p.b == q.b) sum += dot3(x.high, y.high);
  return sum;
}

/// L D L', row by row.
void JointLines::eliminate(double give, std::vector<std::uint8_t>& held) {
  give_ = give;
  held.assign(joints_.size(), 1);
  work_.assign(rows_.size(), 0);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    const double whole = coupling(i, i);
    double pivot = whole + give;
    // `work_` holds L D of this row.
    for (int e = row.first; e < row.end; ++e) {
      const Row& other = rows_[at(entries_[at(e)].row)];
      double sum = coupling(i, at(entries_[at(e)].row));
      for (int f = other.first; f < other.end; ++f) sum -= entries_[at(f)].l * work_[at(entries_[at(f)].row)];
      work_[at(entries_[at(e)].row)] = sum;
    }
    for (int e = row.first; e < row.end; ++e) {
      Entry& entry = entries_[at(e)];
      double& sum = work_[at(entry.row)];
      entry.l = sum * rows_[at(entry.row)].inverse;
      pivot -= entry.l * sum;
      sum = 0;
    }
    const bool depends = !(pivot > kDependent * whole);
    row.inverse = depends ? 0 : 1 / pivot;
    if (depends) held[at(joint_of_[i])] = 0;
  }
}

struct JointLines::Kernel {
  static SKERRY_ALWAYS_INLINE double run(JointLines& s, std::vector<BodyVector>& impulses,
                                         std::vector<BodyVector>& velocities) {
    double* const x = s.work_.data();
    BodyVector* const y = velocities.data();
    const Entry* const entries = s.entries_.data();
    double largest = 0;
    std::size_t i = 0;
    for (const Joint& joint : s.joints_) {
      const BodyVector a = y[joint.a], b = y[joint.b];
      for (int r = 0; r < joint.count; ++r, ++i) {
        const Row& row = s.rows_[i];
        double left = row.b - (dot3(row.low, a) + dot3(row.high, b));
        if (s.give_ != 0) left -= s.give_ * impulses[at(joint.block)].v[r];
        const double missed = std::abs(left) * row.speed;
        largest = largest < missed ? missed : largest;
        for (int e = row.first; e < row.end; ++e) left -= entries[e].l * x[entries[e].row];
        x[i] = left;
      }
    }
    for (std::size_t k = 0; k < s.rows_.size(); ++k) x[k] *= s.rows_[k].inverse;
    for (std::size_t j = s.joints_.size(); j-- > 0;) {
      const Joint& joint = s.joints_[j];
      Vec4 a = y[joint.a].v, b = y[joint.b].v;
      for (int r = joint.count; r-- > 0;) {
        const Row& row = s.rows_[--i];
        const double change = x[i];
        for (int e = row.first; e < row.end; ++e) x[entries[e].row] -= entries[e].l * change;
        impulses[at(joint.block)].v[r] += change;
        a += row.low.v * change;
        b += row.high.v * change;
      }
      // The rows of the ground are zeros.
      y[joint.a].v = a;
      y[joint.b].v = b;
    }
    return largest;
  }
};

double JointLines::answer(std::vector<BodyVector>& impulses, std::vector<BodyVector>& velocities) {
  return run_kernel<Kernel>(*this, impulses, velocities);
}

}  // namespace skerry
