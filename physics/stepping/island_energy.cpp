// SPDX-License-Identifier: MIT
#include "physics/stepping/island_energy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/solver/impact_tools.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/joint_midpoint.h"
#include "physics/stepping/kinematic.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Contacts, or joints, that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 2048;

/// True if one of the contact's points is loaded.
bool pushes(const Contact& contact) {
  for (int i = 0; i < contact.manifold.count; ++i)
    if (contact.points[i].normal_impulse > 0) return true;
  return false;
}

/// True if no joint, and no contact of which `counts` is true, is with something that does not react.
template <class Counts>
bool is_free(const WorldState& state, const Island& island, const Counts& counts) {
  const auto reacts = [&](std::uint32_t body) {
    return body != BodyId::kNone && state.local_index[body] >= 0;
  };
  return !any_of(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    return (!reacts(contact.body_a) || !reacts(contact.body_b)) && counts(contact);
  }) && !any_of(state.island_threads, island.joints.size(), kContactsAPiece, [&](std::size_t k) {
    const JointDef& def = state.joints[island.joints[k]].def;
    return !reacts(def.a.index) || !reacts(def.b.index);
  });
}

}  // namespace

bool is_free(const WorldState& state, const Island& island) {
  return is_free(state, island, [](const Contact&) { return true; });
}

bool is_off_ground(const WorldState& state, const Island& island) {
  return is_free(state, island,
                 [&](const Contact& contact) { return pushes(contact) || touches(state, contact); });
}

bool is_unpushed(const WorldState& state, const Island& island) {
  return is_free(state, island, pushes);
}

RigidMotion rigid_motion(const WorldState& state, const Island& island) {
  const BodyArrays& all = state.bodies;
  RigidMotion r;
  double mass = 0;
  for (const std::uint32_t i : island.bodies) {
    mass += all.mass[i];
    r.centre += all.mass[i] * all.position[i];
    r.v += all.mass[i] * all.velocity[i];
  }
  r.centre = r.centre / mass;
  r.v = r.v / mass;
  for (const std::uint32_t i : island.bodies) {
    const Vec2 arm = all.position[i] - r.centre;
    r.inertia += all.inertia[i] + all.mass[i] * length_squared(arm);
    r.momentum += all.inertia[i] * all.omega[i] + all.mass[i] * cross(arm, all.velocity[i] - r.v);
  }
  r.omega = r.inertia > 0 ? r.momentum / r.inertia : 0;
  return r;
}

namespace {

// Projections that change more than this share of the energy are no corrections of a smooth motion: contacts
// come and go, joints stay.
constexpr double kSmallCorrection = 1e-3;
constexpr double kSmallForJoints = 0.25;
// Share of the energy that moves, above which a gain is no error of a smooth motion.
constexpr double kMuch = 0.01;
// The same, above which energy comes or goes by stepping over something fast.
constexpr double kChange = 1e-3;
// What is gained is taken out at the end of a step; energy beyond so many times what there is moves bodies
// where they should not be before that.
constexpr double kWild = 1.5;
// The same that forces of an answer never bring: not even the momentum of what they made is right.
constexpr double kNoAnswer = 1e8;
// What is told to move makes nothing faster than so many times its own speed, by levers and blows; where
// there are no joints, by wedges (`impact::kWedge`).
constexpr double kLever = 4;

bool is_kinematic(const WorldState& state, std::uint32_t body) {
  return body != BodyId::kNone && state.bodies.type[body] == BodyType::Kinematic;
}

/// True if what the contact is with may bring energy: a body that moves as it is told, or a conveyor.
bool ground_moves(const WorldState& state, const Contact& contact) {
  return contact.surface_velocity != 0 || moves_as_told(state, contact.body_a) ||
         moves_as_told(state, contact.body_b);
}

bool ground_moves(const WorldState& state, const Island& island) {
  return any_of(state.island_threads, island.contacts.size(), kContactsAPiece,
                [&](std::size_t k) { return ground_moves(state, state.contacts[island.contacts[k]]); });
}

/// True if ground that moves touches, or joints held something to it in the last piece.
bool ground_takes_along(const WorldState& state, const Island& island) {
  return any_of(state.island_threads, island.contacts.size(), kContactsAPiece,
                [&](std::size_t k) {
                  const Contact& contact = state.contacts[island.contacts[k]];
                  return ground_moves(state, contact) && (pushes(contact) || touches(state, contact));
                }) ||
         any_of(state.island_threads, island.joints.size(), kContactsAPiece, [&](std::size_t k) {
           const std::uint32_t slot = island.joints[k];
           const JointDef& def = state.joints[slot].def;
           return (moves_as_told(state, def.a.index) || moves_as_told(state, def.b.index)) &&
                  (holds_always(def) || state.held_rows[slot] != 0);
         });
}

/// True if joints may bring energy, or keep it.
bool is_driven(const WorldState& state, const Island& island) {
  return std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
    const JointDef& def = state.joints[i].def;
    return def.motor_speed || def.stiffness > 0 || def.damping > 0 || is_kinematic(state, def.a.index) ||
           is_kinematic(state, def.b.index);
  });
}

