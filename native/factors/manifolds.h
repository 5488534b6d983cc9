// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Moves a block by a step in its tangent. PlusJacobian is [I; 0]: a cost function writes its derivative by the tangent straight
// into the first columns of its block, and the chain rule of the solver, J * PlusJacobian, only cuts the rest off. Writing by
// the quaternion's four numbers instead would cost a product for each residual and say the same.
#pragma once

#include <ceres/manifold.h>

#include "factors/motion.h"

namespace hullrecon {

// Ambient: motion (7), then extra numbers that add. Tangent: translation 3, rotation 3, then the extras; `Held` extras at the
// end have no column.
template <int Extra, int BoundProblem>
class MotionManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7 + Extra; }
  int TangentSize() const override { return 6 + Extra - BoundProblem; }

  bool Plus(const double* x, const double* delta, double* moved) const override {
    const Quaternion q = (Motion(x).q * exp(Vec3(delta + 3))).normalized();
    for (int k = 0; k < 3; ++k) moved[k] = x[k] + delta[k];
    for (int k = 0; k < 4; ++k) moved[3 + k] = q.coeffs()[k];
    for (int k = 0; k < Extra; ++k) moved[7 + k] = x[7 + k] + (k < Extra - BoundProblem ? delta[6 + k] : 0.0);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override { return eye(jacobian, AmbientSize(), TangentSize()); }

  bool Minus(const double* y, const double* x, double* delta) const override {
    const Vec3 w = log(Motion(x).q.conjugate() * Motion(y).q);
    for (int k = 0; k < 3; ++k) delta[k] = y[k] - x[k], delta[3 + k] = w[k];
    for (int k = 0; k < Extra - BoundProblem; ++k) delta[6 + k] = y[7 + k] - x[7 + k];
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override { return eye(jacobian, TangentSize(), AmbientSize()); }

 private:
  static bool eye(double* jacobian, int rows, int columns) {
    for (int i = 0; i < rows * columns; ++i) jacobian[i] = i / columns == i % columns ? 1.0 : 0.0;
    return true;
  }
};

using PoseManifold = MotionManifold<1, 0>;          // pose and tray: 8 numbers, 7 columns
using PoseTrayHeldManifold = MotionManifold<1, 1>;  // 8 numbers, 6 columns
using RigidManifold = MotionManifold<0, 0>;         // 7 numbers, 6 columns

}  // namespace hullrecon
