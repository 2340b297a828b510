// SPDX-License-Identifier: MIT
#include "physics/stepping/island_energy.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/applied_forces.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Contacts that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 2048;

}  // namespace

bool is_free(const WorldState& state, const Island& island) {
  const auto reacts = [&](std::uint32_t body) {
    return body != BodyId::kNone && state.local_index[body] >= 0;
  };
  return !any_of(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    return !reacts(contact.body_a) || !reacts(contact.body_b);
  }) && std::all_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
    return reacts(state.joints[i].def.a.index) && reacts(state.joints[i].def.b.index);
  });
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
// What is gained is taken out at the end of a step; energy beyond so many times what there is moves bodies
// where they should not be before that.
constexpr double kWild = 1.5;

/// True if a kinematic body or a conveyor may bring energy.
bool ground_moves(const WorldState& state, const Island& island) {
  return any_of(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    return contact.surface_velocity != 0 || state.bodies.type[contact.body_a] == BodyType::Kinematic ||
           state.bodies.type[contact.body_b] == BodyType::Kinematic;
  });
}

/// True if joints may bring energy, or keep it.
bool is_driven(const WorldState& state, const Island& island) {
  return std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
    const JointDef& def = state.joints[i].def;
    const auto told = [&](BodyId body) {
      return body && state.bodies.type[body.index] == BodyType::Kinematic;
    };
    return def.motor_speed || def.stiffness > 0 || def.damping > 0 || told(def.a) || told(def.b);
  });
}

/// True if joints may bring any amount of energy.
bool has_no_bound(const WorldState& state, const Island& island) {
  return std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
    const JointDef& def = state.joints[i].def;
    const auto told = [&](BodyId body) {
      return body && state.bodies.type[body.index] == BodyType::Kinematic;
    };
    return (def.motor_speed && def.motor_limit == kInfinity) || told(def.a) || told(def.b);
  });
}

/// In the springs of an island [J].
double energy_of_springs(const WorldState& state, const Island& island) {
  double sum = 0;
  for (const std::uint32_t i : island.joints) sum += spring_energy(state, state.joints[i]);
  return sum;
}

/// What motors can bring in a time `h` [J]: they push only what is slower than they want.
double most_of_motors(const WorldState& state, const Island& island, double h) {
  double sum = 0;
  for (const std::uint32_t i : island.joints) {
    const JointDef& def = state.joints[i].def;
    if (def.motor_speed) sum += h * def.motor_limit * std::abs(*def.motor_speed);
  }
  return sum;
}

/// The motion of bodies against each other; against the ground, if they touch it. When it is scaled all
/// contacts keep their velocity zero or opening, joints hold, and a free island keeps its momenta.
struct InnerMotion {
  InnerMotion(const WorldState& state, const Island& island)
      : rigid(is_free(state, island) ? rigid_motion(state, island) : RigidMotion{}) {
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
      all.omega[i] = rigid.omega + s * (all.omega[i] - rigid.omega);
    }
  }

  RigidMotion rigid;
  double energy = 0;  ///< [J]
};

}  // namespace

IslandEnergy::IslandEnergy(const WorldState& state, const Island& island, bool known) : known_(known) {
  const BodyArrays& all = state.bodies;
  for (const std::uint32_t i : island.bodies) {
    start_->push_back({all.position[i], all.angle[i]});
    kinetic_ += 0.5 * all.mass[i] * length_squared(all.velocity[i]) +
                0.5 * all.inertia[i] * all.omega[i] * all.omega[i];
  }
  springs_ = energy_of_springs(state, island);
}

double IslandEnergy::gain(const WorldState& state, const Island& island) const {
  const BodyArrays& all = state.bodies;
  double gain = -kinetic_, kinetic = 0;
  for (std::size_t k = 0; k < start_->size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    const double m = all.mass[i], inertia = all.inertia[i];
    kinetic += 0.5 * m * length_squared(all.velocity[i]) + 0.5 * inertia * all.omega[i] * all.omega[i];
    gain -= m * dot(state.acceleration[i], all.position[i] - (*start_)[k].position) +
            inertia * state.angular_acceleration[i] * (all.angle[i] - (*start_)[k].angle);
  }
  gain += kinetic;
  return std::abs(gain) > 1e-15 * kinetic ? gain : 0;
}

bool IslandEnergy::is_unbounded(const WorldState& state, const Island& island) const {
  return has_no_bound(state, island) || ground_moves(state, island) ||
         (!known_ && has_varying_forces(state, island));
}

double IslandEnergy::unexplained_gain(const WorldState& state, const Island& island, double h) const {
  if (is_unbounded(state, island)) return 0;
  return gain(state, island) + (energy_of_springs(state, island) - springs_) -
         most_of_motors(state, island, h);
}

void IslandEnergy::take_gain(WorldState& state, const Island& island, double h) const {
  const double gained = unexplained_gain(state, island, h);
  if (gained > 0) InnerMotion(state, island).take(state, island, gained);
}

void IslandEnergy::take_much(WorldState& state, const Island& island, double h) const {
  const double gained = unexplained_gain(state, island, h);
  if (!(gained > 0)) return;
  double moved = kinetic_ + springs_;
  for (const std::uint32_t i : island.bodies)
    moved += state.bodies.mass[i] * h * h * length_squared(state.acceleration[i]);
  if (gained > kMuch * moved) InnerMotion(state, island).take(state, island, gained);
}

void IslandEnergy::bound(WorldState& state, const Island& island, double h,
                         std::vector<Velocity>& after) const {
  if (is_unbounded(state, island)) return;
  const BodyArrays& all = state.bodies;
  double available = kinetic_ + springs_ + most_of_motors(state, island, h), kinetic = 0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    const Vec2 v{after[k][0], after[k][1]};
    const double omega = after[k][2];
    kinetic += 0.5 * (all.mass[i] * length_squared(v) + all.inertia[i] * omega * omega);
    available += h * (all.mass[i] * dot(state.acceleration[i], v) +
                      all.inertia[i] * state.angular_acceleration[i] * omega);
  }
  if (!(kinetic > kWild * available)) return;
  Spare<std::vector<Velocity>> before;
  island_velocities(state, island, *before);
  store_velocities(state, island, after);
  InnerMotion(state, island).take(state, island, kinetic - available);
  island_velocities(state, island, after);
  store_velocities(state, island, *before);
}

void IslandEnergy::keep(WorldState& state, const Island& island, double work) const {
  if (ground_moves(state, island) || is_driven(state, island)) return;
  const double gained = gain(state, island) - work;
  if (gained == 0) return;
  const InnerMotion inner(state, island);
  const double small = island.contacts.empty() ? kSmallForJoints : kSmallCorrection;
  if (std::abs(gained) <= small * inner.energy)
    inner.scale(state, island, std::sqrt(1 - gained / inner.energy));
}

}  // namespace skerry
