// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The interface of a problem, whole or in parts, to a trust region: costs, derivatives and damped steps at unknowns that the
// problem itself keeps.
#pragma once

#include <optional>

#include "schur/schur.h"
#include "solve/solve.h"

namespace hullrecon {

using Costs = std::array<double, kKindNames.size()>;

class LeastSquares {
 public:
  virtual ~LeastSquares() = default;

  // Closest triangles and hits at the unknowns. trial: losing too many beams refuses the point (model/association.h).
  virtual void refresh(bool trial) = 0;
  virtual std::optional<Costs> cost() = 0;  // by kind; empty: the unknowns cannot be evaluated
  virtual void linearise() = 0;
  // Measures each unknown in a unit of its own, from here on: one plus its column's norm.
  virtual void scale() = 0;

  // Solves the normal equations damped to a radius. By how much the step lowers the cost of the linear problem; empty: it could
  // not be solved.
  virtual std::optional<double> step(double radius) = 0;
  struct Lengths {
    double unknowns, step;
  };
  virtual Lengths move() = 0;    // tries the unknowns moved by the step
  virtual void accept() = 0;     // keeps them
  virtual void take_back() = 0;  // or returns to those before

  virtual void describe(IterationRow& row) = 0;  // labels and misses at unknowns that were accepted
  virtual double gradient_norm() = 0;            // how far the unknowns would move at most along the gradient
  virtual void end() = 0;                        // leaves the accepted unknowns, with all that belongs to them
  virtual Schur::Seconds seconds() const = 0;    // that steps have taken, by stage
};

// Ceres' damping: each unknown's square, clipped in its own unit, over the radius.
inline Eigen::VectorXd damping(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& scale, double radius) {
  constexpr double kLeast = 1e-6, kMost = 1e32;
  return (diagonal.array() / scale.array()).max(kLeast).min(kMost) * scale.array() / radius;
}

inline Eigen::VectorXd scale_of(const Eigen::VectorXd& diagonal) {
  return (1 + diagonal.array().sqrt()).square();
}

}  // namespace hullrecon
