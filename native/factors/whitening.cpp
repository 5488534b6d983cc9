// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "factors/whitening.h"

#include <algorithm>

namespace hullrecon {

void Scalar::operator()(double* rows, int count, int columns) const {
  for (int i = 0; i < count * columns; ++i) rows[i] *= inverse_sigma;
}

void Diagonal::operator()(double* rows, int count, int columns) const {
  for (int row = 0; row < count; ++row) {
    const double inverse_sigma = 1 / sigma[row];
    for (int c = 0; c < columns; ++c) rows[row * columns + c] *= inverse_sigma;
  }
}

void Full::operator()(double* rows, int count, int columns) const {
  double given[kMostRows * kMostColumns];
  std::copy_n(rows, count * columns, given);
  std::fill_n(rows, count * columns, 0.0);
  for (int row = 0; row < count; ++row) {
    for (int k = 0; k < count; ++k) {
      const double factor = root[row * stride + k];
      for (int c = 0; c < columns; ++c) rows[row * columns + c] += factor * given[k * columns + c];
    }
  }
}

}  // namespace hullrecon
