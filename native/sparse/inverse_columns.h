// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Computes chosen entries of A^-1, on the factor's pattern or off it: columns J at rows I.
//
// L y = e_j has entries only on the way from j to the root of the elimination tree, and L' x = y gives x at i from the way from
// i to the root alone. So a column costs the panels on those ways, not the whole factor, and columns that lie together in the
// tree share them: they are solved for side by side.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sparse/supernodal_factor.h"

namespace hullrecon {

class InverseColumns {
 public:
  explicit InverseColumns(const SupernodalFactor& factor)
      : factor_(factor), start_(factor.nodes(), -1), reached_(factor.nodes(), 0) {}

  // Solves for the columns of A at the rows `columns`; only entries at them and at `rows` can be read afterwards.
  void solve(const std::vector<int>& columns, const std::vector<int>& rows);
  double operator()(int row, int column_number) const { return x_(at(factor_.position(row)), column_number); }

 private:
  void climb(int row, bool forward);
  int at(int position) const {
    const int node = factor_.node_of(position);
    return start_[node] + position - factor_.first(node);
  }
  void places_below(int node);

  const SupernodalFactor& factor_;
  std::vector<int> way_;       // nodes that are met, ascending
  std::vector<int> start_;     // of each node: its first row in x_; -1: not met
  std::vector<char> reached_;  // by the right side
  std::vector<int> place_;
  Eigen::MatrixXd x_, below_;
};

}  // namespace hullrecon
