// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The loss of links: dynamic covariance scaling [Agarwal2013], as a function that a solver can minimise.
//
// The method weighs a link of whitened square u by s^2, s = min(1, 2 Phi / (Phi + u)). The loss whose slope that weight is:
//   rho(u) = u                          for u <= Phi,
//            3 Phi - 4 Phi^2 / (Phi + u)  beyond,
// continuous with its slope, bounded by 3 Phi (docs/methods.md 16). Phi = 5 by default.
#pragma once

#include <ceres/loss_function.h>

namespace hullrecon {

class ScalingLoss final : public ceres::LossFunction {
 public:
  explicit ScalingLoss(double phi) : phi_(phi) {}

  void Evaluate(double u, double rho[3]) const override {
    const double scale = u <= phi_ ? 1.0 : 2 * phi_ / (phi_ + u);
    rho[0] = u <= phi_ ? u : 3 * phi_ - 2 * phi_ * scale;
    rho[1] = scale * scale;
    rho[2] = 0;  // left out, as of all losses here
  }

 private:
  double phi_;
};

}  // namespace hullrecon
