// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "model/linear_factor.h"

#include <cmath>

#include "common/errors.h"

namespace hullrecon {

void LinearFactor::at(const Model& model, int64_t number, bool with_derivatives) {
  model.blocks_of(number, blocks);
  const size_t count = blocks.size();
  const int rows = model.rows_of(number);
  x_.resize(count), sizes_.resize(count), pointers_.resize(count);
  if (raw_.size() < count) raw_.resize(count), by.resize(count);
  for (size_t k = 0; k < count; ++k) {
    const Block& block = model.blocks()[blocks[k]];
    x_[k] = block.data, sizes_[k] = block.size;
    const bool wanted = with_derivatives && block.tangent > 0;
    if (wanted) raw_[k].resize(static_cast<size_t>(rows) * block.size);
    pointers_[k] = wanted ? raw_[k].data() : nullptr;
  }
  residual.resize(rows);
  double** const derivatives = with_derivatives ? pointers_.data() : nullptr;
  const bool evaluated = model.evaluate(number, sizes_, x_.data(), residual.data(), derivatives);
  if (!evaluated || !std::isfinite(residual.squaredNorm())) {
    const std::string where =
        std::string(kKindNames[static_cast<int>(model.kind_of(number))]) + " " + std::to_string(model.row_of(number));
    throw StageError("a factor cannot be evaluated at this point", where, "look at the unknowns that it joins");
  }
  for (size_t k = 0; with_derivatives && k < count; ++k) {
    const Block& block = model.blocks()[blocks[k]];
    using Raw = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    by[k].resize(rows, block.tangent);
    if (block.tangent > 0) by[k] = Eigen::Map<const Raw>(raw_[k].data(), rows, block.size).leftCols(block.tangent);
  }
  double rho, slope;
  model.robust(number)(residual.squaredNorm(), rho, slope);
  cost = 0.5 * rho;
  weight = std::sqrt(slope);
}

}  // namespace hullrecon
