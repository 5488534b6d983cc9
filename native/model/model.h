// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Turns tables into unknowns and factors: what solve, evaluate and covariance share. Nothing of Ceres' Problem here.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "factors/mixture.h"
#include "factors/whitening.h"
#include "model/association.h"
#include "model/field_nodes.h"
#include "model/tables.h"

namespace hullrecon {

enum class Kind : int8_t {
  Prior,
  Attitude,
  Tray,
  Odometry,
  Stereo,
  Mono,
  Range,
  Surface,
  Deviation,
  Link,
  Plane,
  PlanePair,
  PlaneRange,
  Velocity,
  Position
};
constexpr std::array<const char*, 15> kKindNames{"prior", "attitude",   "tray",        "odometry",  "stereo",
                                                 "mono",  "range",      "surface",     "deviation", "link",
                                                 "plane", "plane_pair", "plane_range", "velocity",  "position"};

// Blocks that every factor may meet, in this order after poses and landmarks.
enum Global { kHull, kCamera, kBottom, kDvl, kNavigation, kTopIntrinsics, kBottomIntrinsics, kWorld, kGlobals };

// One block of unknowns. tangent: its columns; 0 when held.
struct Block {
  double* data;
  int size, tangent;
  int64_t column;  // of its first tangent coordinate; -1 when held
  std::string name;
};

// As Ceres takes it.
struct Factor {
  std::unique_ptr<ceres::CostFunction> cost;
  std::unique_ptr<ceres::LossFunction> loss;  // null: none
  Kind kind;
  int64_t row;                  // in its table
  std::vector<int32_t> blocks;  // in blocks()
};

class Model {
 public:
  Model(const Tables& tables, const Options& options);

  // Blocks in the order of columns: poses, landmarks, T_g_M, T_s_ct, T_ct_cb, T_s_d, navigation, intrinsics_top,
  // intrinsics_bottom, world, nodes of the deviation field, planes, switches of links.
  const std::vector<Block>& blocks() const { return blocks_; }

  // Factors are numbered by kind, then by row. They are made when asked for: half a million kept would cost 300 MB.
  int64_t factors() const { return first_.back(); }
  std::pair<int64_t, int64_t> factors_of(Kind kind) const;  // first, end
  Kind kind_of(int64_t factor) const;
  int64_t row_of(int64_t factor) const;  // in its table
  void blocks_of(int64_t factor, std::vector<int32_t>& blocks) const;
  Factor factor(int64_t factor) const;
  // Calls use(residual, whitening, robust) with the factor's own types: no virtual call, no memory of its own.
  template <class Use>
  void visit(int64_t factor, const Use& use) const;

  int64_t poses() const { return tables_.pose.rows(); }
  int64_t landmarks() const { return tables_.landmark.rows(); }
  int64_t columns() const { return columns_; }
  int block(const char* name) const;  // a global block by name
  bool is_landmark(int32_t block) const { return block >= poses() && block < poses() + landmarks(); }
  int first_node() const { return static_cast<int>(poses() + landmarks() + kGlobals); }
  int nodes() const { return static_cast<int>(tables_.deviation.rows()); }
  int first_plane() const { return first_node() + nodes(); }
  int planes() const { return static_cast<int>(tables_.plane.rows()); }
  int first_switch() const { return first_plane() + planes(); }
  const Tables& tables() const { return tables_; }
  const Options& options() const { return options_; }
  const Mixture& mixture() const { return mixture_; }

  // Closest triangles and hits at the present unknowns. surface_too: of the surface rows even when no factor needs them.
  void refresh(bool trial, bool surface_too = false);
  Association& association() { return association_; }
  const Association& association() const { return association_; }

  Vec3 landmark(int64_t i) const { return Vec3(landmark_ + 3 * i); }
  std::vector<double>& unknowns() { return unknowns_; }  // every block's numbers
  MixtureLoss surface_loss(int64_t row) const;
  std::span<const int32_t> surface_nodes(int64_t row) const { return surface_nodes_.nodes(row); }
  FieldAt surface_field(int64_t row) const { return surface_nodes_.at(row); }

  // Of each surface row at the last refresh: by the mixture, or as the method or the hold has it.
  std::vector<int32_t> labels() const;

  // Robustified cost by kind at the present unknowns and tables; the same number for any number of threads.
  std::array<double, kKindNames.size()> costs() const;

 private:
  void add_blocks();
  void add_block(double* data, int size, int tangent, std::string name);
  void number_factors();
  void hold_labels();
  template <class Use>
  void visit_prior(int64_t row, const Use& use) const;
  template <class Use>
  void visit_link(int64_t row, const Use& use) const;
  Odometry odometry(int64_t row) const;
  Range range(int64_t row) const;
  PlaneRange plane_range(int64_t row) const;

