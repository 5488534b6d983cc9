// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The proof that every residual passes: value against the twin, derivative against the twin's automatic one and against numeric
// differences, every output written, and home is downhill.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <random>

#include "twins.h"

#include "expect.h"

using Blocks = std::vector<std::vector<double>>;
using Matrix = Eigen::MatrixXd;

inline std::vector<double> random_seven(std::mt19937& rng, double metres, double radians) {
  std::normal_distribution<double> normal;
  std::array<double, 6> delta;
  for (int k = 0; k < 6; ++k) delta[k] = (k < 3 ? metres : radians) * normal(rng);
  return twin::moved<double>({0, 0, 0, 0, 0, 0, 1}, delta.data());
}

inline Blocks shaken(const Blocks& x, std::mt19937& rng, double scale, std::vector<double>* by = nullptr) {
  std::normal_distribution<double> normal;
  Blocks out;
  for (const auto& block : x) {
    std::vector<double> delta(twin::tangent(block.size()));
    for (double& d : delta) d = scale * normal(rng);
    if (by) by->insert(by->end(), delta.begin(), delta.end());
    out.push_back(twin::moved<double>(block, delta.data()));
  }
  return out;
}

template <class Residual>
Eigen::VectorXd value(const Residual& residual, const Blocks& x) {
  Eigen::VectorXd r = Eigen::VectorXd::Constant(Residual::kRows, std::numeric_limits<double>::quiet_NaN());
  std::vector<const double*> at;
  for (const auto& block : x) at.push_back(block.data());
  REQUIRE(residual(at.data(), r.data(), nullptr));
  return r;
}

// In tangent coordinates, from outputs preset to NaN.
template <class Residual>
Matrix analytic(const Residual& residual, const Blocks& x, Eigen::VectorXd& r) {
  constexpr double kUnset = std::numeric_limits<double>::quiet_NaN();
  std::vector<const double*> at;
  std::vector<double*> J;
  std::vector<std::vector<double>> raw;
  int columns = 0;
  for (const auto& block : x) {
    at.push_back(block.data());
    raw.emplace_back(Residual::kRows * block.size(), kUnset);
    columns += twin::tangent(block.size());
  }
  for (auto& block : raw) J.push_back(block.data());
  r = Eigen::VectorXd::Constant(Residual::kRows, kUnset);
  REQUIRE(residual(at.data(), r.data(), J.data()));
  Matrix out(Residual::kRows, columns);
  int column = 0;
  for (size_t k = 0; k < x.size(); ++k) {
    const auto size = static_cast<int>(x[k].size()), width = twin::tangent(x[k].size());
    for (int row = 0; row < Residual::kRows; ++row) {
      for (int c = 0; c < width; ++c) out(row, column + c) = raw[k][row * size + c];
      for (int c = width; c < size; ++c) CHECK(raw[k][row * size + c] == 0.0);
    }
    column += width;
  }
  CHECK(out.allFinite());
  CHECK(r.allFinite());
  return out;
}

// Five-point differences along the tangent: exact to the fourth order.
template <class Residual>
Matrix numeric(const Residual& residual, const Blocks& x, int columns) {
  Matrix out(Residual::kRows, columns);
  constexpr double h = 5e-4;
  int column = 0;
  for (size_t k = 0; k < x.size(); ++k) {
    for (int c = 0; c < twin::tangent(x[k].size()); ++c, ++column) {
      const auto at = [&](double step) {
        std::vector<double> delta(twin::tangent(x[k].size()), 0.0);
        delta[c] = step;
        Blocks y = x;
        y[k] = twin::moved<double>(x[k], delta.data());
        return value(residual, y);
      };
      out.col(column) = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
    }
  }
  return out;
}

template <class Twin>
Matrix automatic(const Twin& residual_twin, const Blocks& x, int rows, int columns, Eigen::VectorXd& r) {
  std::vector<std::vector<twin::Jet>> adjoint;
  std::vector<const twin::Jet*> at;
  int column = 0;
  for (const auto& block : x) {
    std::vector<twin::Jet> delta;
    for (int c = 0; c < twin::tangent(block.size()); ++c) delta.emplace_back(0.0, column++);
    adjoint.push_back(twin::moved<twin::Jet>(block, delta.data()));
  }
  for (const auto& block : adjoint) at.push_back(block.data());
  std::vector<twin::Jet> out(rows);
  residual_twin(at.data(), out.data());
  Matrix jacobian(rows, columns);
  r.resize(rows);
  for (int row = 0; row < rows; ++row) {
    r[row] = out[row].a;
    jacobian.row(row) = out[row].v.head(columns).transpose();
  }
  return jacobian;
}

// truth: where the residual is nothing. shake: how far from it the derivatives are tested.
template <class Residual, class Twin>
void prove(const Residual& residual, const Twin& residual_twin, const Blocks& truth, std::mt19937& rng, double shake = 0.03) {
  Eigen::VectorXd r, r_twin;
  CHECK(value(residual, truth).norm() < 1e-9);
  for (int trial = 0; trial < 5; ++trial) {
    const Blocks x = shaken(truth, rng, shake);
    const Matrix J = analytic(residual, x, r);
    const int columns = static_cast<int>(J.cols());
    const Matrix by_twin = automatic(residual_twin, x, Residual::kRows, columns, r_twin);
    CHECK((r - r_twin).norm() <= 1e-11 * (1 + r_twin.norm()));
    CHECK((r - value(residual, x)).norm() == 0.0);
    for (int c = 0; c < columns; ++c) {
      const double scale = by_twin.col(c).norm() + 1e-3 * by_twin.norm();
      CHECK((J.col(c) - by_twin.col(c)).norm() <= 1e-8 * scale);
      CHECK((J.col(c) - numeric(residual, x, columns).col(c)).norm() <= 1e-8 * scale);
    }
    std::vector<double> by;
    const Blocks near = shaken(truth, rng, 1e-5, &by);
    const Matrix at_near = analytic(residual, near, r);
    const Eigen::Map<const Eigen::VectorXd> away(by.data(), static_cast<int>(by.size()));
    CHECK(away.dot(at_near.transpose() * r) >= 0.9 * (at_near * away).squaredNorm());
    CHECK((at_near * away).norm() > 0);
  }
}
