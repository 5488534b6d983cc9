// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model/model.h"

namespace hullrecon {

// Rows in the order of the factors (kinds in turn, table rows in order); columns as Model says. Whitened, not robustified:
// weight holds each row's square root of rho'.
struct Evaluation {
  std::vector<double> residual, weight;
  std::vector<int32_t> kind, table_row;
  std::vector<int64_t> start;  // compressed rows, columns ascending
  std::vector<int64_t> column;
  std::vector<double> value;
  std::array<double, kKindNames.size()> cost;
};

// with_jacobian: false leaves start, column and value of empty rows, which else are nine tenths of the memory.
Evaluation evaluate(Model& model, bool with_jacobian);

}  // namespace hullrecon
