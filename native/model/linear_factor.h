// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Linearises one factor at the present unknowns, in tangent coordinates.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/model.h"

namespace hullrecon {

struct LinearFactor {
  Eigen::VectorXd residual;         // whitened, without the robust weight
  double weight = 1;                // square root of rho': multiplies residual and derivatives in the information
  double cost = 0;                  // robustified
  std::vector<int32_t> blocks;      // that it joins
  std::vector<Eigen::MatrixXd> by;  // derivative by each block of the factor; no columns where it is held

  // Throws StageError naming the factor when it cannot be evaluated. Reuses its memory from call to call. Without derivatives,
  // `by` is not what it says.
  void at(const Model& model, int64_t factor, bool with_derivatives = true);

 private:
  std::vector<const double*> x_;
  std::vector<int> sizes_;
  std::vector<double*> pointers_;
  std::vector<std::vector<double>> raw_;
};

}  // namespace hullrecon
