// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/inverse_columns.h"

#include <algorithm>

namespace hullrecon {

void InverseColumns::climb(int row, bool forward) {
  for (int node = factor_.node_of(factor_.position(row)); node >= 0; node = factor_.parent(node)) {
    const bool known = forward ? reached_[node] : start_[node] >= 0;
    if (known) return;
    if (start_[node] < 0) way_.push_back(node);
    start_[node] = 0;
    if (forward) reached_[node] = 1;
  }
}

// Where the rows below a node's square stand in x_.
void InverseColumns::places_below(int node) {
  const auto rows = factor_.rows(node).subspan(factor_.width(node));
  place_.resize(rows.size());
  for (size_t k = 0; k < rows.size(); ++k) place_[k] = at(rows[k]);
}

void InverseColumns::solve(const std::vector<int>& columns, const std::vector<int>& rows) {
  for (int node : way_) start_[node] = -1, reached_[node] = 0;
  way_.clear();
  for (int column : columns) climb(column, true);
  for (int row : rows) climb(row, false);
  std::sort(way_.begin(), way_.end());
  int height = 0;
  for (int node : way_) start_[node] = height, height += factor_.width(node);
  const auto count = static_cast<int>(columns.size());
  x_.setZero(height, count);
  for (int c = 0; c < count; ++c) x_(at(factor_.position(columns[c])), c) = 1;
  const auto panel = [&](int node) {
    return Eigen::Map<const Eigen::MatrixXd>(factor_.panel(node), factor_.height(node), factor_.width(node));
  };
  for (int node : way_) {
    if (!reached_[node]) continue;
    const auto l = panel(node);
    const int width = factor_.width(node);
    auto own = x_.middleRows(start_[node], width);
    l.topRows(width).triangularView<Eigen::Lower>().solveInPlace(own);
    below_.noalias() = l.bottomRows(l.rows() - width) * own;
    places_below(node);
    for (int c = 0; c < count; ++c) {
      for (size_t k = 0; k < place_.size(); ++k) x_(place_[k], c) -= below_(static_cast<int>(k), c);
    }
  }
  for (auto node = way_.rbegin(); node != way_.rend(); ++node) {
    const auto l = panel(*node);
    const int width = factor_.width(*node);
    auto own = x_.middleRows(start_[*node], width);
    places_below(*node);
    below_.resize(l.rows() - width, count);
    for (int c = 0; c < count; ++c) {
      for (size_t k = 0; k < place_.size(); ++k) below_(static_cast<int>(k), c) = x_(place_[k], c);
    }
    own.noalias() -= l.bottomRows(l.rows() - width).transpose() * below_;
    l.topRows(width).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
}

}  // namespace hullrecon