/// How far apart a joint lets its anchors be [m].
double span_of(const WorldState& state, const JointRecord& joint) {
  switch (joint.def.kind) {
    case JointKind::Distance:
    case JointKind::Rope:
      if (joint.length > 0 && !joint.def.upper) return joint.length;
      [[fallthrough]];
    case JointKind::Prismatic:
    case JointKind::Wheel:
    case JointKind::Spring:
      return std::abs(
          joint_coordinate(joint, joint_end(state, joint.def.a.index), joint_end(state, joint.def.b.index))
              .value);
    default:
      return 0;
  }
}

/// How far out of its centre a body may have its mass: a given moment of inertia may be larger than that of
/// its shapes [m].
double size_of(const WorldState& state, std::uint32_t i) {
  const double mass = state.bodies.mass[i];
  return std::max(state.radius[i], mass > 0 ? std::sqrt(state.bodies.inertia[i] / mass) : 0);
}

/// The fastest that a kinematic body is in the step, whenever in it something is asked: what begins from rest
/// may strike before it ends.
struct ToldMotion {
  std::uint32_t body = BodyId::kNone;
  double speed = 0, turning = 0;  ///< [m/s], [rad/s]

  ToldMotion() = default;
  ToldMotion(const WorldState& state, std::uint32_t told) : body(told) {
    const auto look = [&](double time) {
      const KinematicState now = kinematic_state(state, told, time);
      speed = std::max(speed, length(now.v));
      turning = std::max(turning, std::abs(now.omega));
    };
    look(0);
    if (!state.prescribed[told]) return;
    constexpr int kTimes = 8;
    constexpr double kJustBefore = 1 - 1e-13;
    const MotionPath& path = state.paths[told];
    for (int k = 1; k <= kTimes; ++k) look(path.length() * k / kTimes);
    double last = 0;
    for (const double end : path.breaks()) {
      look(0.5 * (last + end));
      look(end * kJustBefore);
      look(end);
      last = end;
    }
  }
};

}  // namespace

