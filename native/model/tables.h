// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Views of the arrays of hullrecon.native.Problem: read only, C order, owned by the caller for the call.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace hullrecon {

template <class Number>
struct Table {
  std::string name;
  std::vector<int64_t> shape{0};
  const Number* data = nullptr;

  int64_t rows() const { return shape.empty() ? 0 : shape[0]; }
  int64_t width() const {
    int64_t w = 1;
    for (size_t k = 1; k < shape.size(); ++k) w *= shape[k];
    return w;
  }
  const Number* row(int64_t i) const { return data + i * width(); }
};

// Names of their own; native/python/convert.h says which field of hullrecon.native.Problem each one is.
// clang-format off
#define HULLRECON_FLOAT_TABLES(X) \
  X(pose) X(landmark) X(T_g_M) X(T_s_ct) X(T_ct_cb) X(T_s_d) X(navigation) \
  X(deviation) X(intrinsics_top) X(intrinsics_bottom) X(vertices) \
  X(tray_origin) X(pressure_origin) X(prior_pose) X(prior_pose_sqrt) \
  X(prior_T_g_M) X(prior_T_g_M_sqrt) X(prior_T_s_ct) X(prior_T_s_ct_sqrt) \
  X(prior_T_ct_cb) X(prior_T_ct_cb_sqrt) X(prior_T_s_d) X(prior_T_s_d_sqrt) \
  X(prior_navigation_sigma) X(prior_intrinsics_sigma) X(attitude_measured) \
  X(attitude_sigma) X(tray_measured) X(tray_direction) X(tray_sigma) \
  X(odometry_measured) X(odometry_sqrt) X(odometry_by_navigation) \
  X(odometry_by_mount) X(odometry_by_tray) X(odometry_tray) \
  X(odometry_mount) X(stereo_pixel) X(stereo_sigma_ratio) X(mono_pixel) X(mono_sigma_ratio) X(range_offset) \
  X(range_tray_offset) X(range_beam) X(range_measured) X(range_sigma) \
  X(range_field_weight) X(surface_weight) X(surface_field_weight) \
  X(field_prior_value) X(link_switch) X(link_measured) X(link_sqrt) \
  X(plane) X(sighting_measured) X(sighting_sqrt) X(pair_measured) X(pair_sqrt) X(pair_point) X(pair_place) X(pair_by_place) \
  X(plane_range_offset) X(plane_range_tray_offset) X(plane_range_beam) \
  X(plane_range_measured) X(plane_range_sigma) X(velocity_before) \
  X(velocity_after) X(velocity_sigma) X(world) X(prior_world_sigma) \
  X(position_antenna) X(position_measured) X(position_sigma) \
  X(lens_top) X(lens_bottom) X(lens_image_size) X(lens_sigma) X(lens_expected)
#define HULLRECON_INT_TABLES(X) \
  X(faces) X(prior_pose_node) X(attitude_node) X(tray_node) X(odometry_first) X(odometry_second) X(stereo_node) \
  X(stereo_landmark) X(mono_node) X(mono_landmark) X(mono_camera) X(range_node) X(range_field_index) X(surface_landmark) \
  X(surface_field_index) X(field_prior_start) X(field_prior_index) X(link_first) X(link_second) X(link_camera_first) \
  X(link_camera_second) X(link_scaled) X(link_kernel) X(plane_anchor) X(sighting_node) X(sighting_plane) X(pair_first) \
  X(pair_second) X(plane_range_node) X(plane_range_plane) X(velocity_first) X(velocity_second) X(velocity_third) \
  X(position_node)
// clang-format on

struct Tables {
#define HULLRECON_FIELD(name) Table<double> name;
  HULLRECON_FLOAT_TABLES(HULLRECON_FIELD)
#undef HULLRECON_FIELD
#define HULLRECON_FIELD(name) Table<int32_t> name;
  HULLRECON_INT_TABLES(HULLRECON_FIELD)
#undef HULLRECON_FIELD
  std::vector<std::string> constant;
  double sigma_px = 1.0;

  // Sigma in px of a row: sigma_px times its ratio, where the table has ratios.
  double stereo_sigma_px(int64_t row) const {
    return sigma_px * (stereo_sigma_ratio.rows() ? stereo_sigma_ratio.data[row] : 1.0);
  }
  double mono_sigma_px(int64_t row) const { return sigma_px * (mono_sigma_ratio.rows() ? mono_sigma_ratio.data[row] : 1.0); }

  // Whether the block `world` is an unknown: without position fixes no factor depends on it.
  bool places_world() const { return position_node.rows() > 0 && !held("world"); }

  // Whether lenses have a displacement, free or held.
  bool has_lens() const { return lens_image_size.rows() > 0; }

  bool held(const char* block) const {
    for (const auto& name : constant) {
      if (name == block) return true;
    }
    return false;
  }
};

// What a number in link_kernel means: the kernel of that row of links.
enum LinkKernel : int32_t { kNoKernel, kScaling, kSwitch, kLinkKernels };

struct Options {
  std::string method = "maxmix", core = "schur";
  double sigma_on = 0.02, sigma_off = 1.0;
  double huber_stereo = 2.508, huber_mono = 1.856, huber_range = 1.345, huber_position = 1.856;
  double link_phi = 5.0;
  int max_iterations = 100;
  double function_tolerance = 1e-6, gradient_tolerance = 1e-10, parameter_tolerance = 1e-8;
  double initial_radius = 1e4;
  int threads = 1;
  bool labels_in_solve = true;
};

// Refuse, with the field's name, what cannot be meant. Throw InputError and UsageError.
void validate(const Tables& tables);
void validate(const Options& options);

}  // namespace hullrecon
