// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Gradient, diagonal and what else stays the same for every damping at a point that was accepted.
#include <algorithm>

#include "common/parallel.h"
#include "schur/schur.h"

namespace hullrecon {

void Schur::linearise() {
  images_.linearise();
  const Border of_intrinsics = differentiate_intrinsics();  // and views, which all below reads
  small_.linearise();
  surface_.linearise();
  differentiate_landmarks();
  differentiate_poses();
  differentiate_nodes();
  differentiate_others();
  differentiate_border(of_intrinsics);
}

void Schur::differentiate_landmarks() {
  for_slabs(model_.landmarks(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t r = begin; r < end; ++r) {
      Vec3 g = Vec3::Zero(), d = Vec3::Zero();
      for (const View& view : images_.views_of_landmark(r)) {
        const auto& h = view.information;
        g += view.gradient, d += Vec3(h[0], h[3], h[5]);
      }
      for (const SurfaceTerm& s : surface_.of_landmark(r)) g += s.n * s.r, d += s.n.cwiseAbs2();
      gradient_.landmark.segment<3>(3 * r) = g, diagonal_.landmark.segment<3>(3 * r) = d;
    }
  });
}

void Schur::differentiate_poses() {
  const int width = layout_.width(0);
  for_slabs(
      layout_.poses(), threads_,
      [&](int64_t begin, int64_t end) {
        for (int64_t i = begin; i < end; ++i) {
          Vec7 g = Vec7::Zero(), d = Vec7::Zero();
          if (images_.sees(i)) differentiate_images(i, g, d);
          const int pose = static_cast<int>(i);
          gradient_.reduced.segment(offset(pose), width) = g.head(width) + small_.gradient(pose);
          diagonal_.reduced.segment(offset(pose), width) = d.head(width) + small_.diagonal(pose);
        }
      },
      8);
}

// What the images at a pose say of it; their information and gradient by its twist are kept.
void Schur::differentiate_images(int64_t i, Vec7& gradient, Vec7& diagonal) {
  const CameraChain& chain = images_.chains()[i];
  Mat6& own = own_[i];
  own.setZero();
  Twist twist = Twist::Zero();
  for (int32_t v : images_.views_of_pose(i)) {
    const View& view = images_.view(v);
    const Vec3 q = at(view.landmark) - chain.origin;
    add_times_displacement(own, 1.0, adjoint(q, view.matrix()), q);
    twist += adjoint(q, view.gradient);
  }
  eliminated_.col(i) = twist;
  gradient = chain.by_pose.transpose() * twist;
  diagonal = (own * chain.by_pose).cwiseProduct(chain.by_pose).colwise().sum().transpose();
}

void Schur::differentiate_nodes() {
  for_slabs(layout_.nodes(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const int block = layout_.node(static_cast<int>(n));
      double g = 0, d = 0;
      for (int32_t k : surface_.of_node(static_cast<int>(n))) {
        const double by = surface_.by_node(surface_[k], static_cast<int32_t>(n));
        g += by * surface_[k].r, d += by * by;
      }
      gradient_.reduced[offset(block)] = g + small_.gradient(block)[0];
      diagonal_.reduced[offset(block)] = d + small_.diagonal(block)[0];
    }
  });
}

void Schur::differentiate_others() {
  for_slabs(layout_.others(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const int block = layout_.other(static_cast<int>(k));
      gradient_.reduced.segment(offset(block), layout_.width(block)) = small_.gradient(block);
      diagonal_.reduced.segment(offset(block), layout_.width(block)) = small_.diagonal(block);
    }
  });
}

void Schur::differentiate_border(const Border& of_intrinsics) {
  const auto diagonal = [](Border& sum, int first, const auto& d) { sum.own.diagonal().segment(first, d.size()) += d; };
  const Border of_poses = chunked(layout_.poses(), kPoses, [&](int64_t i, Border& sum) {
    if (mount_ < 0 || !images_.sees(i)) return;
    const auto& by = images_.chains()[i].by_mount;
    sum.rhs.segment<6>(mount_) += by.transpose() * eliminated_.col(i);
    diagonal(sum, mount_, (own_[i] * by).cwiseProduct(by).colwise().sum().transpose());
  });
  const Border of_landmarks = chunked(model_.landmarks(), kLandmarks, [&](int64_t r, Border& sum) {
    for (const SurfaceTerm& s : surface_.of_landmark(r)) {
      if (hull_ < 0) break;
      const Twist a = s.by_hull();
      sum.rhs.segment<6>(hull_) += a * s.r;
      diagonal(sum, hull_, a.cwiseAbs2());
    }
  });
  const int first = offset(layout_.blocks()), width = layout_.border();
  gradient_.reduced.segment(first, width) =
      of_poses.rhs + of_landmarks.rhs + of_intrinsics.rhs + small_.gradient(layout_.blocks());
  diagonal_.reduced.segment(first, width) =
      (of_poses.own + of_landmarks.own + of_intrinsics.own).diagonal() + small_.diagonal(layout_.blocks());
  intrinsics_own_ = of_intrinsics.own;
}

// What the images say of the intrinsics alone; what they say of them and of each landmark is kept.
Schur::Border Schur::differentiate_intrinsics() {
  return chunked(intrinsics_ > 0 ? groups() : 0, 1, [&](int64_t group, Border& sum) {
    WithIntrinsics cross(3, intrinsics_);
    ImageTerms::OfIntrinsics alone(intrinsics_);
    for (int64_t r = group * kGroup; r < std::min(model_.landmarks(), (group + 1) * kGroup); ++r) {
      cross.setZero();
      for (int32_t v = images_.first_view(r); v < images_.first_view(r + 1); ++v)
        images_.linearise_with_intrinsics(v, cross, alone);
      std::copy_n(cross.data(), cross.size(), intrinsics_cross_.data() + 3 * r * intrinsics_);
    }
    images_.put_lenses(alone);
    add_intrinsics_to_border(alone.own, alone.gradient, sum);
  });
}

// own: its lower half; so it stands in the border, and its diagonal is that of J'J, too.
void Schur::add_intrinsics_to_border(const Eigen::MatrixXd& own, const Eigen::VectorXd& rhs, Border& sum) const {
  for (int c = 0; c < intrinsics_; ++c) {
    sum.rhs[intrinsics_in_border(c)] += rhs[c];
    for (int d = 0; d <= c; ++d) sum.own(intrinsics_in_border(c), intrinsics_in_border(d)) += own(c, d);
  }
}

}  // namespace hullrecon
