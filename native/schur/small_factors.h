// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Factors that meet no landmark (priors, attitude, tray, odometry, ranges, the field's prior, links, planes, velocities,
// positions), linear at the last accepted point.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "schur/reduced_layout.h"

namespace hullrecon {

class SmallFactors {
 public:
  SmallFactors(const Model& model, const ReducedLayout& layout);

  void linearise();  // at the model's unknowns
  // Robustified costs by kind at the model's unknowns, added. False: a factor cannot be evaluated there.
  bool cost(std::array<double, kKindNames.size()>& by_kind) const;

  // The columns that a factor has of one block.
  struct Part {
    int block, width;  // block of the layout, and its columns
    int column;        // its first in the rows
    int border;        // of a global: its first column in the border; else -1
  };
  using Rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>>;
  int64_t count() const { return static_cast<int64_t>(factor_.size()); }
  std::span<const Part> parts(int64_t f) const {
    return {&part_[part_start_[f]], static_cast<size_t>(part_start_[f + 1] - part_start_[f])};
  }
  // Whitened and robustified; the last column is the residual.
  Rows rows(int64_t f) const {
    const auto n = value_start_[f + 1] - value_start_[f];
    return Rows(&value_[value_start_[f]], rows_[f], n / rows_[f]);
  }
  std::span<const int32_t> of_block(int block) const {
    return {of_block_.data() + of_block_start_[block],
            static_cast<size_t>(of_block_start_[block + 1] - of_block_start_[block])};
  }

 private:
  const Model& model_;
  std::vector<int64_t> factor_;  // its number in the model
  std::vector<int8_t> rows_;
  std::vector<int64_t> part_start_, value_start_;
  std::vector<Part> part_;
  std::vector<double> value_;
  std::vector<int32_t> of_block_start_, of_block_;
};

}  // namespace hullrecon
