// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Sums the information of the robustified problem at its unknowns, landmarks eliminated, as blocks.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/linear_factor.h"
#include "sparse/block_matrix.h"

namespace hullrecon {

// A landmark's own 3 x 3 information and its coupling to the other free blocks it meets.
struct LandmarkInformation {
  Eigen::Matrix3d own;
  std::vector<int32_t> places;         // positions of those blocks in the order
  std::vector<Eigen::MatrixXd> cross;  // (3, width) each

  // From its factors. What they say of the other blocks alone is added to `rest`.
  void gather(const Model& model, const std::vector<int64_t>& factors, const std::vector<int>& position, LinearFactor& linear,
              BlockMatrix& rest);
};

class Information {
 public:
  // Throws StageError naming a landmark that is not determined.
  explicit Information(const Model& model);

  BlockMatrix& reduced() { return reduced_; }
  const BlockMatrix& reduced() const { return reduced_; }
  int position(int block) const { return position_[block]; }  // -1: held, or a landmark
  int block_at(int position) const { return order_[position]; }

  // Inverse of a landmark's own information. Throws StageError with the direction that nothing determines.
  static Eigen::Matrix3d invert(const LandmarkInformation& landmark, int64_t index);

 private:
  BlockMatrix pattern(const Model& model);
  void eliminate(const Model& model);

  std::vector<std::vector<int64_t>> of_landmark_;
  std::vector<int64_t> free_of_landmarks_;
  std::vector<int> order_, position_;
  BlockMatrix reduced_;
};

}  // namespace hullrecon
