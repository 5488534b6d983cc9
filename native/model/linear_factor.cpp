// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "model/linear_factor.h"

#include <cmath>

#include "common/errors.h"

namespace hullrecon {

void LinearFactor::at(const Model& model, int64_t number) {
  const Factor factor = model.factor(number);
  blocks = factor.blocks;
  const size_t count = factor.blocks.size();
  const int rows = factor.cost->num_residuals();
  x_.resize(count), pointers_.resize(count);
  if (raw_.size() < count) raw_.resize(count), by.resize(count);
  for (size_t k = 0; k < count; ++k) {
    const Block& block = model.blocks()[factor.blocks[k]];
    x_[k] = block.data;
    if (block.tangent > 0) raw_[k].resize(static_cast<size_t>(rows) * block.size);
    pointers_[k] = block.tangent > 0 ? raw_[k].data() : nullptr;
  }
  residual.resize(rows);
  const bool evaluated = factor.cost->Evaluate(x_.data(), residual.data(), pointers_.data());
  if (!evaluated || !std::isfinite(residual.squaredNorm())) {
    const std::string where = std::string(kKindNames[static_cast<int>(factor.kind)]) + " " + std::to_string(factor.row);
    throw StageError("a factor cannot be evaluated at this point", where, "look at the unknowns that it joins");
  }
  for (size_t k = 0; k < count; ++k) {
    const Block& block = model.blocks()[factor.blocks[k]];
    using Raw = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    by[k].resize(rows, block.tangent);
    if (block.tangent > 0) by[k] = Eigen::Map<const Raw>(raw_[k].data(), rows, block.size).leftCols(block.tangent);
  }
  double rho[3] = {residual.squaredNorm(), 1, 0};
  if (factor.loss) factor.loss->Evaluate(residual.squaredNorm(), rho);
  cost = 0.5 * rho[0];
  weight = std::sqrt(rho[1]);
}

}  // namespace hullrecon
