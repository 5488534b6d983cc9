// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Whitens residuals. Sigmas act here and nowhere else.
#pragma once

#include <cstddef>

namespace hullrecon {

// Each multiplies by W from the left, in place: `count` rows, row major, of a residual (one column) or of its derivative by a
// block. They are no templates of the size, which would compile a product for each residual.

// One sigma for all rows: W = 1 / sigma.
struct Scalar {
  double inverse_sigma;

  void operator()(double* rows, int count, int columns) const;
};

// One sigma a row.
struct Diagonal {
  const double* sigma;

  void operator()(double* rows, int count, int columns) const;
};

// Square root of the information: W with W' W = covariance^-1. Row major, `stride` numbers a row.
struct Full {
  static constexpr int kMostRows = 7, kMostColumns = 8;  // of a link behind a switch, by a pose
  const double* root;
  int stride;

  void operator()(double* rows, int count, int columns) const;
};

// Residual and derivatives, whitened. sizes: of the blocks. False: the point cannot be evaluated.
template <class Residual, class Whitening, class Sizes>
bool whitened(const Residual& residual, const Whitening& whitening, const Sizes& sizes, const double* const* x, double* r,
              double* const* J) {
  if (!residual(x, r, J)) return false;
  whitening(r, Residual::kRows, 1);
  for (size_t k = 0; J && k < sizes.size(); ++k) {
    if (J[k]) whitening(J[k], Residual::kRows, sizes[k]);
  }
  return true;
}

}  // namespace hullrecon