  Tables tables_;
  Options options_;
  Mixture mixture_;
  // All in one array: Ceres orders the blocks of an elimination group by their addresses, and those of separate arrays
  // change from process to process, and with them the last digits of the solution.
  std::vector<double> unknowns_;
  double *landmark_ = nullptr, *intrinsics_ = nullptr;  // in unknowns_
  std::vector<Block> blocks_;
  int64_t columns_ = 0;
  Association association_;
  NodeTable range_nodes_, surface_nodes_, prior_nodes_;
  std::vector<int> global_priors_;                  // of the blocks that have one and are free
  std::vector<int32_t> surface_rows_, field_rows_;  // that make factors
  std::vector<int32_t> switch_of_link_;             // -1: none
  std::array<double, 18> intrinsics_start_;
  std::array<int64_t, kKindNames.size() + 1> first_{};  // factor of each kind
  std::vector<int32_t> held_labels_;                    // empty: labels are free
};

// Rows of the tables as matrices, and their whitening.
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
  if (k == kWorld) return use(VectorPrior<3>{{}}, diagonal<3>(t.prior_world_sigma.data), Robust{});
  if (k >= kTopIntrinsics) {
    VectorPrior<9> prior;
    std::copy_n(&intrinsics_start_[9 * (k - kTopIntrinsics)], 9, prior.expected.begin());
    return use(prior, diagonal<9>(t.prior_intrinsics_sigma.data), Robust{});
  }
  const std::array<std::pair<const Table<double>*, const Table<double>*>, 4> motions{{{&t.prior_T_g_M, &t.prior_T_g_M_sqrt},
                                                                                      {&t.prior_T_s_ct, &t.prior_T_s_ct_sqrt},
                                                                                      {&t.prior_T_ct_cb, &t.prior_T_ct_cb_sqrt},
                                                                                      {&t.prior_T_s_d, &t.prior_T_s_d_sqrt}}};
  use(MotionPrior<7>{Motion(motions[k].first->data)}, Full<6>{matrix<6, 6>(motions[k].second->data)}, Robust{});
}

template <class Use>
void Model::visit_link(int64_t row, const Use& use) const {
  const Tables& t = tables_;
  const CameraPair pair{Vec3(t.tray_origin.data), Motion(t.link_measured.row(row)), t.link_camera_first.data[row] == 1,
                        t.link_camera_second.data[row] == 1};
  const auto under_kernel = [&]<class Link>(const Link& link) {
    constexpr int n = Link::kRows;
    const Eigen::Matrix<double, n, n> root = matrix<6, 6>(t.link_sqrt.row(row)).template topLeftCorner<n, n>();
    if (t.link_kernel.data[row] == kSwitch) {
      Full<n + 1> with_switch{Eigen::Matrix<double, n + 1, n + 1>::Zero()};
      with_switch.root.template topLeftCorner<n, n>() = root, with_switch.root(n, n) = std::sqrt(options_.link_phi);
      return use(SwitchedLink<Link>{link}, with_switch, Robust{});
    }
    Robust robust;
    if (t.link_kernel.data[row] == kScaling) robust.scaling = options_.link_phi;
    use(link, Full<n>{root}, robust);
  };
  t.link_scaled.data[row] == 1 ? under_kernel(ScaledLink{pair}) : under_kernel(BearingLink{pair});
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
      return use(Stereo{tray, matrix<4, 1>(t.stereo_pixel.row(i))}, Scalar{1 / t.stereo_sigma_px(i)},
                 Robust{options_.huber_stereo, nullptr});
    case Kind::Mono:
      return use(Mono{tray, matrix<2, 1>(t.mono_pixel.row(i)), t.mono_camera.data[i] == 1}, Scalar{1 / t.mono_sigma_px(i)},
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
    case Kind::Link:
      return visit_link(i, use);
    case Kind::Plane:
      return use(PlaneSighting{Vec3(t.sighting_measured.row(i)),
                               t.sighting_node.data[i] == t.plane_anchor.data[t.sighting_plane.data[i]]},
                 Full<3>{matrix<3, 3>(t.sighting_sqrt.row(i))}, none);
    case Kind::PlanePair:
      return use(PlanePair{Vec3(t.pair_measured.row(i)), Vec3(t.pair_point.row(i)), Vec3(t.pair_place.row(i)),
                           matrix<3, 3>(t.pair_by_place.row(i)),
                           t.plane_anchor.data[t.pair_first.data[i]] == t.plane_anchor.data[t.pair_second.data[i]]},
                 Full<3>{matrix<3, 3>(t.pair_sqrt.row(i))}, none);
    case Kind::PlaneRange:
      return use(plane_range(i), Scalar{1 / t.plane_range_sigma.data[i]}, Robust{options_.huber_range});
    case Kind::Velocity:
      return use(Velocity{t.velocity_before.data[i], t.velocity_after.data[i]}, diagonal<6>(t.velocity_sigma.row(i)), none);
    case Kind::Position:
      return use(Position{Vec3(t.position_antenna.row(i)), matrix<2, 1>(t.position_measured.row(i))},
                 Scalar{1 / t.position_sigma.data[i]}, Robust{options_.huber_position});
  }
}

}  // namespace hullrecon
