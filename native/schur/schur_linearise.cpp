// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Schur: gradient and the diagonal of J'J, at the model's unknowns.
#include <algorithm>

#include "common/parallel.h"
#include "model/visit.h"
#include "schur/adjoint.h"
#include "schur/schur.h"

namespace hullrecon {

void Schur::linearise() {
  sights_.linearise();
  small_.linearise();
  linearise_surface();
  differentiate_landmarks();
  differentiate_poses();
  differentiate_nodes();
  differentiate_border();
}

void Schur::linearise_surface() {
  const Motion hull(model_.blocks()[model_.block("T_g_M")].data);
  const Mat3 global_from_hull = hull.rotation();
  for_slabs(static_cast<int64_t>(surface_.size()), threads_, [&](int64_t begin, int64_t end) {
    double rho, slope;
    for (int64_t k = begin; k < end; ++k) {
      SurfaceRow& s = surface_[k];
      const double r = surface_residual(k, global_from_hull, hull.t, s.n);
      const MixtureLoss loss = model_.surface_loss(s.row);
      Robust{Robust{}.huber, &loss}(r * r, rho, slope);
      const double root = std::sqrt(slope), scale = root / model_.options().sigma_on;
      s.n *= scale, s.r = root * r, s.by_field = -scale;
      s.turn.noalias() = global_from_hull.transpose() * s.n.cross(at(s.rank) - hull.t);
    }
  });
}

void Schur::differentiate_landmarks() {
  for_slabs(model_.landmarks(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t r = begin; r < end; ++r) {
      Vec3 b = Vec3::Zero(), d = Vec3::Zero();
      for (int32_t v = sights_.first_view(r); v < sights_.first_view(r + 1); ++v) {
        const auto& h = sights_.view(v).information;
        b += sights_.view(v).gradient, d += Vec3(h[0], h[3], h[5]);
      }
      for (const SurfaceRow& s : surfaces(r)) b += s.n * s.r, d += s.n.cwiseAbs2();
      gradient_.landmark.segment<3>(3 * r) = b, diagonal_.landmark.segment<3>(3 * r) = d;
      if (optics_ == 0) continue;
      Eigen::Matrix3Xd cross = Eigen::Matrix3Xd::Zero(3, optics_);
      for (int32_t v = sights_.first_view(r); v < sights_.first_view(r + 1); ++v) sights_.by_optics(v, cross, nullptr, nullptr);
      optics_cross_.middleCols(r * optics_, optics_) = cross;
    }
  });
}

void Schur::differentiate_poses() {
  const int width = kept_.width(0);
  for_slabs(kept_.poses(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const Arm& arm = sights_.arms()[i];
      Mat6& own = own_[i];
      own.setZero();
      Vec6 twist = Vec6::Zero();
      for (int32_t k = views_start_[i]; k < views_start_[i + 1]; ++k) {
        const View& view = sights_.view(views_[k]);
        const Vec3 q = at(view.landmark) - arm.origin;
        add_times_lever(own, 1.0, lifted(q, view.matrix()), q);
        twist += lifted(q, view.gradient);
      }
      eliminated_.col(i) = twist;
      Eigen::Matrix<double, 7, 1> g = arm.by_pose.transpose() * twist;
      Eigen::Matrix<double, 7, 1> d = (own * arm.by_pose).cwiseProduct(arm.by_pose).colwise().sum().transpose();
      for (int32_t f : small_.of_block(static_cast<int>(i))) {
        const auto rows = small_.rows(f);
        for (const SmallFactors::Part& part : small_.parts(f)) {
          if (part.block != i) continue;
          g.head(width) += rows.middleCols(part.column, width).transpose() * rows.rightCols<1>();
          d.head(width) += rows.middleCols(part.column, width).colwise().squaredNorm().transpose();
        }
      }
      gradient_.kept.segment(reduced_->offset(static_cast<int>(i)), width) = g.head(width);
      diagonal_.kept.segment(reduced_->offset(static_cast<int>(i)), width) = d.head(width);
    }
  });
}

