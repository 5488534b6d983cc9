// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Minimises by Levenberg-Marquardt over the Schur core, step for step as Ceres' trust region minimiser does [Ceres2023]:
// scaling by the columns at the start, damping by the clipped diagonal, radius by the step's quality, the same tests of
// convergence in the same order. So both cores take the same number of iterations, and one can be held against the other.
#include <chrono>
#include <cmath>

#include "common/errors.h"
#include "schur/schur.h"
#include "solve/solve.h"

namespace hullrecon {
namespace {

using Clock = std::chrono::steady_clock;
using Costs = std::array<double, kKindNames.size()>;

double sum(const Costs& costs) {
  double total = 0;
  for (double c : costs) total += c;
  return total;
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%e", x);
  return text;
}

class TrustRegion {
 public:
  TrustRegion(Model& model, const std::function<bool()>& interrupted)
      : model_(model), options_(model.options()), interrupted_(interrupted), schur_(model), x_(model.unknowns()) {
    part("preprocess", start_);
  }

  Solution run() {
    refresh(false);
    const auto costs = evaluate();
    if (!costs) throw StageError("the solver failed", "the start cannot be evaluated", "look at the start values");
    cost_ = sum(*costs);
    linearise();
    scale();
    finish({cost_, 0, 0, 0, 0, 0, true, *costs, 0, 0, 0});
    while (!done_) iterate();
    std::copy(x_.begin(), x_.end(), model_.unknowns().begin());
    model_.refresh(false, true);
    return std::move(solution_);
  }

  // What took how long, the whole last.
  std::vector<std::pair<const char*, double>> seconds() {
    auto out = seconds_;
    out.insert(out.end(), {{"eliminate", schur_.seconds.eliminate},
                           {"factor", schur_.seconds.factor},
                           {"back_substitute", schur_.seconds.back_substitute},
                           {"total", std::chrono::duration<double>(Clock::now() - start_).count()}});
    return out;
  }

 private:
  static constexpr double kLeastDiagonal = 1e-6, kMostDiagonal = 1e32, kLeastDecrease = 1e-3, kLeastRadius = 1e-32,
                          kMostRadius = 1e16;
  static constexpr int kMostInvalid = 20;  // each refused step (rays lost) halves the radius, then quarters it, and so on

  void part(const char* name, Clock::time_point since) {
    const double s = std::chrono::duration<double>(Clock::now() - since).count();
    for (auto& [known, time] : seconds_) {
      if (std::string_view(known) == name) return void(time += s);
    }
    seconds_.emplace_back(name, s);
  }
  void refresh(bool trial) {
    const auto since = Clock::now();
    model_.refresh(trial);
    part("refresh", since);
  }
  std::optional<Costs> evaluate() {
    const auto since = Clock::now();
    auto costs = schur_.cost();
    part("residuals", since);
    return costs;
  }
  void linearise() {
    const auto since = Clock::now();
    schur_.linearise();
    part("jacobians", since);
  }

  // Each column's norm at the start, squared: 1 + norm measures an unknown in its own unit.
  void scale() {
    const auto of = [](const Eigen::VectorXd& d) { return Eigen::VectorXd((1 + d.array().sqrt()).square()); };
    scale_ = {of(schur_.diagonal().landmark), of(schur_.diagonal().reduced)};
  }
  StepVector damping() const {
    const auto of = [&](const Eigen::VectorXd& d, const Eigen::VectorXd& scale) {
      return Eigen::VectorXd((d.array() / scale.array()).max(kLeastDiagonal).min(kMostDiagonal) * scale.array() / radius_);
    };
    return {of(schur_.diagonal().landmark, scale_.landmark), of(schur_.diagonal().reduced, scale_.reduced)};
  }

  void iterate() {
    const auto since = Clock::now();
    IterationRow row = solution_.iterations.back();
    row.cost = cost_, row.cost_change = row.step_norm = 0, row.accepted = false, row.label_changes = 0;
    const StepVector diagonal = damping();
    const bool solved = schur_.step(diagonal, step_);
    part("linear_solver", since);
    const double model_change =
        solved ? -0.5 * schur_.gradient().dot(step_) +
                     0.5 * (diagonal.landmark.dot(step_.landmark.cwiseAbs2()) + diagonal.reduced.dot(step_.reduced.cwiseAbs2()))
               : 0.0;
    if (!(model_change > 0)) {
      if (++invalid_ >= kMostInvalid) fail("no step lowers the cost in " + std::to_string(kMostInvalid) + " trials");
      reject();
      return finish(row);
    }
    invalid_ = 0;
    try_step(row, model_change);
  }

