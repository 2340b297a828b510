// SPDX-License-Identifier: MIT
//
// Peers behind one interface, each used as its documentation says and with its own defaults. Each is there
// only if CMake found it; SKERRY_WITH_... holds its version. Pairs are counted, not stored or sorted.
#include <algorithm>

#include "tests/bench/broadphase_scenes.h"

#ifdef SKERRY_WITH_BOX2D
#include <box2d/box2d.h>
#endif
#ifdef SKERRY_WITH_CHIPMUNK
#include <chipmunk/chipmunk.h>
#endif
#ifdef SKERRY_WITH_BULLET
#include <btBulletCollisionCommon.h>
#endif
#ifdef SKERRY_WITH_ODE
#include <ode/ode.h>
#endif
#ifdef SKERRY_WITH_CGAL
#include <CGAL/Bbox_2.h>
#include <CGAL/Box_intersection_d/Box_with_handle_d.h>
#include <CGAL/box_intersection_d.h>
#endif
#ifdef SKERRY_WITH_BOOST
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>
#endif

namespace skerry::bench {

namespace {

#ifdef SKERRY_WITH_BOX2D
/// b2BroadPhase: single precision, boxes with margins; reports new pairs of the margins only.
class Box2d final : public PairBench {
 public:
  void build(const BoxScene& scene) override {
    for (std::size_t i = 0; i < scene.boxes().size(); ++i) {
      ids_.push_back(tree_.CreateProxy(convert(scene.boxes()[i]), reinterpret_cast<void*>(i)));
    }
    tree_.UpdatePairs(this);
    last_ = scene.boxes();
  }
  std::size_t step(const BoxScene&, const std::vector<BoxUpdate>& updates) override {
    count_ = 0;
    for (const BoxUpdate& u : updates) {
      const Vec2 by = u.box.lower - last_[u.proxy].lower;
      tree_.MoveProxy(ids_[u.proxy], convert(u.box), b2Vec2(float(by.x), float(by.y)));
      last_[u.proxy] = u.box;
    }
    tree_.UpdatePairs(this);
    return count_;
  }
  void AddPair(void*, void*) { ++count_; }

 private:
  static b2AABB convert(const Aabb& box) {
    b2AABB b;
    b.lowerBound.Set(float(box.lower.x), float(box.lower.y));
    b.upperBound.Set(float(box.upper.x), float(box.upper.y));
    return b;
  }
  b2BroadPhase tree_;
  std::vector<int32> ids_;
  std::vector<Aabb> last_;
  std::size_t count_ = 0;
};
#endif

#ifdef SKERRY_WITH_CHIPMUNK
/// Chipmunk's two indices through cpSpatialIndex; sleeping boxes are in a static index, as cpSpace does it.
class Chipmunk : public PairBench {
 public:
  ~Chipmunk() override {
    cpSpatialIndexFree(moving_);
    cpSpatialIndexFree(resting_);
  }
  void build(const BoxScene& scene) override {
    make(scene);
    const std::size_t count = scene.boxes().size();
    objects_.resize(count);
    std::vector<char> is_active(count, 0);
    for (const std::uint32_t i : scene.active()) is_active[i] = 1;
    for (std::size_t i = 0; i < count; ++i) {
      objects_[i] = convert(scene.boxes()[i]);
      cpSpatialIndexInsert(is_active[i] ? moving_ : resting_, &objects_[i], i);
    }
  }
  std::size_t step(const BoxScene&, const std::vector<BoxUpdate>& updates) override {
    count_ = 0;
    for (const BoxUpdate& u : updates) objects_[u.proxy] = convert(u.box);
    cpSpatialIndexReindexQuery(moving_, &Chipmunk::found, this);
    return count_;
  }

 protected:
  virtual void make(const BoxScene& scene) = 0;
  static cpBB bounds(void* object) { return *static_cast<cpBB*>(object); }
  cpSpatialIndex* moving_ = nullptr;
  cpSpatialIndex* resting_ = nullptr;