double told_speed(const WorldState& state, const Island& island, double h) {
  const BodyArrays& all = state.bodies;
  double turning = 0;
  for (const std::uint32_t i : island.bodies)
    if (all.inverse_inertia[i] == 0) turning = std::max(turning, std::abs(all.omega[i]) * state.radius[i]);
  // Most mechanisms have nothing that drives them.
  const auto drives = [&](std::uint32_t i) {
    return state.joints[i].def.motor_speed && !(state.joints[i].def.motor_limit < kInfinity);
  };
  if (island.contacts.empty() && state.kinematic.empty() &&
      std::none_of(island.joints.begin(), island.joints.end(), drives))
    return turning;
  Aabb box{all.position[island.bodies.front()], all.position[island.bodies.front()]};
  double longest = 0, largest = 0;
  for (const std::uint32_t i : island.bodies) {
    box = united(box, {all.position[i], all.position[i]});
    longest += 2 * size_of(state, i);
    largest = std::max(largest, size_of(state, i));
  }
  const Vec2 middle = 0.5 * (box.lower + box.upper);
  const double radius = 0.5 * length(box.upper - box.lower);
  // What turns takes along what is far away from it, but no farther than bodies, and joints, reach: these may
  // be torn.
  const auto speed_of = [&](std::uint32_t body, double joint, ToldMotion& told) {
    if (body == BodyId::kNone || all.type[body] != BodyType::Kinematic) return 0.0;
    if (told.body != body) told = ToldMotion(state, body);
    double most = 0;
    for (const double time : {0.0, h}) {
      const KinematicState now = kinematic_state(state, body, time);
      const double arm =
          std::min(length(now.p - middle) + radius + largest, state.radius[body] + longest + joint);
      most = std::max(most, told.speed + told.turning * arm);
    }
    return most;
  };
  const auto fastest_of = [&](std::size_t from, std::size_t to) {
    double most = 0;
    ToldMotion told;
    for (std::size_t k = from; k < to; ++k) {
      const Contact& contact = state.contacts[island.contacts[k]];
      most = std::max(most, std::abs(contact.surface_velocity));
      if (!state.kinematic.empty())
        most = std::max({most, speed_of(contact.body_a, 0, told), speed_of(contact.body_b, 0, told)});
    }
    return most;
  };
  double most = std::max(
      turning, largest_of(state.island_threads, island.contacts.size(), kContactsAPiece, fastest_of));
  ToldMotion motion;
  for (const std::uint32_t i : island.joints) {
    const JointRecord& joint = state.joints[i];
    const JointDef& def = joint.def;
    const double span = state.kinematic.empty() ? 0 : span_of(state, joint);
    most = std::max({most, speed_of(def.a.index, span + length(joint.local_a), motion),
                     speed_of(def.b.index, span + length(joint.local_b), motion)});
    if (!drives(i)) continue;
    double arm = 1;
    if (def.kind == JointKind::Revolute || def.kind == JointKind::Wheel || def.kind == JointKind::Motor) {
      // Its bodies turn about the anchor, and take along what they are joined to.
      arm = std::min(2 * radius, longest);
      for (const auto& [body, anchor] :
           {std::pair{def.a.index, joint.local_a}, std::pair{def.b.index, joint.local_b}})
        if (body != BodyId::kNone && all.type[body] == BodyType::Dynamic)
          arm += length(anchor) + size_of(state, body);
    }
    most = std::max(most, arm * std::abs(*def.motor_speed));
  }
  return most;
}

namespace {

/// In the springs of an island [J].
double energy_of_springs(const WorldState& state, const Island& island, double elapsed) {
  if (state.springs == 0) return 0;
  double sum = 0;
  for (const std::uint32_t i : island.joints) sum += spring_energy(state, state.joints[i], elapsed);
  return sum;
}

/// What motors with a limit can bring in a time `h` [J]: they push only what is slower than they want.
double most_of_motors(const WorldState& state, const Island& island, double h) {
  double sum = 0;
  for (const std::uint32_t i : island.joints) {
    const JointDef& def = state.joints[i].def;
    if (def.motor_speed && def.motor_limit < kInfinity)
      sum += h * def.motor_limit * std::abs(*def.motor_speed);
  }
  return sum;
}

/// Of any point of a body [m/s].
double speed_of(const WorldState& state, std::uint32_t i) {
  return length(state.bodies.velocity[i]) + std::abs(state.bodies.omega[i]) * state.radius[i];
}

/// An energy, and the most that the forces on bodies as fast as these bring in a time `h` [J].
double with_work_of_forces(const WorldState& state, const Island& island, double h, double energy) {
  for (const std::uint32_t i : island.bodies)
    energy += h * state.bodies.mass[i] * length(state.acceleration[i]) * speed_of(state, i);
  return energy;
}

/// Whether ground of the island that is told to move goes straight on at one velocity.
bool ground_is_steady(const WorldState& state, const Island& island) {
  if (state.kinematic.empty()) return true;
  const auto is_steady = [&](std::uint32_t body) {
    return !moves_as_told(state, body) || (!state.prescribed[body] && state.bodies.omega[body] == 0);
  };
  return !any_of(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    return !is_steady(contact.body_a) || !is_steady(contact.body_b);
  });
}

