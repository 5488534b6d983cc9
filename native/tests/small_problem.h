// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// A survey of a few poses over a plate, with every table filled, and the dense twin of its normal equations.
#pragma once

#include <Eigen/Dense>
#include <deque>
#include <random>

#include "factors/camera.h"
#include "factors/manifolds.h"
#include "model/linear_factor.h"
#include "model/model.h"
#include "schur/camera_chain.h"

namespace hullrecon {

struct SmallProblem {
  static constexpr int kPoses = 5, kLandmarks = 14, kNodes = 3;
  Tables tables;
  std::mt19937 rng{11};

  explicit SmallProblem(std::vector<std::string> held = {}) {
    tables.constant = std::move(held);
    unknowns();
    priors();
    navigation();
    images();
    hull();
  }
  double normal() { return std::normal_distribution<double>()(rng); }
  int below(int end) { return static_cast<int>(rng() % static_cast<unsigned>(end)); }

 private:
  std::deque<std::vector<double>> numbers_;
  std::deque<std::vector<int32_t>> indices_;

  void set(Table<double>& table, std::vector<int64_t> shape, std::vector<double> values) {
    numbers_.push_back(std::move(values));
    table.shape = std::move(shape), table.data = numbers_.back().data();
  }
  void set(Table<int32_t>& table, std::vector<int64_t> shape, std::vector<int32_t> values) {
    indices_.push_back(std::move(values));
    table.shape = std::move(shape), table.data = indices_.back().data();
  }
  std::vector<double> some(int64_t count, double scale) {
    std::vector<double> out(count);
    for (double& x : out) x = scale * normal();
    return out;
  }
  std::vector<double> motion(double metres, double radians) {
    const Quaternion q = exp(radians * Vec3(normal(), normal(), normal()));
    return {metres * normal(), metres * normal(), metres * normal(), q.x(), q.y(), q.z(), q.w()};
  }
  std::vector<double> roots(int64_t rows, int size, double scale) {
    std::vector<double> out;
    for (int64_t k = 0; k < rows; ++k) {
      for (int r = 0; r < size; ++r) {
        for (int c = 0; c < size; ++c) out.push_back(r == c ? scale : 0.1 * scale * normal());
      }
    }
    return out;
  }