 private:
  static cpBB convert(const Aabb& b) { return cpBBNew(b.lower.x, b.lower.y, b.upper.x, b.upper.y); }
  static cpCollisionID found(void* a, void* b, cpCollisionID id, void* self) {
    static_cast<Chipmunk*>(self)->count_ += cpBBIntersects(bounds(a), bounds(b));
    return id;
  }
  std::vector<cpBB> objects_;
  std::size_t count_ = 0;
};

class ChipmunkTree final : public Chipmunk {
  void make(const BoxScene&) override {
    resting_ = cpBBTreeNew(&bounds, nullptr);
    moving_ = cpBBTreeNew(&bounds, resting_);
  }
};

class ChipmunkHash final : public Chipmunk {
  void make(const BoxScene& scene) override {
    // As its manual says: cells of about the mean size, ten times as many cells as boxes.
    double sum = 0;
    for (const Aabb& box : scene.boxes()) sum += std::min(20.0, box.upper.x - box.lower.x);
    const double size = 1.5 * sum / static_cast<double>(scene.boxes().size());
    const int cells = 10 * static_cast<int>(scene.boxes().size());
    resting_ = cpSpaceHashNew(size, cells, &bounds, nullptr);
    moving_ = cpSpaceHashNew(size, cells, &bounds, resting_);
  }
};
#endif

#ifdef SKERRY_WITH_BULLET
/// Bullet's broad phases in three dimensions; all boxes have the same extent along z.
template <class BroadPhaseType>
class Bullet : public PairBench {
 public:
  ~Bullet() override {
    for (btBroadphaseProxy* proxy : proxies_) broad_phase_->destroyProxy(proxy, nullptr);
  }
  void build(const BoxScene& scene) override {
    broad_phase_ = make(scene);
    for (const Aabb& b : scene.boxes()) {
      const auto [lower, upper] = convert(b);
      proxies_.push_back(broad_phase_->createProxy(lower, upper, 0, nullptr, 1, -1, nullptr));
    }
    broad_phase_->calculateOverlappingPairs(nullptr);
  }
  std::size_t step(const BoxScene&, const std::vector<BoxUpdate>& updates) override {
    for (const BoxUpdate& u : updates) {
      const auto [lower, upper] = convert(u.box);
      broad_phase_->setAabb(proxies_[u.proxy], lower, upper, nullptr);
    }
    broad_phase_->calculateOverlappingPairs(nullptr);
    return static_cast<std::size_t>(broad_phase_->getOverlappingPairCache()->getNumOverlappingPairs());
  }

 protected:
  static std::pair<btVector3, btVector3> convert(const Aabb& b) {
    return {btVector3(btScalar(b.lower.x), btScalar(b.lower.y), -1),
            btVector3(btScalar(b.upper.x), btScalar(b.upper.y), 1)};
  }
  virtual std::unique_ptr<BroadPhaseType> make(const BoxScene& scene) = 0;

 private:
  std::unique_ptr<BroadPhaseType> broad_phase_;
  std::vector<btBroadphaseProxy*> proxies_;
};

class BulletTree final : public Bullet<btDbvtBroadphase> {
  std::unique_ptr<btDbvtBroadphase> make(const BoxScene&) override {
    return std::make_unique<btDbvtBroadphase>();
  }
};

class BulletSweep final : public Bullet<btAxisSweep3> {
  std::unique_ptr<btAxisSweep3> make(const BoxScene& scene) override {
    Aabb world = scene.boxes().front();
    for (const Aabb& b : scene.boxes()) world = united(world, b);
    const auto [lower, upper] = convert(grown(world, 10));
    return std::make_unique<btAxisSweep3>(lower, upper,
                                          static_cast<unsigned short>(scene.boxes().size() + 16));
  }
};
#endif

#ifdef SKERRY_WITH_ODE
/// ODE's sweep and prune space; it collides everything each time.
class OdeSweep final : public PairBench {
 public:
  OdeSweep() {
    static const int started = dInitODE2(0);
    (void)started;
  }
  ~OdeSweep() override { dSpaceDestroy(space_); }
  void build(const BoxScene& scene) override {
    space_ = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
    for (const Aabb& b : scene.boxes()) {
      geoms_.push_back(dCreateBox(space_, b.upper.x - b.lower.x, b.upper.y - b.lower.y, 1));
      place(geoms_.back(), b);
    }
  }
  std::size_t step(const BoxScene&, const std::vector<BoxUpdate>& updates) override {
    count_ = 0;
    for (const BoxUpdate& u : updates) place(geoms_[u.proxy], u.box);
    dSpaceCollide(space_, this, [](void* self, dGeomID, dGeomID) { ++static_cast<OdeSweep*>(self)->count_; });
    return count_;
  }

