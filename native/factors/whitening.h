// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Whitens residuals. Sigmas act here and nowhere else.
#pragma once

#include <Eigen/Core>

namespace hullrecon {

// One sigma for all rows: W = 1 / sigma.
struct Scalar {
  double inverse_sigma;

  template <class Rows>
  void operator()(Rows&& m) const {
    m *= inverse_sigma;
  }
};

template <int N>
struct Diagonal {
  Eigen::Matrix<double, N, 1> inverse_sigma;

  template <class Rows>
  void operator()(Rows&& m) const {
    m.array().colwise() *= inverse_sigma.array();
  }
};

// Square root of the information: W with W' W = covariance^-1.
template <int N>
struct Full {
  Eigen::Matrix<double, N, N> root;

  template <class Rows>
  void operator()(Rows&& m) const {
    m = (root * m).eval();
  }
};

// Residual and derivatives, whitened. sizes: of the blocks. False: the point cannot be evaluated.
template <class Residual, class Whitening, class Sizes>
bool whitened(const Residual& residual, const Whitening& whitening, const Sizes& sizes, const double* const* x, double* r,
              double* const* J) {
  using Rows = Eigen::Matrix<double, Residual::kRows, Eigen::Dynamic, Eigen::RowMajor>;
  if (!residual(x, r, J)) return false;
  whitening(Eigen::Map<Eigen::Matrix<double, Residual::kRows, 1>>(r));
  for (size_t k = 0; J && k < sizes.size(); ++k) {
    if (J[k]) whitening(Eigen::Map<Rows>(J[k], Residual::kRows, sizes[k]));
  }
  return true;
}

}  // namespace hullrecon
