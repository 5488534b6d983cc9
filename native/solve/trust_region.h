// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Minimises by Levenberg-Marquardt, step for step as Ceres' trust region minimiser does [Ceres2023]: scaling by the columns at
// the start, damping by the clipped diagonal, radius by the step's quality, the same tests of convergence in the same order. So
// both cores take the same number of iterations, and one can be held against the other.
#pragma once

#include <chrono>

#include "solve/least_squares.h"

namespace hullrecon {

class TrustRegion {
 public:
  using Clock = std::chrono::steady_clock;
  // begun: when the problem's preparation did.
  TrustRegion(LeastSquares& problem, const Options& options, const std::function<bool()>& interrupted, Clock::time_point begun);

  Solution run();

 private:
  static constexpr double kLeastDecrease = 1e-3, kLeastRadius = 1e-32, kMostRadius = 1e16;
  static constexpr int kMostInvalid = 20;  // each refused step (rays lost) halves the radius, then quarters it, and so on

  void count(const char* name, Clock::time_point since);
  void refresh(bool trial);
  std::optional<Costs> evaluate();
  void linearise();
  void iterate();
  void try_step(IterationRow& row, double model_change);
  void accept(IterationRow& row, double cost, const Costs& costs, double quality);
  void reject();
  void finish(IterationRow row);
  void converge(std::string message);
  std::vector<std::pair<const char*, double>> seconds() const;

  const Clock::time_point start_;
  LeastSquares& problem_;
  const Options& options_;
  const std::function<bool()>& interrupted_;
  Solution solution_;
  std::vector<std::pair<const char*, double>> seconds_;
  double cost_ = 0, radius_, shrink_ = 2;
  int invalid_ = 0;
  bool done_ = false;
};

}  // namespace hullrecon
