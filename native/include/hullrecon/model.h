// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Tables to unknowns and factors: what solve, evaluate and covariance share. Nothing of Ceres' Problem here.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "hullrecon/association.h"
#include "hullrecon/mixture.h"
#include "hullrecon/tables.h"

namespace hullrecon {

enum class Kind : int8_t { Prior, Attitude, Tray, Odometry, Stereo, Mono, Range, Surface, Deviation };
constexpr std::array<const char*, 9> kKindNames{"prior", "attitude", "tray",    "odometry", "stereo",
                                                "mono",  "range",    "surface", "deviation"};

// One block of unknowns. tangent: its columns; 0 when held.
struct Block {
  double* data;
  int size, tangent;
  int64_t column;  // of its first tangent coordinate; -1 when held
  std::string name;
};

struct Factor {
  std::unique_ptr<ceres::CostFunction> cost;
  const ceres::LossFunction* loss;  // null: none
  Kind kind;
  int64_t row;                  // in its table
  std::vector<int32_t> blocks;  // in blocks()
};

class Model {
 public:
  Model(const Tables& tables, const Options& options);

  // Blocks in the order of columns: poses, landmarks, T_g_M, T_s_ct, T_ct_cb, T_s_d, navigation, intrinsics_top,
  // intrinsics_bottom, nodes of the deviation field.
  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<Factor>& factors() const { return factors_; }
  int64_t poses() const { return tables_.pose.rows(); }
  int64_t landmarks() const { return tables_.landmark.rows(); }
  int64_t columns() const { return columns_; }
  int block(const char* name) const;  // a global block by name
  int first_node() const { return static_cast<int>(poses() + landmarks() + 7); }
  const Tables& tables() const { return tables_; }
  const Options& options() const { return options_; }
  const Mixture& mixture() const { return mixture_; }

  // Closest triangles and hits at the present unknowns. surface_too: of the surface rows even when no factor needs them.
  void refresh(bool trial, bool surface_too = false);
  Association& association() { return association_; }

  // Of each surface row at the last refresh: by the mixture, or as the method or the hold has it.
  std::vector<int32_t> labels() const;

  // Robustified cost by kind at the present unknowns and tables; the same number for any number of threads.
  std::array<double, kKindNames.size()> costs() const;

 private:
  void add_blocks();
  void add_priors();
  void add_navigation();
  void add_images();
  void add_ranges();
  void add_surface();
  void add_field_prior();
  template <class Residual, class Whitening>
  void add(Kind kind, int64_t row, Residual residual, Whitening whitening, const ceres::LossFunction* loss,
           std::vector<int32_t> blocks);
  void add_block(double* data, int size, int tangent, std::string name);
  const ceres::LossFunction* mixture_loss(Label label, double weight);
  FieldAt field_at(const int32_t* index, const double* weight, int64_t count, std::vector<int32_t>& blocks) const;

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
  std::vector<Factor> factors_;
  std::vector<Range> rays_;
  std::vector<std::vector<const double*>> ray_blocks_;
  std::vector<FieldAt> surface_field_;
  std::vector<std::vector<int32_t>> surface_nodes_;
  std::vector<int32_t> held_labels_;  // empty: labels are free
  std::vector<std::unique_ptr<ceres::LossFunction>> losses_;
  std::vector<std::pair<std::pair<Label, double>, const ceres::LossFunction*>> mixture_losses_;
};

}  // namespace hullrecon
