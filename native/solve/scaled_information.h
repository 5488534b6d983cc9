// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The reduced information scaled to a unit diagonal, so that a pivot says what share of an unknown is determined.
#pragma once

#include <vector>

#include "solve/information.h"
#include "sparse/supernodal_factor.h"

namespace hullrecon {

struct ScaledInformation {
  Lower lower;
  std::vector<double> scale;  // of each scalar: A = diag(scale) information diag(scale)

  // Throws StageError naming an unknown that no factor meets.
  ScaledInformation(const Model& model, Information& information);
  // Throws StageError with the three largest entries of the direction that the information leaves free, in words.
  [[noreturn]] void refuse(const Model& model, const Information& information) const;
};

}  // namespace hullrecon
