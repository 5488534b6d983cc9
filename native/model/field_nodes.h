// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Stores rows of nodes of the deviation field with their weights, compressed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/shelf.h"
#include "factors/residual.h"

namespace hullrecon {

class NodeTable {
 public:
  // Nodes at equal index become one, ascending; those without weight are left out: a factor names a block once.
  void add(const int32_t* index, const double* weight, int64_t count) {
    std::vector<std::pair<int32_t, double>> row;
    for (int64_t k = 0; k < count; ++k) row.emplace_back(index[k], weight[k]);
    std::stable_sort(row.begin(), row.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (size_t k = 0; k < row.size(); ++k) {
      double share = row[k].second;
      while (k + 1 < row.size() && row[k + 1].first == row[k].first) share += row[++k].second;
      if (share != 0) node_.push_back(row[k].first), weight_.push_back(share);
    }
    start_.push_back(static_cast<int64_t>(node_.size()));
  }

  // Rows that were not added have no nodes: without a field the table stays empty.
  std::span<const int32_t> nodes(int64_t row) const {
    if (row + 1 >= static_cast<int64_t>(start_.size())) return {};
    return {node_.data() + start_[row], static_cast<size_t>(start_[row + 1] - start_[row])};
  }
  void shelve(Shelf& shelf) { shelf.add(start_, node_, weight_); }
  FieldAt at(int64_t row) const { return {{weight_.data() + (nodes(row).empty() ? 0 : start_[row]), nodes(row).size()}}; }

 private:
  std::vector<int64_t> start_{0};
  std::vector<int32_t> node_;
  std::vector<double> weight_;
};

}  // namespace hullrecon
