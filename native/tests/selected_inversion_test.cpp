// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/selected_inversion.h"

#include <Eigen/Dense>
#include <random>

#include "expect.h"
#include "sparse/inverse_columns.h"

using namespace hullrecon;

namespace {

// A chain of n with some long links and a dense last row, scaled to a unit diagonal.
Eigen::MatrixXd chain(int n, unsigned seed, double ridge) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  const auto link = [&](int i, int j) {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(n);
    v[i] = 1, v[j] = -1 + 0.1 * normal(rng) * (ridge > 0);
    a += v * v.transpose();
  };
  for (int i = 0; i + 1 < n; ++i) link(i, i + 1), link(i, n - 1 == i ? 0 : n - 1);
  for (int k = 0; k < n / 4; ++k) {
    const int i = static_cast<int>(rng() % n), j = static_cast<int>(rng() % n);
    if (i != j) link(i, j);
  }
  a += ridge * Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd scale = a.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * a * scale.asDiagonal();
}

Lower lower(const Eigen::MatrixXd& a) {
  Lower out{static_cast<int>(a.rows()), {0}, {}, {}};
  for (int c = 0; c < a.cols(); ++c) {
    for (int r = c; r < a.rows(); ++r) {
      if (a(r, c) == 0) continue;
      out.row.push_back(r);
      out.value.push_back(a(r, c));
    }
    out.start.push_back(static_cast<int>(out.row.size()));
  }
  return out;
}

}  // namespace

TEST_CASE("every entry on the pattern equals that of the dense inverse") {
  for (int n : {1, 2, 7, 40, 160}) {
    const Eigen::MatrixXd a = chain(n, n, 0.01), dense = a.inverse();
    const SelectedInverse inverse(lower(a));
    for (int c = 0; c < n; ++c) {
      for (int r = 0; r < n; ++r) {
        if (a(r, c) != 0) CHECK(inverse(r, c) == doctest::Approx(dense(r, c)).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("an entry off the pattern is refused, not guessed") {
  const SelectedInverse inverse(lower(Eigen::MatrixXd::Identity(3, 3)));
  CHECK(inverse(1, 1) == 1.0);
  CHECK_THROWS_AS(inverse(2, 0), std::out_of_range);
}

TEST_CASE("chosen columns equal those of the dense inverse at chosen rows, on the pattern or off it") {
  for (int n : {1, 2, 7, 40, 160}) {
    const Eigen::MatrixXd a = chain(n, n, 0.01), dense = a.inverse();
    const SupernodalFactor factor(lower(a));
    InverseColumns inverse(factor);
    std::mt19937 rng(n);
    for (int trial = 0; trial < 6; ++trial) {  // the same object again: what it met before is forgotten
      std::vector<int> columns, rows;
      for (int k = 0; k < 1 + trial; ++k) columns.push_back(static_cast<int>(rng() % n));
      for (int k = 0; k < trial; ++k) rows.push_back(static_cast<int>(rng() % n));
      inverse.solve(columns, rows);
      for (int c = 0; c <= trial; ++c) {
        for (int r : rows) CHECK(inverse(r, c) == doctest::Approx(dense(r, columns[c])).epsilon(1e-9));
        for (int r : columns) CHECK(inverse(r, c) == doctest::Approx(dense(r, columns[c])).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("a chain that nothing ties down is singular, and the direction left is the common shift") {
  const Lower a = lower(chain(30, 1, 0.0));
  CHECK_THROWS_AS(SelectedInverse{a}, Singular);
  const std::vector<double> v = weakest_direction(a);
  const Eigen::Map<const Eigen::VectorXd> direction(v.data(), 30);
  CHECK((chain(30, 1, 0.0) * direction).norm() < 1e-6);
}