/// The motion of ground that touches the island or pushes it: nothing where it is not all the same, and
/// straight.
RigidMotion motion_of_ground(const WorldState& state, const Island& island) {
  RigidMotion ground;
  if (state.kinematic.empty() || !island.joints.empty() || !ground_is_steady(state, island)) return ground;
  bool first = true;
  for (const std::uint32_t index : island.contacts) {
    const Contact& contact = state.contacts[index];
    for (const std::uint32_t body : {contact.body_a, contact.body_b}) {
      if (body == BodyId::kNone || state.local_index[body] >= 0) continue;
      if (!pushes(contact) && !touches(state, contact)) continue;
      const Vec2 v = state.bodies.velocity[body];
      if (!first && v != ground.v) return {};
      ground.v = v;
      first = false;
    }
  }
  return ground;
}

/// The motion of bodies against each other; against the ground, if they touch it. When it is scaled all
/// contacts keep their velocity zero or opening, joints hold, and a free island keeps its momenta. What turns
/// with an infinite moment of inertia goes on as it does.
struct InnerMotion {
  InnerMotion(const WorldState& state, const Island& island)
      : rigid(is_off_ground(state, island) ? rigid_motion(state, island) : motion_of_ground(state, island)) {
    const BodyArrays& all = state.bodies;
    for (const std::uint32_t i : island.bodies) {
      const Vec2 v = all.velocity[i] - rigid.at(all.position[i]);
      const double w = all.omega[i] - rigid.omega;
      energy += 0.5 * all.mass[i] * length_squared(v) + 0.5 * all.inertia[i] * w * w;
    }
  }

  void take(WorldState& state, const Island& island, double gained) const {
    if (energy > 0) scale(state, island, std::sqrt(std::max(0.0, 1 - gained / energy)));
  }

  void scale(WorldState& state, const Island& island, double s) const {
    BodyArrays& all = state.bodies;
    for (const std::uint32_t i : island.bodies) {
      const Vec2 carried = rigid.at(all.position[i]);
      all.velocity[i] = carried + s * (all.velocity[i] - carried);
      if (all.inverse_inertia[i] > 0) all.omega[i] = rigid.omega + s * (all.omega[i] - rigid.omega);
    }
  }

  RigidMotion rigid;
  double energy = 0;  ///< [J]
};

}  // namespace

bool may_be_given_energy(const WorldState& state, const Island& island) {
  return ground_moves(state, island) || is_driven(state, island);
}

IslandEnergy::IslandEnergy(const WorldState& state, const Island& island, bool known, double elapsed)
    : elapsed_(elapsed), known_(known) {
  const BodyArrays& all = state.bodies;
  note_places(state, island, *start_);
  for (const std::uint32_t i : island.bodies) {
    kinetic_ += 0.5 * all.mass[i] * length_squared(all.velocity[i]) +
                0.5 * all.inertia[i] * all.omega[i] * all.omega[i];
  }
  springs_ = energy_of_springs(state, island, elapsed_);
}

void IslandEnergy::note_places(const WorldState& state, const Island& island, std::vector<Place>& places) {
  places.clear();
  for (const std::uint32_t i : island.bodies)
    places.push_back({state.bodies.position[i], state.bodies.angle[i]});
}

void IslandEnergy::end_motion(const WorldState& state, const Island& island) {
  note_places(state, island, *end_);
}

double IslandEnergy::gain(const WorldState& state, const Island& island, bool drag) const {
  const BodyArrays& all = state.bodies;
  double gain = -kinetic_, kinetic = 0;
  for (std::size_t k = 0; k < start_->size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    const double m = all.mass[i], inertia = all.inertia[i];
    kinetic += 0.5 * m * length_squared(all.velocity[i]) + 0.5 * inertia * all.omega[i] * all.omega[i];
    Vec2 a = state.acceleration[i];
    double alpha = state.angular_acceleration[i];
    if (!drag && state.drag[i].any()) {
      const JointEnd at_rest{all.position[i], all.rotation[i], all.angle[i], {}, 0};
      const std::array<double, 3> applied = applied_acceleration(state, i, at_rest, 0);
      a = {applied[0], applied[1]};
      alpha = applied[2];
    }
    const Place now = end_->empty() ? Place{all.position[i], all.angle[i]} : (*end_)[k];
    gain -=
        m * dot(a, now.position - (*start_)[k].position) + inertia * alpha * (now.angle - (*start_)[k].angle);
  }
  gain += kinetic;
  return std::abs(gain) > 1e-15 * kinetic ? gain : 0;
}

