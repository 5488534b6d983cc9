// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Smooth displacement field of a lens that its calibration does not model (docs/methods.md 6).
//
// The ray of pixel m is the one that the calibration gives m + delta(m). Each axis of delta is a sum of modes, products of
// Legendre polynomials over the image of total degree 2 to kLensDegree, of unit rms; those of degree 0 and 1 any calibration
// finds. The field is taken at the measured pixel, as it changes by a thousandth of itself over a residual. So it is linear in
// its numbers.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace hullrecon {

constexpr int kLensDegree = 5;
constexpr int kLensModes = (kLensDegree + 1) * (kLensDegree + 2) / 2 - 3;  // of one axis
constexpr int kLensNumbers = 2 * kLensModes;                               // of a lens: px of the modes of u, then of v
using LensModes = Eigen::Matrix<double, kLensModes, 1>;

// Modes at a pixel, by degree, then by that along u. size: width and height of the image, px.
inline LensModes lens_modes(const double* size, const double* pixel) {
  static const std::array<double, kLensDegree + 1> unit_rms = [] {
    std::array<double, kLensDegree + 1> factor;
    for (int n = 0; n <= kLensDegree; ++n) factor[n] = std::sqrt(2 * n + 1);
    return factor;
  }();
  double p[2][kLensDegree + 1];
  for (int k = 0; k < 2; ++k) {
    const double x = (2 * pixel[k] + 1) / size[k] - 1;
    p[k][0] = 1, p[k][1] = x;
    for (int n = 1; n < kLensDegree; ++n) p[k][n + 1] = ((2 * n + 1) * x * p[k][n] - n * p[k][n - 1]) * (1.0 / (n + 1));
    for (int n = 0; n <= kLensDegree; ++n) p[k][n] *= unit_rms[n];
  }
  LensModes out;
  int at = 0;
  for (int degree = 2; degree <= kLensDegree; ++degree) {
    for (int n = 0; n <= degree; ++n) out[at++] = p[0][n] * p[1][degree - n];
  }
  return out;
}

inline Eigen::Vector2d displacement_px(const double* lens, const LensModes& modes) {
  return {Eigen::Map<const LensModes>(lens).dot(modes), Eigen::Map<const LensModes>(lens + kLensModes).dot(modes)};
}

// Derivative of a residual's two rows from `row` on (predicted - measured) by the numbers of the lens.
template <class Jacobian>
void put_by_lens(Jacobian& j, int row, const LensModes& modes) {
  for (int axis = 0; axis < 2; ++axis) {
    for (int k = 0; k < kLensModes; ++k) j(row + axis, axis * kLensModes + k) = -modes[k];
  }
}

}  // namespace hullrecon
