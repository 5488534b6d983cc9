// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Holds the reduced system: the lower half of a symmetric matrix of small blocks and a dense border, in a fill-reducing order,
// kept where its factor will stand (fronts.h). With an interface it is that of a part of a problem: blocks of the interface,
// which other parts meet too, and the border come last and are left by the factorisation, condensed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sparse/fronts.h"

namespace hullrecon {

class ReducedSystem {
 public:
  // width: of each block. neighbours[start[b], start[b + 1]): the blocks that b meets, both ways, itself left out; the border
  // meets all. Of AMD and METIS the order with fewer nonzeros is taken. interface: blocks, in the order in which they stand
  // before the border; none: nothing is left by the factorisation. pages: memory for the matrix.
  ReducedSystem(std::vector<int> width, int border, const std::vector<int64_t>& start, const std::vector<int32_t>& neighbours,
                int threads, const std::optional<std::vector<int>>& interface = {},
                std::pmr::memory_resource* pages = std::pmr::get_default_resource());

  const FrontTree& tree() const { return fronts_->tree(); }
  int size() const { return offset(static_cast<int>(position_.size()) - 1) + border_; }
  int offset(int block) const {
    return fronts_->tree().offset(position_[block]);
  }  // of its scalars; the border is the last block

  void clear() { fronts_->clear(); }
  // m: (width of a, width of b), a and b different, either order.
  template <class Product>
  void add(int a, int b, const Product& m) {
    position_[a] > position_[b] ? add_lower(position_[a], position_[b], m)
                                : add_lower(position_[b], position_[a], m.transpose());
  }
  // m: its lower half is read.
  template <class Product>
  void add_own(int a, const Product& m) {
    add_lower(position_[a], position_[a], m);
  }
  // m: (border, width of a)
  template <class Product>
  void add_border(int a, const Product& m) {
    add_lower(position_.back(), position_[a], m);
  }
  void add_diagonal(const Eigen::VectorXd& d);

  bool factor() { return fronts_->factor(); }  // false: not positive definite. The matrix is gone then.
  double least_pivot() const { return fronts_->least_pivot(); }
  void solve(Eigen::VectorXd& x) { forward(x), backward(x); }

  // The two halves of solve() for a part of a problem: between them the interface's solution is put into x (fronts.h).
  void forward(Eigen::VectorXd& x) { fronts_->forward(x); }
  void backward(Eigen::VectorXd& x) { fronts_->backward(x); }
  int interior() const { return tree().offset(tree().fronts().back().first); }  // scalars before interface and border
  // Information that factor() leaves on interface and border, its lower half.
  Eigen::Map<Eigen::MatrixXd> condensed() {
    const int size = tree().fronts().back().size;
    return {fronts_->at(static_cast<int>(tree().fronts().size()) - 1, 0, 0), size, size};
  }

  // After factor(): the inverse of the matrix, read by block. In a part condensed() must hold that of interface and border.
  void invert() { fronts_->invert(); }
  Eigen::MatrixXd block(int a, int b) const;  // (width of a, width of b), where the factor has an entry
  // The same without a copy: its rows are those of the later of the two blocks; of a block with itself the lower half counts.
  Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> lower(int a, int b) const;
  bool is_later(int a, int b) const { return position_[a] > position_[b]; }

 private:
  template <class Product>
  void add_lower(int row, int column, const Product& m) {
    const auto [front, r, c] = fronts_->tree().position(row, column);
    for (int k = 0; k < m.cols(); ++k) {
      double* to = fronts_->at(front, r, c + k);
      for (int n = row == column ? k : 0; n < m.rows(); ++n) to[n] += m(n, k);
    }
  }

  int border_;
  std::vector<int> position_;
  std::unique_ptr<Fronts> fronts_;
};

}  // namespace hullrecon
