// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/solve.h"

#include "common/blas_guard.h"
#include "solve/joined_problem.h"
#include "solve/trust_region.h"

namespace hullrecon {

Solution solve(Model& model, const std::function<bool()>& interrupted) {
  const BlasGuard guard;
  return model.options().core == "ceres" ? solve_by_ceres(model, interrupted) : solve_by_schur(model, interrupted);
}

Solution solve(const std::vector<ProblemPart>& parts, const std::function<bool()>& interrupted) {
  const BlasGuard guard;
  const auto begun = TrustRegion::Clock::now();
  JoinedProblem problem(parts);
  return TrustRegion(problem, parts.front().model->options(), interrupted, begun).run();
}

void LabelCount::describe(Model& model, IterationRow& row) {
  std::vector<int32_t> now = model.labels();
  for (size_t i = 0; i < now.size(); ++i) {
    row.on_surface += now[i];
    row.label_changes += !labels_.empty() && now[i] != labels_[i];
  }
  labels_ = std::move(now);
  row.rays_missed = model.association().missed();
}

}  // namespace hullrecon
