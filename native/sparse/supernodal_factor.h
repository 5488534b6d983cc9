// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Factors a sparse symmetric positive definite matrix by CHOLMOD, and shows the factor by its supernodes: neighbouring columns
// of equal pattern, kept as one dense panel.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace hullrecon {

// Lower half of a symmetric matrix by compressed columns, with ones on the diagonal (scaled so).
struct Lower {
  int size = 0;
  std::vector<int> start, row;
  std::vector<double> value;
};

// The matrix has no inverse to working precision: the pivot of `column` vanished.
struct Singular {
  int column;
};

struct Factorization;  // CHOLMOD's

class SupernodalFactor {
 public:
  // Keeps the given order but for a postorder of its elimination tree. Throws Singular.
  explicit SupernodalFactor(const Lower& a);
  ~SupernodalFactor();
  SupernodalFactor(SupernodalFactor&&) noexcept;

  int size() const { return static_cast<int>(to_.size()); }
  int nodes() const { return nodes_; }
  int first(int node) const { return first_[node]; }  // its columns, [first, first + width)
  int width(int node) const { return first_[node + 1] - first_[node]; }
  int height(int node) const { return row_start_[node + 1] - row_start_[node]; }
  // Rows of the panel, ascending: its own, then those below, all of nodes on the way to the root.
  std::span<const int> rows(int node) const { return {rows_ + row_start_[node], static_cast<size_t>(height(node))}; }
  // The panel, (height, width) by columns.
  double* panel(int node) const { return value_ + value_start_[node]; }
  int parent(int node) const { return height(node) > width(node) ? node_of_[rows(node)[width(node)]] : -1; }
  int position(int row) const { return to_[row]; }  // in the factor, of a row of A
  int node_of(int position) const { return node_of_[position]; }

 private:
  void check_pivots() const;

  std::unique_ptr<Factorization> factorization_;
  std::vector<int> to_, node_of_;
  const int *first_, *row_start_, *value_start_, *rows_;  // CHOLMOD's super, pi, px, s
  double* value_;
  int nodes_;
};

// The direction (unit, in A's scaled unknowns) that A resists least, by inverse iteration.
std::vector<double> weakest_direction(const Lower& a);

}  // namespace hullrecon
