// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <cmath>
#include <set>

#include "common/errors.h"
#include "factors/lens.h"
#include "model/tables.h"

namespace hullrecon {
namespace {

using Floats = Table<double>;
using Ints = Table<int32_t>;
using Shape = std::vector<int64_t>;

std::string text(const Shape& shape) {
  std::string out = "(";
  for (int64_t n : shape) out += std::to_string(n) + ", ";
  return out + ")";
}

template <class Number>
void shape(const Table<Number>& table, const Shape& expected) {
  if (table.shape == expected) return;
  throw InputError("the shape is " + text(table.shape) + ", expected " + text(expected), table.name, "");
}

void finite(const Floats& table) {
  for (int64_t i = 0; i < table.rows() * table.width(); ++i) {
    if (!std::isfinite(table.data[i])) throw InputError("entry " + std::to_string(i) + " is not finite", table.name, "");
  }
}

void positive(const Floats& table) {
  for (int64_t i = 0; i < table.rows() * table.width(); ++i) {
    if (!(table.data[i] > 0)) throw InputError("sigma " + std::to_string(i) + " is not positive", table.name, "");
  }
}

void index(const Ints& table, int64_t end) {
  for (int64_t i = 0; i < table.rows() * table.width(); ++i) {
    if (table.data[i] >= 0 && table.data[i] < end) continue;
    const auto at = std::to_string(table.data[i]) + " of entry " + std::to_string(i);
    throw InputError("index " + at + " is not below " + std::to_string(end), table.name, "");
  }
}

// Unit vectors of `count` numbers at `first` in each row; a millesimal slack for what was stored as float32.
void unit(const Floats& table, int first, int count) {
  for (int64_t i = 0; i < table.rows(); ++i) {
    const double length = Eigen::Map<const Eigen::VectorXd>(table.row(i) + first, count).norm();
    if (std::abs(length - 1) > 1e-3) throw InputError("row " + std::to_string(i) + " is not of unit length", table.name, "");
  }
}

void motion(const Floats& table) {
  shape(table, {7});
  const double length = Eigen::Map<const Eigen::Vector4d>(table.data + 3).norm();
  if (std::abs(length - 1) > 1e-3) throw InputError("the quaternion is not of unit length", table.name, "");
}

void optional_prior(const Floats& prior, const Floats& root) {
  if (prior.shape == Shape{0} && root.shape == Shape{0}) return;
  if (prior.shape == Shape{0}) throw InputError("the square root stands without its prior", root.name, "");
  motion(prior);
  shape(root, {6, 6});
}

// (rows, 4) beside a field; empty is allowed.
void field_at(const Ints& nodes, const Floats& weights, int64_t rows, int64_t field) {
  if (nodes.rows() == 0 && weights.rows() == 0) return;
  if (field == 0) throw InputError("there is no deviation field to refer to", nodes.name, "give deviation, or leave it empty");
  shape(nodes, {rows, 4});
  shape(weights, {rows, 4});
  index(nodes, field);
}

void unknowns(const Tables& t) {
  shape(t.pose, {t.pose.rows(), 8});
  if (t.pose.rows() == 0) throw InputError("there are no poses", t.pose.name, "");
  unit(t.pose, 3, 4);
  shape(t.landmark, {t.landmark.rows(), 3});
  for (const Floats* m : {&t.T_g_M, &t.T_s_ct, &t.T_ct_cb, &t.T_s_d, &t.odometry_mount}) motion(*m);
  shape(t.navigation, {6});
  shape(t.world, {3});
  shape(t.deviation, {t.deviation.rows()});
  for (const Floats* k : {&t.intrinsics_top, &t.intrinsics_bottom}) {
    shape(*k, {9});
    if (!(k->data[0] > 0 && k->data[1] > 0)) throw InputError("a focal length is not positive", k->name, "");
  }
  shape(t.tray_origin, {3});
  shape(t.pressure_origin, {3});
  static const std::set<std::string> known{"T_g_M",      "T_s_ct",    "T_ct_cb",        "T_s_d",
                                           "navigation", "deviation", "intrinsics_top", "intrinsics_bottom",
                                           "tray",       "world",     "lens_top",       "lens_bottom"};
  for (const auto& name : t.constant) {
    if (!known.count(name)) throw InputError("there is no block of the name " + name, "constant", "");
  }
  if (!(std::isfinite(t.sigma_px) && t.sigma_px > 0)) throw InputError("it is not positive", "sigma_px", "");
}

void priors(const Tables& t) {
  const int64_t m = t.prior_pose_node.rows();
  shape(t.prior_pose_node, {m});
  index(t.prior_pose_node, t.pose.rows());
  shape(t.prior_pose, {m, 7});
  unit(t.prior_pose, 3, 4);
  shape(t.prior_pose_sqrt, {m, 6, 6});
  optional_prior(t.prior_T_g_M, t.prior_T_g_M_sqrt);
  optional_prior(t.prior_T_s_ct, t.prior_T_s_ct_sqrt);
  optional_prior(t.prior_T_ct_cb, t.prior_T_ct_cb_sqrt);
  optional_prior(t.prior_T_s_d, t.prior_T_s_d_sqrt);
  shape(t.prior_navigation_sigma, {6});
  positive(t.prior_navigation_sigma);
  shape(t.prior_world_sigma, {3});
  positive(t.prior_world_sigma);
  shape(t.prior_intrinsics_sigma, {9});
  positive(t.prior_intrinsics_sigma);
}

void lenses(const Tables& t) {
  if (!t.has_lens()) return;
  shape(t.lens_image_size, {2, 2});
  positive(t.lens_image_size);
  for (const Floats* lens : {&t.lens_top, &t.lens_bottom}) shape(*lens, {kLensNumbers});
  for (const Floats* table : {&t.lens_sigma, &t.lens_expected}) shape(*table, {2, kLensNumbers});
  positive(t.lens_sigma);
}

void navigation(const Tables& t) {
  const int64_t n = t.pose.rows(), a = t.attitude_node.rows(), y = t.tray_node.rows(), o = t.odometry_first.rows();
  shape(t.attitude_node, {a});
  index(t.attitude_node, n);
  shape(t.attitude_measured, {a, 3});
  shape(t.attitude_sigma, {a, 3});
  positive(t.attitude_sigma);
  shape(t.tray_node, {y});
  index(t.tray_node, n);
  for (const Floats* table : {&t.tray_measured, &t.tray_direction, &t.tray_sigma}) shape(*table, {y});
  positive(t.tray_sigma);
  for (const Ints* end : {&t.odometry_first, &t.odometry_second}) shape(*end, {o}), index(*end, n);
  for (int64_t i = 0; i < o; ++i) {
    if (t.odometry_first.data[i] == t.odometry_second.data[i]) {
      throw InputError("row " + std::to_string(i) + " joins a pose to itself", t.odometry_second.name, "");
    }
  }
  shape(t.odometry_measured, {o, 7});
  unit(t.odometry_measured, 3, 4);
  shape(t.odometry_sqrt, {o, 6, 6});
  shape(t.odometry_by_navigation, {o, 6, 2});
  shape(t.odometry_by_mount, {o, 6, 3});
  shape(t.odometry_by_tray, {o, 6});
  shape(t.odometry_tray, {o});
}

// (rows,) to multiply sigma_px; empty is allowed.
void sigma_ratio(const Floats& table, int64_t rows) {
  if (table.rows() == 0) return;
  shape(table, {rows});
  positive(table);
}

void images(const Tables& t) {
  const int64_t n = t.pose.rows(), l = t.landmark.rows(), s = t.stereo_node.rows(), m = t.mono_node.rows();
  shape(t.stereo_node, {s}), shape(t.stereo_landmark, {s}), shape(t.stereo_pixel, {s, 4});
  index(t.stereo_node, n), index(t.stereo_landmark, l);
  sigma_ratio(t.stereo_sigma_ratio, s);
  shape(t.mono_node, {m}), shape(t.mono_landmark, {m}), shape(t.mono_camera, {m}), shape(t.mono_pixel, {m, 2});
  index(t.mono_node, n), index(t.mono_landmark, l), index(t.mono_camera, 2);
  sigma_ratio(t.mono_sigma_ratio, m);
}

void hull(const Tables& t) {
  const int64_t r = t.range_node.rows(), s = t.surface_landmark.rows(), f = t.deviation.rows();
  shape(t.vertices, {t.vertices.rows(), 3});
  shape(t.faces, {t.faces.rows(), 3});
  index(t.faces, t.vertices.rows());
  if (t.faces.rows() == 0 && r + s > 0) {
    throw InputError("ranges and surface factors need a CAD model", t.faces.name, "give a mesh or leave their tables empty");
  }
  shape(t.range_node, {r});
  index(t.range_node, t.pose.rows());
  shape(t.range_offset, {r, 7});
  unit(t.range_offset, 3, 4);
  shape(t.range_beam, {r, 3});
  unit(t.range_beam, 0, 3);
  for (const Floats* table : {&t.range_tray_offset, &t.range_measured, &t.range_sigma}) shape(*table, {r});
  positive(t.range_sigma);
  field_at(t.range_field_index, t.range_field_weight, r, f);
  shape(t.surface_landmark, {s});
  index(t.surface_landmark, t.landmark.rows());
  shape(t.surface_weight, {s});
  for (int64_t i = 0; i < s; ++i) {
    if (t.surface_weight.data[i] < 0)
      throw InputError("weight " + std::to_string(i) + " is negative", t.surface_weight.name, "");
  }
  field_at(t.surface_field_index, t.surface_field_weight, s, f);
}

void field_prior(const Tables& t) {
  const auto& start = t.field_prior_start;
  const int64_t entries = t.field_prior_index.rows();
  shape(start, {start.rows()});
  shape(t.field_prior_index, {entries});
  shape(t.field_prior_value, {entries});
  index(t.field_prior_index, t.deviation.rows());
  const bool whole = start.rows() == 0 ? entries == 0 : start.data[0] == 0 && start.data[start.rows() - 1] == entries;
  if (!whole) throw InputError("the rows do not cover the entries", start.name, "");
  for (int64_t i = 1; i < start.rows(); ++i) {
    if (start.data[i] < start.data[i - 1]) throw InputError("the rows' starts descend at " + std::to_string(i), start.name, "");
  }
}

void links(const Tables& t) {
  const int64_t m = t.link_first.rows();
  for (const Ints* end : {&t.link_first, &t.link_second}) shape(*end, {m}), index(*end, t.pose.rows());
  for (const Ints* camera : {&t.link_camera_first, &t.link_camera_second}) shape(*camera, {m}), index(*camera, 2);
  shape(t.link_scaled, {m});
  shape(t.link_kernel, {m});
  index(t.link_kernel, kLinkKernels);
  shape(t.link_measured, {m, 7});
  unit(t.link_measured, 3, 4);
  shape(t.link_sqrt, {m, 6, 6});
  int64_t switches = 0;
  for (int64_t i = 0; i < m; ++i) {
    const std::string row = "row " + std::to_string(i);
    if (t.link_first.data[i] == t.link_second.data[i])
      throw InputError(row + " joins a pose to itself", t.link_second.name, "");
    if (t.link_scaled.data[i] == 0 && !(Eigen::Map<const Eigen::Vector3d>(t.link_measured.row(i)).norm() > 0))
      throw InputError(row + " has no direction", t.link_measured.name, "give the direction to the second camera");
    switches += t.link_kernel.data[i] == kSwitch;
  }
  shape(t.link_switch, {switches});
}

void planes(const Tables& t) {
  const int64_t n = t.pose.rows(), p = t.plane.rows(), s = t.sighting_node.rows(), m = t.pair_first.rows(),
                r = t.plane_range_node.rows();
  shape(t.plane, {p, 3});
  for (int64_t i = 0; i < p; ++i) {
    if (!(Eigen::Map<const Eigen::Vector3d>(t.plane.row(i)).norm() > 0))
      throw InputError("row " + std::to_string(i) + " passes through its anchor", t.plane.name, "anchor it at another node");
  }
  shape(t.plane_anchor, {p}), index(t.plane_anchor, n);
  shape(t.sighting_node, {s}), index(t.sighting_node, n);
  shape(t.sighting_plane, {s}), index(t.sighting_plane, p);
  shape(t.sighting_measured, {s, 3});
  shape(t.sighting_sqrt, {s, 3, 3});
  for (const Ints* end : {&t.pair_first, &t.pair_second}) shape(*end, {m}), index(*end, p);
  for (int64_t i = 0; i < m; ++i) {
    if (t.pair_first.data[i] == t.pair_second.data[i])
      throw InputError("row " + std::to_string(i) + " joins a plane to itself", t.pair_second.name, "");
  }
  shape(t.pair_measured, {m, 3});
  shape(t.pair_sqrt, {m, 3, 3});
  shape(t.pair_point, {m, 3}), shape(t.pair_place, {m, 3}), shape(t.pair_by_place, {m, 3, 3});
  shape(t.plane_range_node, {r}), index(t.plane_range_node, n);
  shape(t.plane_range_plane, {r}), index(t.plane_range_plane, p);
  shape(t.plane_range_offset, {r, 7});
  unit(t.plane_range_offset, 3, 4);
  shape(t.plane_range_beam, {r, 3});
  unit(t.plane_range_beam, 0, 3);
  for (const Floats* table : {&t.plane_range_tray_offset, &t.plane_range_measured, &t.plane_range_sigma}) shape(*table, {r});
  positive(t.plane_range_sigma);
}

void velocities(const Tables& t) {
  const int64_t m = t.velocity_first.rows();
  for (const Ints* node : {&t.velocity_first, &t.velocity_second, &t.velocity_third}) {
    shape(*node, {m}), index(*node, t.pose.rows());
  }
  for (int64_t i = 0; i < m; ++i) {
    const int32_t a = t.velocity_first.data[i], b = t.velocity_second.data[i], c = t.velocity_third.data[i];
    if (a == b || b == c || a == c)
      throw InputError("row " + std::to_string(i) + " names a pose twice", t.velocity_second.name, "");
  }
  for (const Floats* table : {&t.velocity_before, &t.velocity_after}) {
    shape(*table, {m});
    for (int64_t i = 0; i < m; ++i) {
      if (!(table->data[i] > 0)) throw InputError("interval " + std::to_string(i) + " is not positive", table->name, "");
    }
  }
  shape(t.velocity_sigma, {m, 6});
  positive(t.velocity_sigma);
}

void positions(const Tables& t) {
  const int64_t m = t.position_node.rows();
  shape(t.position_node, {m}), index(t.position_node, t.pose.rows());
  shape(t.position_antenna, {m, 3});
  shape(t.position_measured, {m, 2});
  shape(t.position_sigma, {m});
  positive(t.position_sigma);
}

void option(bool good, const char* name, const char* what) {
  if (!good) throw UsageError(what, name, "");
}

}  // namespace

void validate(const Tables& t) {
#define HULLRECON_FINITE(name) finite(t.name);
  HULLRECON_FLOAT_TABLES(HULLRECON_FINITE)
#undef HULLRECON_FINITE
  unknowns(t);
  priors(t);
  lenses(t);
  navigation(t);
  images(t);
  hull(t);
  field_prior(t);
  links(t);
  planes(t);
  velocities(t);
  positions(t);
}

void validate(const Options& o) {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  option(o.method == "naive" || o.method == "geva" || o.method == "maxmix", "method", "it must be naive, geva or maxmix");
  option(o.core == "schur" || o.core == "ceres", "core", "it must be schur or ceres");
  option(positive(o.sigma_on), "sigma_on", "it must be positive");
  option(std::isfinite(o.sigma_off) && o.sigma_off > o.sigma_on, "sigma_off", "it must be larger than sigma_on");
  option(o.huber_stereo > 0, "huber_stereo", "it must be positive; inf switches it off");
  option(o.huber_mono > 0, "huber_mono", "it must be positive; inf switches it off");
  option(o.huber_range > 0, "huber_range", "it must be positive; inf switches it off");
  option(o.huber_position > 0, "huber_position", "it must be positive; inf switches it off");
  option(positive(o.link_phi), "link_phi", "it must be positive");
  option(o.max_iterations >= 0, "max_iterations", "it must not be negative");
  option(o.function_tolerance >= 0, "function_tolerance", "it must not be negative");
  option(o.gradient_tolerance >= 0, "gradient_tolerance", "it must not be negative");
  option(o.parameter_tolerance >= 0, "parameter_tolerance", "it must not be negative");
  option(positive(o.initial_radius), "initial_radius", "it must be positive");
  option(o.threads >= 1 && o.threads <= 256, "threads", "it must be 1 to 256");
}

}  // namespace hullrecon