bool IslandEnergy::is_unknown(const WorldState& state) const {
  return !known_ && state.field;
}

namespace {

/// Most that what is told to move at `speed` brings bodies of the energy `kinetic` while it turns them round
/// [J]: in its frame they stay as fast as they were.
double most_of_turn(const WorldState& state, const Island& island, double speed, double kinetic) {
  double mass = 0;
  for (const std::uint32_t i : island.bodies) mass += state.bodies.mass[i];
  return 2 * speed * std::sqrt(2 * mass * kinetic);
}

/// What can be given to an island by what makes bodies no faster than `most` [m/s] in a time `h` [s] [J].
struct Drive {
  Drive(const WorldState& state, const Island& island, double most, double h) {
    if (most == 0) return;
    for (const std::uint32_t i : island.bodies) {
      const double m = state.bodies.mass[i];
      kinetic += 0.5 * m * most * most;
      work += h * most * m * length(state.acceleration[i]);
    }
  }
  double kinetic = 0;  ///< of all bodies at the fastest that it makes them
  double work = 0;     ///< against the forces that act on them
};

}  // namespace

double IslandEnergy::unexplained_gain(const WorldState& state, const Island& island, double h,
                                      double most) const {
  if (is_unknown(state)) return 0;
  double springs = energy_of_springs(state, island, elapsed_) - springs_;
  // What is told to move may wind springs up.
  if (most > 0) springs = std::min(springs, 0.0);
  const Drive drive(state, island, most, h);
  return gain(state, island, known_) + springs - most_of_motors(state, island, h) -
         std::max(0.0, drive.kinetic - kinetic_) - drive.work;
}

bool IslandEnergy::has_more(const WorldState& state, const Island& island, double h) const {
  const BodyArrays& all = state.bodies;
  const double available = with_work_of_forces(state, island, h, kinetic_);
  return std::any_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t i) {
    return length_squared(all.velocity[i]) > 2 * available * all.inverse_mass[i];
  });
}

void IslandEnergy::slow_down(WorldState& state, const Island& island, double told, double h,
                             double more) const {
  if (told == 0) return;
  const double lever = island.joints.empty() ? impact::kWedge : kLever;
  const BodyArrays& all = state.bodies;
  const double available =
      with_work_of_forces(state, island, h, kinetic_ + more + springs_ + most_of_motors(state, island, h));
  double share = 1;
  for (const std::uint32_t i : island.bodies) {
    const double speed = length(all.velocity[i]);
    const double turned = h > 0 ? 0 : 2 * told;
    const double limit = std::max(lever * told, std::sqrt(2 * available * all.inverse_mass[i]) + turned);
    if (speed > limit) share = std::min(share, limit / speed);
  }
  if (share < 1) InnerMotion(state, island).scale(state, island, share);
}

void IslandEnergy::take_gain(WorldState& state, const Island& island, double h,
                             std::optional<double> brought) const {
  const bool jointed = !island.joints.empty();
  if (!jointed && ground_moves(state, island)) return take_push(state, island, h, brought);
  const double told = jointed ? told_speed(state, island, h) : 0;
  const double gained = unexplained_gain(state, island, h, kLever * told);
  if (gained > 0) InnerMotion(state, island).take(state, island, gained);
  slow_down(state, island, told, h, 0);
}

void IslandEnergy::take_push(WorldState& state, const Island& island, double h,
                             std::optional<double> brought) const {
  if (is_unknown(state)) return;
  const double all = gain(state, island, known_);
  const double most = brought.value_or(kInfinity);
  if (!(all > std::min(0.0, most)) && !has_more(state, island, h)) return;
  const double told = told_speed(state, island, h);
  const Drive drive(state, island, impact::kWedge * told, h);
  const double turned = h > 0 ? 0 : most_of_turn(state, island, told, kinetic_);
  const double gained = all - std::min(most, drive.kinetic + turned + drive.work);
  if (gained > 0) InnerMotion(state, island).take(state, island, gained);
  slow_down(state, island, told, h, 0);
}

