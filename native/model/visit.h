// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// A factor's own types, without a virtual call or memory of its own: what the fast routes share with the general one.
#pragma once

#include "factors/whitening.h"
#include "model/model.h"

namespace hullrecon {

enum Global { kHull, kCamera, kBottom, kDvl, kNavigation, kTopLens, kBottomLens };

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> matrix(const double* data) {
  return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>>(data);
}

template <int N>
Diagonal<N> diagonal(const double* sigma) {
  return {matrix<N, 1>(sigma).cwiseInverse()};
}

template <class Use>
void Model::visit_prior(int64_t row, const Use& use) const {
  const Tables& t = tables_;
  if (row < t.prior_pose_node.rows()) {
    return use(MotionPrior<8>{Motion(t.prior_pose.row(row))}, Full<6>{matrix<6, 6>(t.prior_pose_sqrt.row(row))}, Robust{});
  }
  const int k = global_priors_[row - t.prior_pose_node.rows()];
  if (k == kNavigation) return use(VectorPrior<6>{{}}, diagonal<6>(t.prior_navigation_sigma.data), Robust{});
  if (k >= kTopLens) {
    VectorPrior<9> prior;
    std::copy_n(&lens_start_[9 * (k - kTopLens)], 9, prior.expected.begin());
    return use(prior, diagonal<9>(t.prior_intrinsics_sigma.data), Robust{});
  }
  const std::array<std::pair<const Table<double>*, const Table<double>*>, 4> motions{{{&t.prior_T_g_M, &t.prior_T_g_M_sqrt},
                                                                                      {&t.prior_T_s_ct, &t.prior_T_s_ct_sqrt},
                                                                                      {&t.prior_T_ct_cb, &t.prior_T_ct_cb_sqrt},
                                                                                      {&t.prior_T_s_d, &t.prior_T_s_d_sqrt}}};
  use(MotionPrior<7>{Motion(motions[k].first->data)}, Full<6>{matrix<6, 6>(motions[k].second->data)}, Robust{});
}

template <class Use>
void Model::visit(int64_t factor, const Use& use) const {
  const Tables& t = tables_;
  const Kind kind = kind_of(factor);
  const int64_t i = factor - first_[static_cast<size_t>(kind)];
  const Vec3 tray(t.tray_origin.data);
  const Robust none{};
  switch (kind) {
    case Kind::Prior:
      return visit_prior(i, use);
    case Kind::Attitude:
      return use(Attitude{Vec3(t.pressure_origin.data), Vec3(t.attitude_measured.row(i))}, diagonal<3>(t.attitude_sigma.row(i)),
                 none);
    case Kind::Tray:
      return use(Tray{t.tray_measured.data[i], t.tray_direction.data[i]}, Scalar{1 / t.tray_sigma.data[i]}, none);
    case Kind::Odometry:
      return use(odometry(i), Full<6>{matrix<6, 6>(t.odometry_sqrt.row(i))}, none);
    case Kind::Stereo:
      return use(Stereo{tray, matrix<4, 1>(t.stereo_pixel.row(i))}, Scalar{1 / t.sigma_px},
                 Robust{options_.huber_stereo, nullptr});
    case Kind::Mono:
      return use(Mono{tray, matrix<2, 1>(t.mono_pixel.row(i)), t.mono_camera.data[i] == 1}, Scalar{1 / t.sigma_px},
                 Robust{options_.huber_mono, nullptr});
    case Kind::Range:
      return use(range(i), Scalar{1 / t.range_sigma.data[i]}, Robust{options_.huber_range, nullptr});
    case Kind::Surface: {
      const int64_t row = surface_rows_[i];
      const MixtureLoss loss = surface_loss(row);
      return use(Surface{surface_nodes_.at(row), association_.surface(row)}, Scalar{1 / options_.sigma_on},
                 Robust{none.huber, &loss});
    }
    case Kind::Deviation:
      return use(FieldPrior{prior_nodes_.at(field_rows_[i])}, Scalar{1.0}, none);
  }
}

}  // namespace hullrecon
