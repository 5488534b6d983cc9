// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Computes the entries of A^-1 on the pattern of A's Cholesky factor, without the rest of the inverse [Takahashi1973], by
// supernodes. With L's columns J and the rows R below them, Y = L_RJ L_JJ^-1:
//   Z_RJ = -Z_RR Y,   Z_JJ = L_JJ^-T L_JJ^-1 - Y' Z_RJ,
// from the last columns to the first; Z_RR is known by then, for R is a clique of the filled graph.
#pragma once

#include <cstdint>
#include <memory>
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

class SelectedInverse {
 public:
  // Keeps the given order but for a postorder of its elimination tree. Throws Singular.
  explicit SelectedInverse(const Lower& a);
  ~SelectedInverse();

  // Of entries on the pattern of the factor; others throw std::out_of_range.
  double operator()(int row, int column) const;

 private:
  void invert();
  int gather(int node, std::vector<double>& out, std::vector<int>& place) const;
  void check_pivots() const;

  std::unique_ptr<Factorization> factorization_;
  std::vector<int> to_;                                   // position in the factor of each row of A
  std::vector<int> node_of_;                              // supernode of each position
  const int *first_, *row_start_, *value_start_, *rows_;  // CHOLMOD's super, pi, px, s
  double* value_;
  int nodes_;
};

// The direction (unit, in A's scaled unknowns) that A resists least, by inverse iteration.
std::vector<double> weakest_direction(const Lower& a);

}  // namespace hullrecon
