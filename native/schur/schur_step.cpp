// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Schur: a step, from the damping to the landmarks recovered.
#include <atomic>
#include <chrono>
#include <utility>

#include "common/parallel.h"
#include "schur/adjoint.h"
#include "schur/schur.h"

namespace hullrecon {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point& start) {
  const auto now = Clock::now();
  return std::chrono::duration<double>(now - std::exchange(start, now)).count();
}

}  // namespace

bool Schur::step(const Split& damping, Split& out) {
  auto clock = Clock::now();
  if (!invert(damping)) return false;
  eliminate();
  reduced_->add_diagonal(damping.kept);
  seconds.eliminate += since(clock);
  const bool definite = reduced_->factor();
  if (definite) out.kept = -rhs_, reduced_->solve(out.kept);
  seconds.factor += since(clock);
  if (!definite || !out.kept.allFinite()) return false;
  back_substitute(out);
  seconds.back_substitute += since(clock);
  return out.landmark.allFinite();
}

// K of every landmark, by Cholesky: a landmark that hardly any direction determines needs the digits.
bool Schur::invert(const Split& damping) {
  std::atomic<bool> definite = true;
  for_slabs(model_.landmarks(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t r = begin; r < end; ++r) {
      Mat3 v = damping.landmark.segment<3>(3 * r).asDiagonal();
      for (int32_t k = sights_.first_view(r); k < sights_.first_view(r + 1); ++k) v += sights_.view(k).matrix();
      for (const SurfaceRow& s : surfaces(r)) v += s.n * s.n.transpose();
      const double a = std::sqrt(v(0, 0)), b = v(1, 0) / a, c = v(2, 0) / a, d = std::sqrt(v(1, 1) - b * b);
      const double e = (v(2, 1) - b * c) / d, f = std::sqrt(v(2, 2) - c * c - e * e);
      if (!(a > 0 && d > 0 && f > 0)) definite = false;
      const double ia = 1 / a, id = 1 / d, ig = 1 / f, ib = -b * ia * id, ie = -e * id * ig, ic = -(c * ia + e * ib) * ig;
      inverse_[r] = {ia * ia + ib * ib + ic * ic, ib * id + ic * ie, ic * ig, id * id + ie * ie, ie * ig, ig * ig};
      gain_.col(r) = inverse(r) * gradient_.landmark.segment<3>(3 * r);
    }
  });
  return definite;
}

void Schur::back_substitute(Split& step) const {
  const int border = reduced_->offset(kept_.blocks()), width = kept_.width(0);
  const Vec6 hull = hull_ >= 0 ? Vec6(step.kept.segment<6>(border + hull_)) : Vec6(Vec6::Zero());
  const Vec6 mount = mount_ >= 0 ? Vec6(step.kept.segment<6>(border + mount_)) : Vec6(Vec6::Zero());
  Eigen::VectorXd optics(optics_);
  for (int c = 0; c < optics_; ++c) optics[c] = step.kept[border + optics_in_border(c)];
  Eigen::Matrix<double, 6, Eigen::Dynamic> twist(6, kept_.poses());
  for (int i = 0; i < kept_.poses(); ++i) {
    const Arm& arm = sights_.arms()[i];
    twist.col(i) = arm.by_mount * mount + arm.by_pose.leftCols(width) * step.kept.segment(reduced_->offset(i), width);
  }
  step.landmark.resize(3 * model_.landmarks());
  for_slabs(model_.landmarks(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t r = begin; r < end; ++r) {
      const Vec3 landmark = at(r);
      Vec3 b = Vec3::Zero();
      for (int32_t v = sights_.first_view(r); v < sights_.first_view(r + 1); ++v) {
        const View& view = sights_.view(v);
        b += view.matrix() * lowered(landmark - sights_.arms()[view.pose].origin, twist.col(view.pose));
      }
      for (const SurfaceRow& s : surfaces(r)) {
        double moved = hull_ >= 0 ? s.by_hull().dot(hull) : 0.0;
        const auto nodes = model_.surface_nodes(s.row);
        const FieldAt field = model_.surface_field(s.row);
        for (size_t k = 0; k < nodes.size() && kept_.blocks() > kept_.poses(); ++k) {
          moved += s.by_field * field.weight[k] * step.kept[reduced_->offset(kept_.poses() + nodes[k])];
        }
        b += s.n * moved;
      }
      if (optics_ > 0) b += optics_of(r) * optics;
      step.landmark.segment<3>(3 * r) = -(gain_.col(r) + inverse(r) * b);
    }
  });
}

}  // namespace hullrecon