void IslandEnergy::take_much(WorldState& state, const Island& island, double h, double brought,
                             double& passed) const {
  const double told = told_speed(state, island, h);
  // Levers and gears make bodies faster; an answer brings no more than its rows say.
  const Drive levers(state, island, impact::kWedge * told, h);
  const double most = std::max(most_of_turn(state, island, told, kinetic_), levers.kinetic + levers.work);
  const double more = std::clamp(brought, 0.0, most);
  passed = std::max(0.0, passed + unexplained_gain(state, island, h, kLever * told) - more);
  if (is_much(state, island, h, passed))
    InnerMotion(state, island).take(state, island, std::exchange(passed, 0));
  slow_down(state, island, told, h, more);
}

bool IslandEnergy::gained_much(const WorldState& state, const Island& island, double h) const {
  const double told = told_speed(state, island, h);
  return is_much(state, island, h,
                 unexplained_gain(state, island, h, impact::kWedge * told) -
                     most_of_turn(state, island, told, kinetic_));
}

bool IslandEnergy::changed(const WorldState& state, const Island& island, double h) const {
  return std::abs(gain(state, island, known_)) > kChange * moved(state, island, h);
}

double IslandEnergy::moved(const WorldState& state, const Island& island, double h) const {
  double moved = kinetic_ + springs_;
  for (const std::uint32_t i : island.bodies)
    moved += state.bodies.mass[i] * h * h * length_squared(state.acceleration[i]);
  return moved;
}

bool IslandEnergy::is_much(const WorldState& state, const Island& island, double h, double gained) const {
  return gained > 0 && gained > kMuch * moved(state, island, h);
}

void IslandEnergy::bound(WorldState& state, const Island& island, double h,
                         std::vector<Velocity>& after) const {
  if (is_unknown(state)) return;
  const BodyArrays& all = state.bodies;
  const bool jointed = !island.joints.empty();
  double kinetic = 0, forces = 0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    const Vec2 v{after[k][0], after[k][1]};
    const double omega = after[k][2];
    kinetic += 0.5 * (all.mass[i] * length_squared(v) + all.inertia[i] * omega * omega);
    forces += h * (all.mass[i] * dot(state.acceleration[i], v) +
                   all.inertia[i] * state.angular_acceleration[i] * omega);
  }
  // What is told to move costs a look at all contacts.
  if (!jointed && kinetic <= kWild * (kinetic_ + forces)) return;
  const double told = told_speed(state, island, h);
  const Drive drive(state, island, (jointed ? kLever : impact::kWedge) * told, h);
  const double available =
      std::max(kinetic_, drive.kinetic) + springs_ + most_of_motors(state, island, h) + forces;
  const bool wild = kinetic > kWild * available;
  if (!wild && told == 0) return;
  Spare<std::vector<Velocity>> before;
  island_velocities(state, island, *before);
  if (!(kinetic <= kNoAnswer * available)) {
    std::swap(after, *before);
    return;
  }
  store_velocities(state, island, after);
  if (wild) InnerMotion(state, island).take(state, island, kinetic - available);
  slow_down(state, island, told, h, 0);
  island_velocities(state, island, after);
  store_velocities(state, island, *before);
}

void IslandEnergy::keep(WorldState& state, const Island& island, double work) const {
  if (ground_takes_along(state, island)) return;
  const double gained =
      gain(state, island, true) + energy_of_springs(state, island, elapsed_) - springs_ - work;
  if (gained == 0) return;
  const InnerMotion inner(state, island);
  const double small = island.contacts.empty() ? kSmallForJoints : kSmallCorrection;
  if (gained <= inner.energy && gained >= -small * inner.energy)
    inner.scale(state, island, std::sqrt(1 - gained / inner.energy));
}

}  // namespace skerry
