// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "model/model.h"

namespace hullrecon {

struct IterationRow {
  double cost, cost_change, step_norm, gradient_norm, radius, seconds;
  bool accepted;
  std::array<double, kKindNames.size()> cost_by_kind;  // these and the counts: at the last accepted point
  int64_t on_surface, label_changes, rays_missed;
};

struct Solution {
  std::vector<IterationRow> iterations;
  bool converged;
  std::string message;
  std::vector<std::pair<const char*, double>> seconds;
};

// Moves the model's unknowns to the least cost. interrupted() is asked between iterations; true throws Interrupted.
// Throws StageError when the start cannot be evaluated or the solver fails.
Solution solve(Model& model, const std::function<bool()>& interrupted);

struct ProblemPart;  // solve/joined_problem.h

// The same of a problem in parts, by our core, to the same unknowns in the same steps.
Solution solve(const std::vector<ProblemPart>& parts, const std::function<bool()>& interrupted);

// Its two routes, by Options::core. Both take the same steps: Levenberg and Marquardt's as Ceres does them.
Solution solve_by_ceres(Model& model, const std::function<bool()>& interrupted);
Solution solve_by_schur(Model& model, const std::function<bool()>& interrupted);

// Fills the counts of an accepted row, and keeps the labels to compare the next ones with; a rejected row repeats the last.
class LabelCount {
 public:
  void describe(Model& model, IterationRow& row);
  void shelve(Shelf& shelf) { shelf.add(labels_); }

 private:
  std::vector<int32_t> labels_;
};

}  // namespace hullrecon
