// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "factors/whitening.h"

#include "factors/manifolds.h"
#include "factors/mixture.h"
#include "factors/navigation_residuals.h"

#include "expect.h"

using namespace hullrecon;

TEST_CASE("whitening multiplies residual and derivative alike") {
  const double six[] = {1, 1, 1, 1, 1, 1};
  const double* x[] = {six};
  double r[6], raw[36];
  double* J[] = {raw};
  const std::array sizes{6};
  double root[36] = {};
  root[5] = 3;
  CHECK(whitened(VectorPrior<6>{{}}, Full{root, 6}, sizes, x, r, J));
  CHECK((r[0] == 3 && r[5] == 0));
  CHECK((raw[5] == 3 && raw[0] == 0));
  const double sigma[] = {1, 0.5, 0.25, 1, 1, 0.125};
  CHECK(whitened(VectorPrior<6>{{}}, Diagonal{sigma}, sizes, x, r, J));
  CHECK((r[5] == 8 && raw[35] == 8 && raw[34] == 0));
  CHECK(whitened(VectorPrior<6>{{}}, Scalar{0.5}, sizes, x, r, nullptr));
  CHECK(r[3] == 0.5);
}

TEST_CASE("the labels change at 0.05595 m and the loss is continuous there") {
  const Mixture mixture;
  CHECK(mixture.boundary() == doctest::Approx(0.05595).epsilon(1e-4));
  CHECK((mixture.on(-0.0559) && !mixture.on(0.0560)));
  const MixtureLoss loss(mixture, Label::Free, 1.0);
  const double s = std::pow(mixture.boundary() / 0.02, 2);
  double below, above, slope_below, slope_above;
  loss(s * (1 - 1e-12), below, slope_below), loss(s * (1 + 1e-12), above, slope_above);
  CHECK(below == doctest::Approx(above).epsilon(1e-9));
  CHECK((slope_below == 1.0 && slope_above == doctest::Approx(4e-4)));
}

TEST_CASE("the loss is twice the likelier label's negative log likelihood") {
  const MixtureLoss loss({0.02, 1.0}, Label::Free, 0.3);
  for (double h : {0.0, 0.03, 0.0561, 0.5, 3.0}) {
    const double on = h * h / (2 * 0.02 * 0.02) + std::log(0.02), off = h * h / 2;
    double rho, slope;
    loss(h * h / 4e-4, rho, slope);
    CHECK(rho == doctest::Approx(0.3 * 2 * (std::min(on, off) - std::log(0.02))));
  }
}

TEST_CASE("a held label keeps its branch") {
  double rho, slope;
  MixtureLoss({0.02, 1.0}, Label::On, 2.0)(1e4, rho, slope);
  CHECK((rho == 2e4 && slope == 2.0));
  MixtureLoss({0.02, 1.0}, Label::Off, 1.0)(0.0, rho, slope);
  CHECK(rho == doctest::Approx(2 * std::log(50.0)));
}

TEST_CASE("minus undoes plus on every manifold") {
  const double x[8] = {1, 2, 3, 0.5, 0.5, -0.5, 0.5, 0.7}, delta[7] = {0.1, -0.2, 0.3, 0.4, -0.5, 0.6, 0.05};
  double moved[8], back[7];
  PoseManifold pose;
  pose.Plus(x, delta, moved), pose.Minus(moved, x, back);
  for (int k = 0; k < 7; ++k) CHECK(back[k] == doctest::Approx(delta[k]));
  PoseTrayHeldManifold held;
  held.Plus(x, delta, moved), held.Minus(moved, x, back);
  CHECK(moved[7] == 0.7);
  for (int k = 0; k < 6; ++k) CHECK(back[k] == doctest::Approx(delta[k]));
}

TEST_CASE("the derivative of the logarithm holds from nothing to nearly half a turn") {
  for (double angle : {0.0, 1e-7, 1e-4, 0.01, 1.0, 3.0, 3.14}) {
    const Vec3 r = angle * Vec3(1, 2, -2) / 3;
    const Mat3 d = log_derivative(r);
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = 1e-5 * Vec3::Unit(k);
      const Vec3 slope = (log(exp(r) * exp(step)) - log(exp(r) * exp(-step))) / 2e-5;
      if (angle < 3.1) CHECK((slope - d.col(k)).norm() < 1e-7 * (1 + d.norm()));
    }
    CHECK((log(exp(r)) - r).norm() < 1e-9);
  }
}
