// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Columns of the reduced system: the free unknowns that are left when the landmarks are eliminated.
#pragma once

#include <array>

#include "model/model.h"

namespace hullrecon {

// Poses, then nodes of the deviation field, then planes and switches of links, each a column block of its own; then the border,
// one block of all free globals, which nearly every factor meets.
class ReducedLayout {
 public:
  explicit ReducedLayout(const Model& model)
      : poses_(static_cast<int>(model.poses())),
        nodes_(model.nodes()),
        others_(static_cast<int>(model.blocks().size()) - model.first_plane()),
        planes_(model.planes()),
        pose_width_(model.blocks()[0].tangent),
        first_node_(model.first_node()),
        first_other_(model.first_plane()),
        landmarks_end_(static_cast<int>(model.poses() + model.landmarks())) {
    if (nodes_ > 0 && model.blocks()[first_node_].tangent == 0) nodes_ = 0;
    for (int k = 0; k < kGlobals; ++k) {
      const int tangent = model.blocks()[landmarks_end_ + k].tangent;
      column_[k] = tangent > 0 ? border_ : -1;
      border_ += tangent;
    }
  }

  int poses() const { return poses_; }
  int nodes() const { return nodes_; }
  int others() const { return others_; }                    // met by small factors alone
  int blocks() const { return poses_ + nodes_ + others_; }  // the border is the next
  int border() const { return border_; }                    // its width
  int width(int block) const {
    if (block < poses_) return pose_width_;
    if (block >= blocks()) return border_;
    return block >= other(0) && block < other(planes_) ? 3 : 1;
  }
  int size() const { return poses_ * pose_width_ + nodes_ + others_ + 2 * planes_ + border_; }
  int node(int k) const { return poses_ + k; }            // block of node k
  int other(int k) const { return poses_ + nodes_ + k; }  // and of other block k
  // First column of a global (enum Global) in the border; -1: held.
  int column(int global) const { return column_[global]; }

  int model_block(int block) const {
    if (block < poses_) return block;
    return block < other(0) ? first_node_ + block - poses_ : first_other_ + block - other(0);
  }
  int model_global(int global) const { return landmarks_end_ + global; }
  int global_of(int model_block) const { return model_block - landmarks_end_; }
  // Block of a model's block; blocks() for a global; -1: held or a landmark.
  int block_of(int model_block) const {
    if (model_block < poses_) return model_block;
    if (model_block < landmarks_end_) return -1;
    if (model_block < first_node_) return column_[global_of(model_block)] >= 0 ? blocks() : -1;
    if (model_block >= first_other_) return other(model_block - first_other_);
    return nodes_ > 0 ? poses_ + model_block - first_node_ : -1;
  }

 private:
  int poses_, nodes_, others_, planes_, pose_width_, border_ = 0, first_node_, first_other_, landmarks_end_;
  std::array<int, kGlobals> column_;
};

}  // namespace hullrecon
