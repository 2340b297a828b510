// SPDX-License-Identifier: MIT
#include "tests/bench/accuracy/chain_reference.h"

#include <Eigen/Cholesky>

#include "tests/bench/accuracy/problem.h"

namespace skerry::bench {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Chain {
 public:
  explicit Chain(const Scene& scene) : n_(static_cast<Eigen::Index>(scene.joints.size())), reach_(n_, n_) {
    reach_.setZero();
    VectorXd mass(n_);
    inertia_.resize(n_);
    for (Eigen::Index k = 0; k < n_; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const SceneBody& body = scene.bodies[static_cast<std::size_t>(scene.joints[at].b)];
      mass[k] = body.mass;
      inertia_[k] = inertia_of(body);
      for (Eigen::Index i = 0; i < k; ++i) {
        const auto pin = static_cast<std::size_t>(i);
        reach_(k, i) = scene.joints[pin + 1].at_a.x - scene.joints[pin].at_a.x;
      }
      reach_(k, k) = body.position.x - scene.joints[at].at_a.x;
    }
    coupling_ = reach_.transpose() * mass.asDiagonal() * reach_;
    weight_ = -scene.gravity.y * (reach_.transpose() * mass);
  }

  Vec2 end(double seconds, int steps) const {
    VectorXd q = VectorXd::Zero(n_), w = VectorXd::Zero(n_);
    const double h = seconds / steps;
    for (int i = 0; i < steps; ++i) {
      const VectorXd a1 = acceleration(q, w), w2 = w + h / 2 * a1;
      const VectorXd a2 = acceleration(q + h / 2 * w, w2), w3 = w + h / 2 * a2;
      const VectorXd a3 = acceleration(q + h / 2 * w2, w3), w4 = w + h * a3;
      const VectorXd a4 = acceleration(q + h * w3, w4);
      q += h / 6 * (w + 2 * w2 + 2 * w3 + w4);
      w += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    return {reach_.row(n_ - 1).dot(q.array().cos().matrix()),
            reach_.row(n_ - 1).dot(q.array().sin().matrix())};
  }

 private:
  VectorXd acceleration(const VectorXd& q, const VectorXd& w) const {
    const VectorXd c = q.array().cos(), s = q.array().sin();
    // cos and sin of the differences, from those of the angles.
    MatrixXd inertia = coupling_.cwiseProduct(c * c.transpose() + s * s.transpose());
    inertia.diagonal() += inertia_;
    const MatrixXd turning = coupling_.cwiseProduct(s * c.transpose() - c * s.transpose());
    return inertia.llt().solve(-turning * w.cwiseAbs2() - weight_.cwiseProduct(c));
  }

  Eigen::Index n_;
  MatrixXd reach_;  ///< of body k along the direction of body i: the centre of k is the sum over i [m]
  MatrixXd coupling_;
  VectorXd inertia_, weight_;
};

}  // namespace

Vec2 swinging_end(const Scene& scene, double seconds) {
  const Chain chain(scene);
  const Vec2 coarse = chain.end(seconds, 4096), fine = chain.end(seconds, 8192);
  return fine + (fine - coarse) / 15;
}

}  // namespace skerry::bench
