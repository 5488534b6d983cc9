// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Computes the entries of A^-1 on the pattern of A's Cholesky factor, without the rest of the inverse [Takahashi1973], by
// supernodes. With L's columns J and the rows R below them, Y = L_RJ L_JJ^-1:
//   Z_RJ = -Z_RR Y,   Z_JJ = L_JJ^-T L_JJ^-1 - Y' Z_RJ,
// from the last columns to the first; Z_RR is known by then, for R is a clique of the filled graph.
#pragma once

#include "sparse/supernodal_factor.h"

namespace hullrecon {

class SelectedInverse {
 public:
  explicit SelectedInverse(const Lower& a);  // throws Singular

  // An entry of the inverse, if it is on the pattern of the factor; others throw std::out_of_range.
  double operator()(int row, int column) const;

 private:
  void invert();
  int gather(int node, std::vector<double>& out, std::vector<int>& place) const;

  SupernodalFactor factor_;  // its panels become those of the inverse
};

}  // namespace hullrecon
