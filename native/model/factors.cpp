// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Makes residuals of rows of the tables and evaluates them. No other file of the library meets their types: they cost the
// compiler a quarter of a minute wherever they are included.
#include "factors/residuals.h"
#include "factors/whitening.h"
#include "model/model.h"

namespace hullrecon {
namespace {

// Rows of the tables as matrices.
template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> matrix(const double* data) {
  return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>>(data);
}

Odometry odometry(const Tables& t, int64_t i) {
  return {Motion(t.odometry_measured.row(i)),
          matrix<6, 2>(t.odometry_by_navigation.row(i)),
          matrix<6, 3>(t.odometry_by_mount.row(i)),
          matrix<6, 1>(t.odometry_by_tray.row(i)),
          t.odometry_tray.data[i],
          Motion(t.odometry_mount.data).q};
}

PlaneRange plane_range(const Tables& t, int64_t i) {
  return {Motion(t.plane_range_offset.row(i)),
          t.plane_range_tray_offset.data[i],
          Vec3(t.plane_range_beam.row(i)).normalized(),
          Vec3(t.tray_origin.data),
          t.plane_range_measured.data[i],
          t.plane_range_node.data[i] == t.plane_anchor.data[t.plane_range_plane.data[i]]};
}

// Reads how many rows a factor's residual has and, at blocks x, evaluates it. One type for both, so that the residuals of all
// kinds are compiled once.
struct Evaluator {
  std::span<const int> sizes;
  const double* const* x = nullptr;
  double* r = nullptr;
  double* const* J = nullptr;
  int rows = 0;
  bool good = false;

