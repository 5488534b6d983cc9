// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Columns of the reduced system: the free unknowns that are left when the landmarks are eliminated.
#pragma once

#include <array>

#include "model/model.h"

namespace hullrecon {

// Poses, then nodes of the deviation field, each a column block of its own; then the border, one block of all free globals,
// which nearly every factor meets.
class ReducedLayout {
 public:
  explicit ReducedLayout(const Model& model)
      : poses_(static_cast<int>(model.poses())),
        nodes_(static_cast<int>(model.blocks().size()) - model.first_node()),
        pose_width_(model.blocks()[0].tangent),
        first_node_(model.first_node()),
        landmarks_end_(static_cast<int>(model.poses() + model.landmarks())) {
    if (nodes_ > 0 && model.blocks()[first_node_].tangent == 0) nodes_ = 0;
    for (int k = 0; k < 7; ++k) {
      const int tangent = model.blocks()[landmarks_end_ + k].tangent;
      column_[k] = tangent > 0 ? border_ : -1;
      border_ += tangent;
    }
  }

  int poses() const { return poses_; }
  int nodes() const { return nodes_; }
  int blocks() const { return poses_ + nodes_; }  // the border is the next
  int border() const { return border_; }          // its width
  int width(int block) const { return block < poses_ ? pose_width_ : block < blocks() ? 1 : border_; }
  int size() const { return poses_ * pose_width_ + nodes_ + border_; }
  int node(int k) const { return poses_ + k; }  // block of node k
  // First column of a global (enum Global) in the border; -1: held.
  int column(int global) const { return column_[global]; }

  int model_block(int block) const { return block < poses_ ? block : first_node_ + block - poses_; }
  int model_global(int global) const { return landmarks_end_ + global; }
  int global_of(int model_block) const { return model_block - landmarks_end_; }
  // Block of a model's block; blocks() for a global; -1: held or a landmark.
  int block_of(int model_block) const {
    if (model_block < poses_) return model_block;
    if (model_block < landmarks_end_) return -1;
    if (model_block < first_node_) return column_[global_of(model_block)] >= 0 ? blocks() : -1;
    return nodes_ > 0 ? poses_ + model_block - first_node_ : -1;
  }

 private:
  int poses_, nodes_, pose_width_, border_ = 0, first_node_, landmarks_end_;
  std::array<int, 7> column_;
};

}  // namespace hullrecon
