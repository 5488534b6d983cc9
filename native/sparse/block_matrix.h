// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Stores a symmetric matrix of small dense blocks: its lower half on a fixed pattern, columns of blocks compressed.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/shelf.h"

namespace hullrecon {

class BlockMatrix {
 public:
  // width: of each block column, in order. pairs: (column << 32 | row), row >= column, ascending, each once.
  BlockMatrix(std::vector<int> width, const std::vector<uint64_t>& pairs) : width_(std::move(width)) {
    offset_.assign(1, 0), start_.assign(1, 0), place_.assign(1, 0);
    for (int w : width_) offset_.push_back(offset_.back() + w);
    for (uint64_t pair : pairs) {
      const auto column = static_cast<size_t>(pair >> 32);
      while (start_.size() <= column) start_.push_back(static_cast<int64_t>(row_.size()));
      row_.push_back(static_cast<int32_t>(pair));
      place_.push_back(place_.back() + static_cast<int64_t>(width_[row_.back()]) * width_[column]);
    }
    start_.resize(width_.size() + 1, static_cast<int64_t>(row_.size()));
    value_.assign(place_.back(), 0.0);
  }

  using Map = Eigen::Map<Eigen::MatrixXd>;
  using ConstMap = Eigen::Map<const Eigen::MatrixXd>;
  int size() const { return offset_.back(); }
  int blocks() const { return static_cast<int>(width_.size()); }
  int width(int block) const { return width_[block]; }
  int offset(int block) const { return offset_[block]; }

  // The stored block, row >= column; it must be on the pattern.
  Map lower(int row, int column) {
    const auto end = row_.begin() + start_[column + 1];
    const auto at = std::lower_bound(row_.begin() + start_[column], end, row) - row_.begin();
    return Map(value_.data() + place_[at], width_[row], width_[column]);
  }
  ConstMap at(int row, int column) const {
    const Map m = const_cast<BlockMatrix&>(*this).lower(row, column);
    return ConstMap(m.data(), m.rows(), m.cols());
  }
  // Either half, by value.
  Eigen::MatrixXd get(int row, int column) const {
    return row >= column ? Eigen::MatrixXd(at(row, column)) : Eigen::MatrixXd(at(column, row).transpose());
  }
  template <class Product>
  void add(int row, int column, const Product& m) {
    if (row >= column) {
      lower(row, column) += m;
    } else {
      lower(column, row) += m.transpose();
    }
  }

  void clear() { std::fill(value_.begin(), value_.end(), 0.0); }
  void shelve(Shelf& shelf) { shelf.add(place_, row_, value_); }
  // visit(row, block) down a column of blocks, the diagonal first.
  template <class Visit>
  void visit_column(int column, const Visit& visit) const {
    for (int64_t k = start_[column]; k < start_[column + 1]; ++k)
      visit(row_[k], ConstMap(value_.data() + place_[k], width_[row_[k]], width_[column]));
  }

  // visit(scalar row, scalar column, value&) down each scalar column of the lower half, diagonal first.
  template <class Visit>
  void each_scalar(const Visit& visit) {
    for (int column = 0; column < blocks(); ++column) {
      for (int c = 0; c < width_[column]; ++c) {
        for (int64_t k = start_[column]; k < start_[column + 1]; ++k) {
          const int row = row_[k], w = width_[row];
          for (int r = row == column ? c : 0; r < w; ++r) {
            visit(offset_[row] + r, offset_[column] + c, value_[place_[k] + static_cast<int64_t>(c) * w + r]);
          }
        }
      }
    }
  }

 private:
  std::vector<int> width_, offset_;
  std::vector<int64_t> start_, place_;
  std::vector<int32_t> row_;
  std::vector<double> value_;
};

}  // namespace hullrecon
