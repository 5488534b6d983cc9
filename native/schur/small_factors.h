// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Every factor that meets no landmark, linear at the last accepted point: some rows by the free unknowns that it joins.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/model.h"

namespace hullrecon {

// The free unknowns that are left when landmarks are eliminated: poses, then nodes of the field, each a column block of its
// own; then the border, one block of all free globals, met by nearly every factor.
class Kept {
 public:
  explicit Kept(const Model& model);
  int blocks() const { return poses_ + nodes_; }  // the border is the next
  int poses() const { return poses_; }
  int width(int block) const { return block < poses_ ? pose_width_ : block < blocks() ? 1 : border_; }
  int border() const { return border_; }
  int at(int global) const { return at_[global]; }  // first column in the border; -1: held
  int size() const { return poses_ * pose_width_ + nodes_ + border_; }
  int kept(int model_block) const;  // block here; blocks() for a global; -1: held or a landmark
  int model_block(int block) const { return block < poses_ ? block : first_node_ + block - poses_; }
  int global_of(int model_block) const { return model_block - first_node_ + 7; }

 private:
  int poses_, nodes_, pose_width_, border_ = 0, first_node_, landmarks_end_;
  std::array<int, 7> at_;
};

class SmallFactors {
 public:
  SmallFactors(const Model& model, const Kept& kept);

  void linearise();  // at the model's unknowns
  // Robustified costs by kind at the model's unknowns, added. False: a factor cannot be evaluated there.
  bool cost(std::array<double, kKindNames.size()>& by_kind) const;

  struct Part {
    int block, width, column;  // kept block; column: in the rows; of a global also `border`, its first column in the border
    int border;
  };
  using Rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>>;
  int64_t count() const { return static_cast<int64_t>(factor_.size()); }
  std::span<const Part> parts(int64_t f) const {
    return {&part_[part_start_[f]], static_cast<size_t>(part_start_[f + 1] - part_start_[f])};
  }
  // Robustified; the last column is the residual.
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