void Schur::differentiate_nodes() {
  for_slabs(kept_.blocks() - kept_.poses(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const int block = kept_.poses() + static_cast<int>(n);
      double g = 0, d = 0;
      for (int32_t k = of_node_start_[n]; k < of_node_start_[n + 1]; ++k) {
        const SurfaceRow& s = surface_[of_node_[k]];
        const double by = s.by_field * weight_of(s.row, static_cast<int32_t>(n));
        g += by * s.r, d += by * by;
      }
      for (int32_t f : small_.of_block(block)) {
        const auto rows = small_.rows(f);
        for (const SmallFactors::Part& part : small_.parts(f)) {
          if (part.block == block)
            g += rows.col(part.column).dot(rows.rightCols<1>()), d += rows.col(part.column).squaredNorm();
        }
      }
      gradient_.kept[reduced_->offset(block)] = g, diagonal_.kept[reduced_->offset(block)] = d;
    }
  });
}

double Schur::weight_of(int32_t surface_row, int32_t node) const {
  const auto nodes = model_.surface_nodes(surface_row);
  return model_.surface_field(surface_row).weight[std::find(nodes.begin(), nodes.end(), node) - nodes.begin()];
}

void Schur::differentiate_border() {
  const auto diagonal = [](Border& sum, int first, const auto& d) { sum.own.diagonal().segment(first, d.size()) += d; };
  const Border of_poses = chunked(kept_.poses(), kPoses, [&](int64_t i, Border& sum) {
    if (mount_ < 0) return;
    const auto& by = sights_.arms()[i].by_mount;
    sum.rhs.segment<6>(mount_) += by.transpose() * eliminated_.col(i);
    diagonal(sum, mount_, (own_[i] * by).cwiseProduct(by).colwise().sum().transpose());
  });
  const Border of_landmarks = chunked(model_.landmarks(), kLandmarks, [&](int64_t r, Border& sum) {
    for (const SurfaceRow& s : surfaces(r)) {
      if (hull_ < 0) break;
      const Vec6 a = s.by_hull();
      sum.rhs.segment<6>(hull_) += a * s.r;
      diagonal(sum, hull_, a.cwiseAbs2());
    }
    if (optics_ == 0) return;
    Eigen::Matrix3Xd cross = Eigen::Matrix3Xd::Zero(3, optics_);
    Eigen::MatrixXd own = Eigen::MatrixXd::Zero(optics_, optics_);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(optics_);
    for (int32_t v = sights_.first_view(r); v < sights_.first_view(r + 1); ++v) sights_.by_optics(v, cross, &own, &g);
    for (int k = 0; k < optics_; ++k) {
      sum.rhs[optics_in_border(k)] += g[k];
      // the whole of the optics' own block rides in the strict lower half, its diagonal where all others' is
      for (int m = 0; m <= k; ++m) sum.own(optics_in_border(k), optics_in_border(m)) += own(k, m);
    }
  });
  const Border of_small = chunked(small_.count(), kFactors, [&](int64_t f, Border& sum) {
    const auto rows = small_.rows(f);
    for (const SmallFactors::Part& part : small_.parts(f)) {
      if (part.border < 0) continue;
      const auto J = rows.middleCols(part.column, part.width);
      sum.rhs.segment(part.border, part.width) += J.transpose() * rows.rightCols<1>();
      diagonal(sum, part.border, J.colwise().squaredNorm().transpose());
    }
  });
  const int at = reduced_->offset(kept_.blocks()), width = kept_.border();
  gradient_.kept.segment(at, width) = of_poses.rhs + of_landmarks.rhs + of_small.rhs;
  diagonal_.kept.segment(at, width) = (of_poses.own + of_landmarks.own + of_small.own).diagonal();
  optics_own_ = of_landmarks.own;
  if (hull_ >= 0) optics_own_.middleRows(hull_, 6).setZero();
}

}  // namespace hullrecon
