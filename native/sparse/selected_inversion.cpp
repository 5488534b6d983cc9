// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/selected_inversion.h"

#include <cholmod.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hullrecon {

// One factorisation and what it needs; freed together.
struct Factorization {
  cholmod_common common;
  cholmod_factor* factor = nullptr;

  Factorization(const Lower& a, double ridge) {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NATURAL;
    common.postorder = 1;
    cholmod_sparse m{};
    m.nrow = m.ncol = a.size;
    m.nzmax = a.row.size();
    m.p = const_cast<int*>(a.start.data());
    m.i = const_cast<int*>(a.row.data());
    m.x = const_cast<double*>(a.value.data());
    m.stype = -1;
    m.itype = CHOLMOD_INT;
    m.xtype = CHOLMOD_REAL;
    m.dtype = CHOLMOD_DOUBLE;
    m.sorted = m.packed = 1;
    factor = cholmod_analyze(&m, &common);
    double beta[2] = {ridge, 0};
    if (factor) cholmod_factorize_p(&m, beta, nullptr, 0, factor, &common);
    if (!factor || common.status < 0) {
      free();
      throw std::bad_alloc();
    }
  }
  ~Factorization() { free(); }
  Factorization(const Factorization&) = delete;
  Factorization& operator=(const Factorization&) = delete;

  void free() {
    if (factor) cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  const int* permutation() const { return static_cast<const int*>(factor->Perm); }
};

SelectedInverse::SelectedInverse(const Lower& a) : factorization_(std::make_unique<Factorization>(a, 0.0)) {
  const cholmod_factor& f = *factorization_->factor;
  if (f.minor < f.n) throw Singular{factorization_->permutation()[f.minor]};
  first_ = static_cast<int*>(f.super), row_start_ = static_cast<int*>(f.pi);
  value_start_ = static_cast<int*>(f.px), rows_ = static_cast<int*>(f.s);
  value_ = static_cast<double*>(f.x), nodes_ = static_cast<int>(f.nsuper);
  to_.resize(a.size), node_of_.resize(a.size);
  for (int i = 0; i < a.size; ++i) to_[factorization_->permutation()[i]] = i;
  for (int s = 0; s < nodes_; ++s) std::fill(&node_of_[first_[s]], &node_of_[first_[s]] + first_[s + 1] - first_[s], s);
  check_pivots();
  invert();
}

SelectedInverse::~SelectedInverse() = default;

// On a matrix of unit diagonal a pivot is one less the squared multiple correlation; below this it is rounding.
void SelectedInverse::check_pivots() const {
  constexpr double kVanished = 1e-12;
  for (int s = 0; s < nodes_; ++s) {
    const int height = row_start_[s + 1] - row_start_[s];
    for (int c = 0; c < first_[s + 1] - first_[s]; ++c) {
      const double root = value_[value_start_[s] + static_cast<int64_t>(c) * height + c];
      if (!(root * root > kVanished)) throw Singular{factorization_->permutation()[first_[s] + c]};
    }
  }
}

// Z_RR of a supernode, dense (lower), from the supernodes above it. Returns the number of rows R.
int SelectedInverse::gather(int node, std::vector<double>& out, std::vector<int>& place) const {
  const int width = first_[node + 1] - first_[node], below = row_start_[node + 1] - row_start_[node] - width;
  const int* rows = rows_ + row_start_[node] + width;
  out.resize(static_cast<size_t>(below) * below);
  for (int b = 0, known = -1; b < below; ++b) {
    const int owner = node_of_[rows[b]];
    const int* owned = rows_ + row_start_[owner];
    const int height = row_start_[owner + 1] - row_start_[owner];
    if (owner != known) {
      for (int a = b, k = 0; a < below; ++a) {
        while (owned[k] != rows[a]) ++k;
        place[a] = k;
      }
      known = owner;
    }
    const double* column = value_ + value_start_[owner] + static_cast<int64_t>(rows[b] - first_[owner]) * height;
    for (int a = b; a < below; ++a) out[static_cast<size_t>(b) * below + a] = column[place[a]];
  }
  return below;
}

void SelectedInverse::invert() {
  using Matrix = Eigen::MatrixXd;
  std::vector<double> above;
  std::vector<int> place(to_.size());
  for (int s = nodes_ - 1; s >= 0; --s) {
    const int width = first_[s + 1] - first_[s], below = gather(s, above, place);
    const Eigen::Map<const Matrix> z_rr(above.data(), below, below);
    Eigen::Map<Matrix, 0, Eigen::OuterStride<>> l(value_ + value_start_[s], width + below, width,
                                                  Eigen::OuterStride<>(width + below));
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
  const auto [j, i] = std::minmax({to_[row], to_[column]});
  const int s = node_of_[j], height = row_start_[s + 1] - row_start_[s];
  const int *begin = rows_ + row_start_[s], *end = begin + height, *at = std::lower_bound(begin, end, i);
  if (at == end || *at != i) throw std::out_of_range("the entry is not on the factor's pattern");
  return value_[value_start_[s] + static_cast<int64_t>(j - first_[s]) * height + (at - begin)];
}

std::vector<double> weakest_direction(const Lower& a) {
  Factorization f(a, 1e-9);
  cholmod_dense* v = cholmod_ones(a.size, 1, CHOLMOD_REAL, &f.common);
  for (int i = 0; i < a.size; ++i) static_cast<double*>(v->x)[i] = 1 + 0.5 * std::sin(1.0 + i);  // along no axis
  for (int k = 0; k < 6 && v; ++k) {
    cholmod_dense* next = cholmod_solve(CHOLMOD_A, f.factor, v, &f.common);
    cholmod_free_dense(&v, &f.common);
    v = next;
    if (v) Eigen::Map<Eigen::VectorXd>(static_cast<double*>(v->x), a.size).normalize();
  }
  if (!v) throw std::bad_alloc();
  const auto* x = static_cast<double*>(v->x);
  std::vector<double> out(x, x + a.size);
  cholmod_free_dense(&v, &f.common);
  return out;
}

}  // namespace hullrecon
