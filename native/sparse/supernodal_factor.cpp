// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/supernodal_factor.h"

#include <cholmod.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <new>

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

SupernodalFactor::SupernodalFactor(const Lower& a) : factorization_(std::make_unique<Factorization>(a, 0.0)) {
  const cholmod_factor& f = *factorization_->factor;
  if (f.minor < f.n) throw Singular{factorization_->permutation()[f.minor]};
  first_ = static_cast<int*>(f.super), row_start_ = static_cast<int*>(f.pi);
  value_start_ = static_cast<int*>(f.px), rows_ = static_cast<int*>(f.s);
  value_ = static_cast<double*>(f.x), nodes_ = static_cast<int>(f.nsuper);
  to_.resize(a.size), node_of_.resize(a.size);
  for (int i = 0; i < a.size; ++i) to_[factorization_->permutation()[i]] = i;
  for (int s = 0; s < nodes_; ++s) std::fill(&node_of_[first_[s]], &node_of_[first_[s]] + first_[s + 1] - first_[s], s);
  check_pivots();
}

SupernodalFactor::~SupernodalFactor() = default;
SupernodalFactor::SupernodalFactor(SupernodalFactor&&) noexcept = default;

// On a matrix of unit diagonal a pivot is one less the squared multiple correlation; below this it is rounding.
void SupernodalFactor::check_pivots() const {
  constexpr double kVanished = 1e-12;
  for (int s = 0; s < nodes_; ++s) {
    for (int c = 0; c < width(s); ++c) {
      const double root = panel(s)[static_cast<int64_t>(c) * height(s) + c];
      if (!(root * root > kVanished)) throw Singular{factorization_->permutation()[first_[s] + c]};
    }
  }
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