 private:
  static void place(dGeomID geom, const Aabb& b) {
    dGeomSetPosition(geom, (b.lower.x + b.upper.x) / 2, (b.lower.y + b.upper.y) / 2, 0);
  }
  dSpaceID space_ = nullptr;
  std::vector<dGeomID> geoms_;
  std::size_t count_ = 0;
};
#endif

#ifdef SKERRY_WITH_CGAL
/// CGAL's box_self_intersection_d: all pairs from nothing each time.
class Cgal final : public PairBench {
 public:
  using Box = CGAL::Box_intersection_d::Box_d<double, 2>;
  void build(const BoxScene& scene) override { boxes_.resize(scene.boxes().size()); }
  std::size_t step(const BoxScene& scene, const std::vector<BoxUpdate>&) override {
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const Aabb& b = scene.boxes()[i];
      boxes_[i] = Box(CGAL::Bbox_2(b.lower.x, b.lower.y, b.upper.x, b.upper.y));
    }
    std::size_t count = 0;
    CGAL::box_self_intersection_d(boxes_.begin(), boxes_.end(), [&](const Box&, const Box&) { ++count; });
    return count;
  }

 private:
  std::vector<Box> boxes_;
};
#endif

#ifdef SKERRY_WITH_BOOST
/// Boost.Geometry's R-tree, packed anew each step, with one query a moved box.
class BoostRtree final : public PairBench {
 public:
  using Point = boost::geometry::model::d2::point_xy<double>;
  using Box = boost::geometry::model::box<Point>;
  using Value = std::pair<Box, std::uint32_t>;
  void build(const BoxScene&) override {}
  std::size_t step(const BoxScene& scene, const std::vector<BoxUpdate>& updates) override {
    namespace index = boost::geometry::index;
    std::vector<Value> values;
    for (std::uint32_t i = 0; i < scene.boxes().size(); ++i)
      values.emplace_back(convert(scene.boxes()[i]), i);
    const index::rtree<Value, index::linear<16>> tree(values);
    std::size_t count = 0;
    for (const BoxUpdate& u : updates) {
      const auto add = [&](const Value& other) { count += other.second > u.proxy; };
      tree.query(index::intersects(convert(u.box)), boost::make_function_output_iterator(add));
    }
    return count;
  }

 private:
  static Box convert(const Aabb& b) { return {{b.lower.x, b.lower.y}, {b.upper.x, b.upper.y}}; }
};
#endif

template <class Peer>
[[maybe_unused]] std::unique_ptr<PairBench> make_peer() {
  return std::make_unique<Peer>();
}

}  // namespace

std::vector<BenchEntry> peers() {
  std::vector<BenchEntry> found;
#ifdef SKERRY_WITH_BOX2D
  found.push_back({"Box2D_" SKERRY_WITH_BOX2D "_tree", 100000, &make_peer<Box2d>});
#endif
#ifdef SKERRY_WITH_CHIPMUNK
  found.push_back({"Chipmunk_" SKERRY_WITH_CHIPMUNK "_tree", 1000000, &make_peer<ChipmunkTree>});
  found.push_back({"Chipmunk_" SKERRY_WITH_CHIPMUNK "_hash", 1000000, &make_peer<ChipmunkHash>});
#endif
#ifdef SKERRY_WITH_BULLET
  found.push_back({"Bullet_" SKERRY_WITH_BULLET "_dbvt", 100000, &make_peer<BulletTree>});
  found.push_back({"Bullet_" SKERRY_WITH_BULLET "_sweep3", 1000, &make_peer<BulletSweep>});
#endif
#ifdef SKERRY_WITH_ODE
  found.push_back({"ODE_" SKERRY_WITH_ODE "_sap", 100000, &make_peer<OdeSweep>});
#endif
#ifdef SKERRY_WITH_CGAL
  found.push_back({"CGAL_" SKERRY_WITH_CGAL "_boxes", 1000000, &make_peer<Cgal>});
#endif
#ifdef SKERRY_WITH_BOOST
  found.push_back({"Boost_" SKERRY_WITH_BOOST "_rtree", 1000000, &make_peer<BoostRtree>});
#endif
  return found;
}

}  // namespace skerry::bench
