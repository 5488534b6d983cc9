// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/whole_problem.h"

#include <algorithm>
#include <cmath>

namespace hullrecon {

std::optional<double> WholeProblem::step(double radius) {
  const StepVector& diagonal = schur_.diagonal();
  const StepVector d{damping(diagonal.landmark, scale_.landmark, radius), damping(diagonal.reduced, scale_.reduced, radius)};
  if (!schur_.step(d, step_)) return std::nullopt;
  return -0.5 * schur_.gradient().dot(step_) +
         0.5 * (d.landmark.dot(step_.landmark.cwiseAbs2()) + d.reduced.dot(step_.reduced.cwiseAbs2()));
}

LeastSquares::Lengths WholeProblem::move() {
  schur_.plus(x_, step_, candidate_);
  set(candidate_);
  const auto size = static_cast<Eigen::Index>(x_.size());
  const Eigen::Map<const Eigen::VectorXd> x(x_.data(), size), candidate(candidate_.data(), size);
  return {x.norm(), (x - candidate).norm()};
}

void WholeProblem::take_back() {
  set(x_);
  schur_.restore();
}

void WholeProblem::describe(IterationRow& row) {
  model_.association().accept();
  labels_.describe(model_, row);
}

double WholeProblem::gradient_norm() {
  step_ = {-schur_.gradient().landmark, -schur_.gradient().reduced};
  schur_.plus(x_, step_, candidate_);
  double most = 0;
  for (size_t k = 0; k < x_.size(); ++k) most = std::max(most, std::abs(x_[k] - candidate_[k]));
  return most;
}

void WholeProblem::end() {
  set(x_);
  model_.refresh(false, true);
}

}  // namespace hullrecon
