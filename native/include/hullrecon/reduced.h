// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The reduced system: the lower half of a symmetric matrix of small blocks and a dense border, in a fill-reducing order, kept
// by compressed columns as CHOLMOD takes them; factored by supernodes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

namespace hullrecon {

class Reduced {
 public:
  // width: of each block. neighbours[start[b], start[b + 1]): the blocks that b meets, both ways, itself left out; the border
  // meets all. Of AMD and METIS the order with fewer nonzeros is taken.
  Reduced(std::vector<int> width, int border, const std::vector<int64_t>& start, const std::vector<int32_t>& neighbours);
  ~Reduced();
  Reduced(const Reduced&) = delete;
  Reduced& operator=(const Reduced&) = delete;

  int size() const { return size_; }
  int offset(int block) const { return offset_[block]; }  // of its scalars in vectors; the border is the last block

  void clear();
  // m: (width of a, width of b), a and b different, either order.
  template <class Product>
  void add(int a, int b, const Product& m) {
    position_[a] > position_[b] ? add_lower(b, place(b, a), m) : add_lower(a, place(a, b), m.transpose());
  }
  // m: its lower half is read.
  template <class Product>
  void add_own(int a, const Product& m) {
    add_lower(a, 0, m);
  }
  // m: (border, width of a)
  template <class Product>
  void add_border(int a, const Product& m) {
    add_lower(a, height_[a] - border_, m);
  }
  void add_diagonal(const Eigen::VectorXd& d);

  bool factor();  // false: not positive definite
  void solve(Eigen::VectorXd& x) const;

 private:
  struct Cholesky;
  int place(int column, int row) const;  // of block `row` below the top of block column `column`, in scalars
  // Of scalar (row, c) of a block column, rows counted from its top.
  int64_t at(int column, int row, int c) const {
    return start_[column] + int64_t{c} * height_[column] - c * (c - 1) / 2 + row - c;
  }
  template <class Product>
  void add_lower(int column, int row, const Product& m) {
    for (int c = 0; c < m.cols(); ++c) {
      double* to = &value_[at(column, row, c)];
      for (int r = row == 0 ? c : 0; r < m.rows(); ++r) to[r] += m(r, c);
    }
  }
  void order(const std::vector<int64_t>& start, const std::vector<int32_t>& neighbours);
  void lay_out(const std::vector<int64_t>& start, const std::vector<int32_t>& neighbours);

  std::vector<int> width_, position_, offset_, height_;
  int border_, size_ = 0;
  std::vector<int64_t> start_;                      // of each block column's scalars
  std::vector<int64_t> below_start_;                // the blocks below a block column's own: those it meets, by position
  std::vector<std::pair<int32_t, int32_t>> below_;  // position, place
  std::vector<double> value_;
  std::unique_ptr<Cholesky> cholesky_;
};

}  // namespace hullrecon
