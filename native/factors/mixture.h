// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Labels of landmarks and the losses of factors [Ozog2016 4.2.3, OlsonAgarwal2013]. A landmark is on the hull (label 1,
// sigma_on) or off it (label 0, sigma_off), equal odds; the likelier label wins. Twice the negative log likelihood, less that
// of label 1 at zero, of s = (h / sigma_on)^2:
//   label 1: s          label 0: s (sigma_on / sigma_off)^2 + 2 ln(sigma_off / sigma_on)
// and the max-mixture is the smaller: an exact loss on s, continuous, its derivative that of the winning label.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

namespace hullrecon {

class Mixture {
 public:
  Mixture(double sigma_on = 0.02, double sigma_off = 1.0)  // m
      : ratio_((sigma_on / sigma_off) * (sigma_on / sigma_off)),
        constant_(2 * std::log(sigma_off / sigma_on)),
        boundary_(sigma_on * std::sqrt(constant_ / (1 - ratio_))) {}

  double ratio() const { return ratio_; }
  double constant() const { return constant_; }
  // |h| at which the labels change, m: 0.05595 for sigmas of 0.02 and 1 m.
  double boundary() const { return boundary_; }
  bool on(double h) const { return std::abs(h) <= boundary_; }

 private:
  double ratio_, constant_, boundary_;
};

enum class Label { Off, On, Free };

// The mixture's cost times a weight (the share of a landmark in its correlation cell); with a held label, that label's cost.
class MixtureLoss {
 public:
  MixtureLoss(const Mixture& mixture, Label label, double weight)
      : ratio_(mixture.ratio()),
        constant_(mixture.constant()),
        weight_(weight),
        change_(label == Label::Free ? constant_ / (1 - ratio_)
                : label == Label::On ? std::numeric_limits<double>::infinity()
                                     : -1) {}

  void operator()(double s, double& rho, double& slope) const {
    const bool on = s <= change_;
    rho = weight_ * (on ? s : s * ratio_ + constant_);
    slope = weight_ * (on ? 1.0 : ratio_);
  }

 private:
  double ratio_, constant_, weight_, change_;
};

// The loss of links: dynamic covariance scaling [Agarwal2013], as a function that a solver can minimise.
//
// The method weighs a link of whitened square u by s^2, s = min(1, 2 Phi / (Phi + u)). The loss whose slope that weight is:
//   rho(u) = u                          for u <= Phi,
//            3 Phi - 4 Phi^2 / (Phi + u)  beyond,
// continuous with its slope, bounded by 3 Phi (docs/methods.md 16). Phi = 5 by default.
class ScalingLoss {
 public:
  explicit ScalingLoss(double phi) : phi_(phi) {}

  void operator()(double u, double& rho, double& slope) const {
    const double scale = u <= phi_ ? 1.0 : 2 * phi_ / (phi_ + u);
    rho = u <= phi_ ? u : 3 * phi_ - 2 * phi_ * scale;
    slope = scale * scale;
  }

 private:
  double phi_;
};

// The loss of a factor: Huber's, the mixture's, that of links or none. rho and its slope at s, the whitened residual squared.
struct Robust {
  double huber = std::numeric_limits<double>::infinity();
  std::optional<MixtureLoss> mixture;
  double scaling = std::numeric_limits<double>::infinity();  // Phi of ScalingLoss

  void operator()(double s, double& rho, double& slope) const {
    rho = s, slope = 1;
    if (mixture) {
      (*mixture)(s, rho, slope);
    } else if (s > huber * huber) {
      const double r = std::sqrt(s);
      rho = 2 * huber * r - huber * huber, slope = huber / r;
    } else if (s > scaling) {
      const ScalingLoss loss(scaling);
      loss(s, rho, slope);
    }
  }
};

}  // namespace hullrecon