  template <class Residual, class Whitening>
  void operator()(const Residual& residual, const Whitening& whitening) {
    rows = Residual::kRows;
    if (x) good = whitened(residual, whitening, sizes, x, r, J);
  }
};

}  // namespace

Range Model::range(int64_t i) const {
  const Tables& t = tables_;
  return {Motion(t.range_offset.row(i)), t.range_tray_offset.data[i], Vec3(t.range_beam.row(i)).normalized(),
          Vec3(t.tray_origin.data),      t.range_measured.data[i],    range_nodes_.at(i),
          association_.range(i),         association_.refused()};
}

template <class Use>
void Model::visit_prior(int64_t row, Use& use) const {
  const Tables& t = tables_;
  if (row < t.prior_pose_node.rows()) {
    return use(MotionPrior<8>{Motion(t.prior_pose.row(row))}, Full{t.prior_pose_sqrt.row(row), 6});
  }
  const int k = global_priors_[row - t.prior_pose_node.rows()];
  if (k == kNavigation) return use(VectorPrior<6>{{}}, Diagonal{t.prior_navigation_sigma.data});
  if (k == kWorld) return use(VectorPrior<3>{{}}, Diagonal{t.prior_world_sigma.data});
  if (k >= kTopLens) {
    VectorPrior<kLensNumbers> prior;
    std::copy_n(t.lens_expected.row(k - kTopLens), kLensNumbers, prior.expected.begin());
    return use(prior, Diagonal{t.lens_sigma.row(k - kTopLens)});
  }
  if (k >= kTopIntrinsics) {
    VectorPrior<9> prior;
    std::copy_n(&intrinsics_start_[9 * (k - kTopIntrinsics)], 9, prior.expected.begin());
    return use(prior, Diagonal{t.prior_intrinsics_sigma.data});
  }
  const std::array<std::pair<const Table<double>*, const Table<double>*>, 4> motions{{{&t.prior_T_g_M, &t.prior_T_g_M_sqrt},
                                                                                      {&t.prior_T_s_ct, &t.prior_T_s_ct_sqrt},
                                                                                      {&t.prior_T_ct_cb, &t.prior_T_ct_cb_sqrt},
                                                                                      {&t.prior_T_s_d, &t.prior_T_s_d_sqrt}}};
  use(MotionPrior<7>{Motion(motions[k].first->data)}, Full{motions[k].second->data, 6});
}

template <class Use>
void Model::visit_link(int64_t row, Use& use) const {
  const Tables& t = tables_;
  const CameraPair pair{Vec3(t.tray_origin.data), Motion(t.link_measured.row(row)), t.link_camera_first.data[row] == 1,
                        t.link_camera_second.data[row] == 1};
  const auto under_kernel = [&]<class Link>(const Link& link) {
    const double* const root = t.link_sqrt.row(row);  // of a bearing its first rows and columns
    if (t.link_kernel.data[row] != kSwitch) return use(link, Full{root, 6});
    constexpr int n = Link::kRows;
    std::array<double, (n + 1) * (n + 1)> with_switch{};
    for (int k = 0; k < n; ++k) std::copy_n(root + 6 * k, n, &with_switch[(n + 1) * k]);
    with_switch.back() = std::sqrt(options_.link_phi);
    use(SwitchedLink<Link>{link}, Full{with_switch.data(), n + 1});
  };
  t.link_scaled.data[row] == 1 ? under_kernel(ScaledLink{pair}) : under_kernel(BearingLink{pair});
}

template <class Use>
void Model::visit(int64_t factor, Use& use) const {
  const Tables& t = tables_;
  const int64_t i = number_of(factor);
  const Vec3 tray(t.tray_origin.data);
  switch (kind_of(factor)) {
    case Kind::Prior:
      return visit_prior(i, use);
    case Kind::Attitude:
      return use(Attitude{Vec3(t.pressure_origin.data), Vec3(t.attitude_measured.row(i))}, Diagonal{t.attitude_sigma.row(i)});
    case Kind::Tray:
      return use(Tray{t.tray_measured.data[i], t.tray_direction.data[i]}, Scalar{1 / t.tray_sigma.data[i]});
    case Kind::Odometry:
      return use(odometry(t, i), Full{t.odometry_sqrt.row(i), 6});
    case Kind::Stereo:
      return use(Stereo{tray, matrix<4, 1>(t.stereo_pixel.row(i)), t.has_lens() ? t.lens_image_size.data : nullptr},
                 Scalar{1 / t.stereo_sigma_px(i)});
    case Kind::Mono:
      return use(Mono{tray, matrix<2, 1>(t.mono_pixel.row(i)), t.mono_camera.data[i] == 1,
                      t.has_lens() ? t.lens_image_size.row(t.mono_camera.data[i]) : nullptr},
                 Scalar{1 / t.mono_sigma_px(i)});
    case Kind::Range:
      return use(range(i), Scalar{1 / t.range_sigma.data[i]});
    case Kind::Surface: {
      const int64_t row = surface_rows_[i];
      return use(Surface{surface_nodes_.at(row), association_.surface(row)}, Scalar{1 / options_.sigma_on});
    }
    case Kind::Deviation:
      return use(FieldPrior{prior_nodes_.at(field_rows_[i])}, Scalar{1.0});
    case Kind::Link:
      return visit_link(i, use);
    case Kind::Plane:
      return use(PlaneSighting{Vec3(t.sighting_measured.row(i)),
                               t.sighting_node.data[i] == t.plane_anchor.data[t.sighting_plane.data[i]]},
                 Full{t.sighting_sqrt.row(i), 3});
    case Kind::PlanePair:
      return use(PlanePair{Vec3(t.pair_measured.row(i)), Vec3(t.pair_point.row(i)), Vec3(t.pair_place.row(i)),
                           matrix<3, 3>(t.pair_by_place.row(i)),
                           t.plane_anchor.data[t.pair_first.data[i]] == t.plane_anchor.data[t.pair_second.data[i]]},
                 Full{t.pair_sqrt.row(i), 3});
    case Kind::PlaneRange:
      return use(plane_range(t, i), Scalar{1 / t.plane_range_sigma.data[i]});
    case Kind::Velocity:
      return use(Velocity{t.velocity_before.data[i], t.velocity_after.data[i]}, Diagonal{t.velocity_sigma.row(i)});
    case Kind::Position:
      return use(Position{Vec3(t.position_antenna.row(i)), matrix<2, 1>(t.position_measured.row(i))},
                 Scalar{1 / t.position_sigma.data[i]});
  }
}

int Model::rows_of(int64_t factor) const {
  Evaluator evaluator;
  visit(factor, evaluator);
  return evaluator.rows;
}

bool Model::evaluate(int64_t factor, std::span<const int> sizes, const double* const* x, double* r, double* const* J) const {
  Evaluator evaluator{sizes, x, r, J};
  visit(factor, evaluator);
  return evaluator.good;
}

std::pair<Vec3, Vec3> Model::ray(int64_t row, const double* const* x) const {
  const Beam beam = range(row).at(x, 0);
  return {beam.end_hull, beam.along_hull};
}

}  // namespace hullrecon