  void try_step(IterationRow& row, double model_change) {
    schur_.plus(x_, step_, candidate_);
    std::copy(candidate_.begin(), candidate_.end(), model_.unknowns().begin());
    refresh(true);
    const auto costs = evaluate();
    const double cost = costs ? sum(*costs) : std::numeric_limits<double>::max();
    using Vector = Eigen::Map<const Eigen::VectorXd>;
    const auto size = static_cast<Eigen::Index>(x_.size());
    const double x_norm = Vector(x_.data(), size).norm();
    row.step_norm = (Vector(x_.data(), size) - Vector(candidate_.data(), size)).norm();
    row.cost_change = cost_ - cost;
    const double least_step = options_.parameter_tolerance * (x_norm + options_.parameter_tolerance);
    if (row.step_norm <= least_step) {
      return converge("Parameter tolerance reached. Relative step_norm: " +
                      number(row.step_norm / (x_norm + options_.parameter_tolerance)) +
                      " <= " + number(options_.parameter_tolerance));
    }
    if (std::abs(row.cost_change) <= options_.function_tolerance * cost_) {
      return converge("Function tolerance reached. |cost_change|/cost: " + number(std::abs(row.cost_change) / cost_) +
                      " <= " + number(options_.function_tolerance));
    }
    const double quality = row.cost_change / model_change;
    row.cost = cost;
    if (costs && quality > kLeastDecrease) {
      accept(row, cost, *costs, quality);
    } else {
      reject();
    }
    finish(row);
  }

  void accept(IterationRow& row, double cost, const Costs& costs, double quality) {
    x_.swap(candidate_);
    cost_ = cost;
    linearise();
    radius_ = std::min(kMostRadius, radius_ / std::max(1.0 / 3, 1 - std::pow(2 * quality - 1, 3)));
    shrink_ = 2;
    row.accepted = true, row.cost_by_kind = costs;
  }

  void reject() {
    std::copy(x_.begin(), x_.end(), model_.unknowns().begin());
    schur_.restore();
    radius_ /= shrink_;
    shrink_ *= 2;
  }

  void finish(IterationRow row) {
    if (interrupted_()) throw Interrupted();
    if (row.accepted) {
      const auto since = Clock::now();
      model_.association().accept();
      row.on_surface = 0, row.label_changes = 0;
      labels_.describe(model_, row);
      row.gradient_norm = gradient_norm();
      part("record", since);
    }
    row.radius = radius_;
    row.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    solution_.iterations.push_back(row);
    if (static_cast<int>(solution_.iterations.size()) > options_.max_iterations) {
      done_ = true;
      solution_.converged = false;
      solution_.message =
          "Maximum number of iterations reached. Number of iterations: " + std::to_string(options_.max_iterations) + ".";
    } else if (row.accepted && row.gradient_norm <= options_.gradient_tolerance) {
      converge("Gradient tolerance reached. Gradient max norm: " + number(row.gradient_norm) +
               " <= " + number(options_.gradient_tolerance));
    } else if (radius_ <= kLeastRadius) {
      converge("Minimum certificate region radius reached. Certificate region radius: " + number(radius_));
    }
  }

  // How far the unknowns would move at most along the gradient.
  double gradient_norm() {
    step_ = {-schur_.gradient().landmark, -schur_.gradient().reduced};
    schur_.plus(x_, step_, candidate_);
    double most = 0;
    for (size_t k = 0; k < x_.size(); ++k) most = std::max(most, std::abs(x_[k] - candidate_[k]));
    return most;
  }

  void converge(std::string message) {
    done_ = true;
    solution_.converged = true;
    solution_.message = std::move(message);
  }
  [[noreturn]] static void fail(const std::string& why) {
    throw StageError("the solver failed", why, "look at the start values");
  }

  Clock::time_point start_ = Clock::now();
  Model& model_;
  const Options& options_;
  const std::function<bool()>& interrupted_;
  Schur schur_;
  LabelCount labels_;
  Solution solution_;
  std::vector<std::pair<const char*, double>> seconds_;
  std::vector<double> x_, candidate_;
  StepVector scale_, step_;
  double cost_ = 0, radius_ = options_.initial_radius, shrink_ = 2;
  int invalid_ = 0;
  bool done_ = false;
};

}  // namespace

Solution solve_by_schur(Model& model, const std::function<bool()>& interrupted) {
  TrustRegion region(model, interrupted);
  Solution solution = region.run();
  solution.seconds = region.seconds();
  return solution;
}

}  // namespace hullrecon
