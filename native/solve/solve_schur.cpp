// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/trust_region.h"
#include "solve/whole_problem.h"

namespace hullrecon {

Solution solve_by_schur(Model& model, const std::function<bool()>& interrupted) {
  const auto begun = TrustRegion::Clock::now();
  WholeProblem problem(model);
  return TrustRegion(problem, model.options(), interrupted, begun).run();
}

}  // namespace hullrecon
