// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/selected_inversion.h"

#include <Eigen/Core>
#include <algorithm>
#include <stdexcept>

namespace hullrecon {

SelectedInverse::SelectedInverse(const Lower& a) : factor_(a) {
  invert();
}

// Z_RR of a supernode, dense (lower), from the supernodes above it. Returns the number of rows R.
int SelectedInverse::gather(int node, std::vector<double>& out, std::vector<int>& place) const {
  const auto rows = factor_.rows(node).subspan(factor_.width(node));
  const auto below = static_cast<int>(rows.size());
  out.resize(static_cast<size_t>(below) * below);
  for (int b = 0, known = -1; b < below; ++b) {
    const int owner = factor_.node_of(rows[b]), height = factor_.height(owner);
    const auto owned = factor_.rows(owner);
    if (owner != known) {
      for (int a = b, k = 0; a < below; ++a) {
        while (owned[k] != rows[a]) ++k;
        place[a] = k;
      }
      known = owner;
    }
    const double* column = factor_.panel(owner) + static_cast<int64_t>(rows[b] - factor_.first(owner)) * height;
    for (int a = b; a < below; ++a) out[static_cast<size_t>(b) * below + a] = column[place[a]];
  }
  return below;
}

void SelectedInverse::invert() {
  using Matrix = Eigen::MatrixXd;
  std::vector<double> above;
  std::vector<int> place(factor_.size());
  for (int s = factor_.nodes() - 1; s >= 0; --s) {
    const int width = factor_.width(s), below = gather(s, above, place);
    const Eigen::Map<const Matrix> z_rr(above.data(), below, below);
    Eigen::Map<Matrix, 0, Eigen::OuterStride<>> l(factor_.panel(s), width + below, width, Eigen::OuterStride<>(width + below));
    Matrix inverse = Matrix::Identity(width, width);
    l.topRows(width).triangularView<Eigen::Lower>().solveInPlace(inverse);
    const Matrix y = l.bottomRows(below) * inverse;
    Matrix z_jj = inverse.transpose() * inverse;
    if (below > 0) {
      const Matrix z_rj = -(z_rr.selfadjointView<Eigen::Lower>() * y);
      z_jj.noalias() -= y.transpose() * z_rj;
      l.bottomRows(below) = z_rj;
    }
    l.topRows(width) = z_jj;
  }
}

double SelectedInverse::operator()(int row, int column) const {
  const auto [j, i] = std::minmax({factor_.position(row), factor_.position(column)});
  const int s = factor_.node_of(j);
  const auto rows = factor_.rows(s);
  const auto at = std::lower_bound(rows.begin(), rows.end(), i);
  if (at == rows.end() || *at != i) throw std::out_of_range("the entry is not on the factor's pattern");
  return factor_.panel(s)[static_cast<int64_t>(j - factor_.first(s)) * factor_.height(s) + (at - rows.begin())];
}

}  // namespace hullrecon
