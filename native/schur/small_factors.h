// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Factors that meet no landmark (priors, attitude, tray, odometry, ranges, the field's prior, links, planes, velocities,
// positions), linear at the last accepted point. Their derivatives are summed to information a chunk of factors at a time and
// not kept: links would take twice the memory.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "schur/reduced_layout.h"
#include "sparse/block_matrix.h"

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
  int64_t count() const { return static_cast<int64_t>(factor_.size()); }
  std::span<const Part> parts(int64_t f) const {
    return {&part_[part_start_[f]], static_cast<size_t>(part_start_[f + 1] - part_start_[f])};
  }
  std::span<const int32_t> of_block(int block) const {
    return {of_block_.data() + of_block_start_[block],
            static_cast<size_t>(of_block_start_[block + 1] - of_block_start_[block])};
  }

  // Sums over all factors, whitened and robustified, of J'J and J'r: by blocks of the layout, the border the last.
  const BlockMatrix& information() const { return information_; }
  void shelve(Shelf& shelf) {
    shelf.add(factor_, rows_, part_start_, value_start_, part_, of_block_);
    information_.shelve(shelf);
  }
  auto gradient(int block) const { return gradient_.segment(information_.offset(block), information_.width(block)); }
  auto diagonal(int block) const { return information_.at(block, block).diagonal(); }

 private:
  struct Scratch {  // what evaluating a factor needs, kept from one to the next
    std::vector<int32_t> blocks;
    std::vector<const double*> x;
    std::vector<double> raw;
    std::vector<double*> J;
    std::vector<int> sizes;
  };
  void lay_out(const ReducedLayout& layout);
  void evaluate(int64_t f, double* rows, Scratch& scratch) const;
  void add(int64_t f, const double* rows, int owner, int owners);

  const Model& model_;
  std::vector<int64_t> factor_;  // its number in the model
  std::vector<int8_t> rows_;
  std::vector<int64_t> part_start_, value_start_;  // of its derivatives' first number, were all kept
  std::vector<Part> part_;
  std::vector<int32_t> of_block_start_, of_block_;
  BlockMatrix information_{{}, {}};
  Eigen::VectorXd gradient_;
};

}  // namespace hullrecon