  void unknowns() {
    std::vector<double> pose, landmark;
    for (int i = 0; i < kPoses; ++i) {
      const auto x = motion(0.1, 0.1);
      pose.insert(pose.end(), {0.3 * i + x[0], x[1], x[2], x[3], x[4], x[5], x[6], 0.1 * normal()});
    }
    for (int l = 0; l < kLandmarks; ++l) {
      const double off = l % 4 == 0 ? -0.3 : 0.01 * normal();
      landmark.insert(landmark.end(), {0.12 * l, 0.3 * normal(), 2 + off});
    }
    set(tables.pose, {kPoses, 8}, pose);
    set(tables.landmark, {kLandmarks, 3}, landmark);
    for (Table<double>* t : {&tables.T_g_M, &tables.T_s_ct, &tables.T_ct_cb, &tables.T_s_d, &tables.odometry_mount}) {
      set(*t, {7}, motion(0.03, 0.03));
    }
    set(tables.navigation, {6}, some(6, 0.01));
    set(tables.deviation, {kNodes}, some(kNodes, 0.01));
    set(tables.intrinsics_top, {9}, {500, 510, 320, 240, -0.05, 0.01, 0.001, -0.002, 0.003});
    set(tables.intrinsics_bottom, {9}, {490, 505, 322, 238, 0.03, -0.02, -0.001, 0.001, 0.002});
    set(tables.tray_origin, {3}, {0.4, 0.02, 0.1});
    set(tables.pressure_origin, {3}, {0.1, 0.02, -0.05});
  }
  void priors() {
    set(tables.prior_pose_node, {1}, {0});
    set(tables.prior_pose, {1, 7}, motion(0.1, 0.1));
    set(tables.prior_pose_sqrt, {1, 6, 6}, roots(1, 6, 20));
    const std::array<std::pair<Table<double>*, Table<double>*>, 4> all{{{&tables.prior_T_g_M, &tables.prior_T_g_M_sqrt},
                                                                        {&tables.prior_T_s_ct, &tables.prior_T_s_ct_sqrt},
                                                                        {&tables.prior_T_ct_cb, &tables.prior_T_ct_cb_sqrt},
                                                                        {&tables.prior_T_s_d, &tables.prior_T_s_d_sqrt}}};
    for (const auto& [prior, root] : all) set(*prior, {7}, motion(0.02, 0.02)), set(*root, {6, 6}, roots(1, 6, 30));
    set(tables.prior_navigation_sigma, {6}, std::vector<double>(6, 0.02));
    set(tables.prior_intrinsics_sigma, {9}, {5, 5, 5, 5, 0.01, 0.01, 0.001, 0.001, 0.01});
  }
  void navigation() {
    std::vector<int32_t> every(kPoses), first(kPoses - 1), second(kPoses - 1);
    for (int i = 0; i < kPoses; ++i) every[i] = i;
    for (int i = 0; i + 1 < kPoses; ++i) first[i] = i, second[i] = i + 1;
    first.push_back(3), second.push_back(1);  // a loop, backwards
    const int64_t o = kPoses;
    set(tables.attitude_node, {kPoses}, every);
    set(tables.attitude_measured, {kPoses, 3}, some(3 * kPoses, 0.05));
    set(tables.attitude_sigma, {kPoses, 3}, std::vector<double>(3 * kPoses, 0.02));
    set(tables.tray_node, {kPoses}, every);
    set(tables.tray_measured, {kPoses}, some(kPoses, 0.1));
    set(tables.tray_direction, {kPoses}, {1, -1, 0, 1, -1});
    set(tables.tray_sigma, {kPoses}, std::vector<double>(kPoses, 0.02));
    set(tables.odometry_first, {o}, first), set(tables.odometry_second, {o}, second);
    std::vector<double> measured;
    for (int64_t k = 0; k < o; ++k) {
      const auto z = motion(0.1, 0.1);
      measured.insert(measured.end(), z.begin(), z.end());
    }
    set(tables.odometry_measured, {o, 7}, measured);
    set(tables.odometry_sqrt, {o, 6, 6}, roots(o, 6, 50));
    set(tables.odometry_by_navigation, {o, 6, 2}, some(12 * o, 1));
    set(tables.odometry_by_mount, {o, 6, 3}, some(18 * o, 1));
    set(tables.odometry_by_tray, {o, 6}, some(6 * o, 1));
    set(tables.odometry_tray, {o}, some(o, 0.1));
  }
  void images() {
    std::vector<int32_t> node, landmark, mono_node, mono_landmark, camera;
    std::vector<double> pixel, mono_pixel;
    for (int l = 0; l < kLandmarks; ++l) {
      const int middle = std::min(kPoses - 1, l / 3);
      for (int i = std::max(0, middle - 1); i <= std::min(kPoses - 1, middle + 1); ++i) {
        const CameraChain chain(tables.pose.row(i), Motion(tables.T_s_ct.data), Vec3(tables.tray_origin.data));
        const Vec3 in_top = chain.camera_from_global * (Vec3(tables.landmark.row(l)) - chain.centre);
        Projection top, bottom;
        project(tables.intrinsics_top.data, in_top, false, top);
        project(tables.intrinsics_bottom.data, Motion(tables.T_ct_cb.data).to_child(in_top), false, bottom);
        double seen[] = {top.pixel[0], top.pixel[1], bottom.pixel[0], bottom.pixel[1]};
        for (double& p : seen) p += normal();
        if ((l + i) % 5 != 0) {
          node.push_back(i), landmark.push_back(l);
          pixel.insert(pixel.end(), seen, seen + 4);
        }
        if ((l + i) % 3 == 0) {
          const int bottom = (l + i) % 2;
          mono_node.push_back(i), mono_landmark.push_back(l), camera.push_back(bottom);
          mono_pixel.insert(mono_pixel.end(), seen + 2 * bottom, seen + 2 * bottom + 2);
        }
      }
    }
    const auto s = static_cast<int64_t>(node.size()), m = static_cast<int64_t>(mono_node.size());
    set(tables.stereo_node, {s}, node), set(tables.stereo_landmark, {s}, landmark), set(tables.stereo_pixel, {s, 4}, pixel);
    set(tables.mono_node, {m}, mono_node), set(tables.mono_landmark, {m}, mono_landmark), set(tables.mono_camera, {m}, camera);
    set(tables.mono_pixel, {m, 2}, mono_pixel);
  }
  void hull() {
    set(tables.vertices, {4, 3}, {-9, -9, 2, 9, -9, 2, 9, 9, 2, -9, 9, 2});
    set(tables.faces, {2, 3}, {0, 2, 1, 0, 3, 2});
    const int64_t r = 2 * kPoses, s = kLandmarks + 2;
    std::vector<int32_t> node, landmark, index;
    std::vector<double> offset, beam, weight;
    for (int64_t k = 0; k < r; ++k) {
      node.push_back(static_cast<int32_t>(k / 2));
      const auto x = motion(0.02, 0.02);
      offset.insert(offset.end(), x.begin(), x.end());
      const Vec3 along = Vec3(0.3 * normal(), 0.3 * normal(), 1).normalized();
      beam.insert(beam.end(), along.data(), along.data() + 3);
    }
    for (int64_t k = 0; k < s; ++k) landmark.push_back(static_cast<int32_t>(k % kLandmarks));
    const auto nodes = [&](int64_t rows) {
      index.clear(), weight.clear();
      for (int64_t k = 0; k < 4 * rows; ++k) index.push_back(below(kNodes)), weight.push_back(k % 5 == 0 ? 0 : 0.3);
    };
    set(tables.range_node, {r}, node), set(tables.range_offset, {r, 7}, offset), set(tables.range_beam, {r, 3}, beam);
    set(tables.range_tray_offset, {r}, some(r, 0.01)), set(tables.range_measured, {r}, std::vector<double>(r, 2.0));
    set(tables.range_sigma, {r}, std::vector<double>(r, 0.05));
    nodes(r);
    set(tables.range_field_index, {r, 4}, index), set(tables.range_field_weight, {r, 4}, weight);
    set(tables.surface_landmark, {s}, landmark), set(tables.surface_weight, {s}, std::vector<double>(s, 0.4));
    nodes(s);
    set(tables.surface_field_index, {s, 4}, index), set(tables.surface_field_weight, {s, 4}, weight);
    set(tables.field_prior_start, {kNodes + 1}, {0, 1, 3, 5});
    set(tables.field_prior_index, {5}, {0, 0, 1, 1, 2});
    set(tables.field_prior_value, {5}, {30, -20, 25, -20, 25});
  }
};

// Gradient and information of the robustified problem, dense, columns as Model::blocks says.
struct Dense {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;

  explicit Dense(const Model& model) {
    const auto n = static_cast<Eigen::Index>(model.columns());
    information.setZero(n, n), gradient.setZero(n);
    LinearFactor factor;
    for (int64_t f = 0; f < model.factors(); ++f) {
      factor.at(model, f);
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(factor.residual.size(), n);
      for (size_t k = 0; k < factor.blocks.size(); ++k) {
        const Block& block = model.blocks()[factor.blocks[k]];
        if (block.tangent > 0) J.middleCols(block.column, block.tangent) = factor.weight * factor.by[k];
      }
      information += J.transpose() * J, gradient += factor.weight * J.transpose() * factor.residual;
    }
  }
};

inline std::vector<std::vector<std::string>> held_sets() {
  return {{},
          {"tray"},
          {"T_ct_cb", "intrinsics_top", "intrinsics_bottom"},
          {"T_g_M", "navigation"},
          {"T_s_ct", "deviation", "intrinsics_bottom"},
          {"T_g_M", "T_s_ct", "T_ct_cb", "T_s_d", "navigation", "intrinsics_top", "intrinsics_bottom", "deviation", "tray"}};
}

}  // namespace hullrecon
