// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "model/model.h"

namespace hullrecon {

// Joint marginals of pairs of poses and T_s_ct in tangent coordinates, row major; zero where a coordinate is held.
struct PairCovariance {
  std::vector<double> pose;        // (m, 14, 14)
  std::vector<double> pose_mount;  // (m, 14, 6)
  std::vector<double> mount;       // (6, 6)
};

// Joint covariances of pairs of poses that need no factor between them, at the model's unknowns. Throws StageError naming what
// is not determined.
PairCovariance pair_covariance(Model& model, const std::vector<std::array<int32_t, 2>>& pairs);

}  // namespace hullrecon
