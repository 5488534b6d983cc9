// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/trust_region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "common/errors.h"

namespace hullrecon {
namespace {

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

[[noreturn]] void fail(const std::string& why) {
  throw StageError("the solver failed", why, "look at the start values");
}

}  // namespace

TrustRegion::TrustRegion(LeastSquares& problem, const Options& options, const std::function<bool()>& interrupted,
                         Clock::time_point begun)
    : start_(begun), problem_(problem), options_(options), interrupted_(interrupted), radius_(options.initial_radius) {
  count("preprocess", start_);
}

Solution TrustRegion::run() {
  refresh(false);
  const auto costs = evaluate();
  if (!costs) fail("the start cannot be evaluated");
  cost_ = sum(*costs);
  linearise();
  problem_.scale();
  finish({cost_, 0, 0, 0, 0, 0, true, *costs, 0, 0, 0});
  while (!done_) iterate();
  problem_.end();
  solution_.seconds = seconds();
  return std::move(solution_);
}

// What took how long, the whole last.
std::vector<std::pair<const char*, double>> TrustRegion::seconds() const {
  const Schur::Seconds steps = problem_.seconds();
  auto out = seconds_;
  out.insert(out.end(), {{"eliminate", steps.eliminate},
                         {"factor", steps.factor},
                         {"back_substitute", steps.back_substitute},
                         {"total", std::chrono::duration<double>(Clock::now() - start_).count()}});
  return out;
}

void TrustRegion::count(const char* name, Clock::time_point since) {
  const double s = std::chrono::duration<double>(Clock::now() - since).count();
  for (auto& [known, time] : seconds_) {
    if (std::string_view(known) == name) return void(time += s);
  }
  seconds_.emplace_back(name, s);
}

void TrustRegion::refresh(bool trial) {
  const auto since = Clock::now();
  problem_.refresh(trial);
  count("refresh", since);
}

std::optional<Costs> TrustRegion::evaluate() {
  const auto since = Clock::now();
  auto costs = problem_.cost();
  count("residuals", since);
  return costs;
}

void TrustRegion::linearise() {
  const auto since = Clock::now();
  problem_.linearise();
  count("jacobians", since);
}

void TrustRegion::iterate() {
  const auto since = Clock::now();
  IterationRow row = solution_.iterations.back();
  row.cost = cost_, row.cost_change = row.step_norm = 0, row.accepted = false, row.label_changes = 0;
  const double model_change = problem_.step(radius_).value_or(0.0);
  count("linear_solver", since);
  if (!(model_change > 0)) {
    if (++invalid_ >= kMostInvalid) fail("no step lowers the cost in " + std::to_string(kMostInvalid) + " trials");
    reject();
    return finish(row);
  }
  invalid_ = 0;
  try_step(row, model_change);
}

void TrustRegion::try_step(IterationRow& row, double model_change) {
  const LeastSquares::Lengths length = problem_.move();
  refresh(true);
  const auto costs = evaluate();
  const double cost = costs ? sum(*costs) : std::numeric_limits<double>::max();
  row.step_norm = length.step;
  row.cost_change = cost_ - cost;
  const double least_step = options_.parameter_tolerance * (length.unknowns + options_.parameter_tolerance);
  if (row.step_norm <= least_step) {
    return converge("Parameter tolerance reached. Relative step_norm: " +
                    number(row.step_norm / (length.unknowns + options_.parameter_tolerance)) +
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

void TrustRegion::accept(IterationRow& row, double cost, const Costs& costs, double quality) {
  problem_.accept();
  cost_ = cost;
  linearise();
  radius_ = std::min(kMostRadius, radius_ / std::max(1.0 / 3, 1 - std::pow(2 * quality - 1, 3)));
  shrink_ = 2;
  row.accepted = true, row.cost_by_kind = costs;
}

void TrustRegion::reject() {
  problem_.take_back();
  radius_ /= shrink_;
  shrink_ *= 2;
}

void TrustRegion::finish(IterationRow row) {
  if (interrupted_()) throw Interrupted();
  if (row.accepted) {
    const auto since = Clock::now();
    row.on_surface = row.label_changes = row.rays_missed = 0;
    problem_.describe(row);
    row.gradient_norm = problem_.gradient_norm();
    count("record", since);
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
    converge("Minimum trust region radius reached. Trust region radius: " + number(radius_));
  }
}

void TrustRegion::converge(std::string message) {
  done_ = true;
  solution_.converged = true;
  solution_.message = std::move(message);
}

}  // namespace hullrecon
