// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/evaluate.h"

#include <algorithm>

#include "common/parallel.h"
#include "model/linear_factor.h"

namespace hullrecon {
namespace {

// Free blocks of a factor by ascending column.
std::vector<size_t> by_column(const Model& model, const std::vector<int32_t>& blocks) {
  std::vector<size_t> order(blocks.size());
  for (size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return blocks[a] < blocks[b]; });
  std::erase_if(order, [&](size_t k) { return model.blocks()[blocks[k]].tangent == 0; });
  return order;
}

void lay_out(const Model& model, bool with_jacobian, Evaluation& out, std::vector<int64_t>& first_row) {
  out.start.assign(1, 0);
  std::vector<int32_t> blocks;
  for (int64_t i = 0; i < model.factors(); ++i) {
    model.blocks_of(i, blocks);
    first_row.push_back(static_cast<int64_t>(out.start.size()) - 1);
    int64_t width = 0;
    if (with_jacobian)
      for (int32_t b : blocks) width += model.blocks()[b].tangent;
    for (int r = 0; r < model.rows_of(i); ++r) {
      out.start.push_back(out.start.back() + width);
      out.kind.push_back(static_cast<int32_t>(model.kind_of(i)));
      out.table_row.push_back(static_cast<int32_t>(model.row_of(i)));
    }
  }
  out.residual.resize(out.kind.size()), out.weight.resize(out.kind.size());
  out.column.resize(out.start.back()), out.value.resize(out.start.back());
}

void write(const Model& model, const LinearFactor& linear, bool with_jacobian, int64_t first, Evaluation& out) {
  const auto order = with_jacobian ? by_column(model, linear.blocks) : std::vector<size_t>{};
  for (int r = 0; r < linear.residual.size(); ++r) {
    out.residual[first + r] = linear.residual[r];
    out.weight[first + r] = linear.weight;
    int64_t at = out.start[first + r];
    for (size_t k : order) {
      for (int c = 0; c < linear.by[k].cols(); ++c, ++at) {
        out.column[at] = model.blocks()[linear.blocks[k]].column + c;
        out.value[at] = linear.by[k](r, c);
      }
    }
  }
}

}  // namespace

Evaluation evaluate(Model& model, bool with_jacobian) {
  model.refresh(false, true);
  Evaluation out;
  std::vector<int64_t> first_row;
  lay_out(model, with_jacobian, out, first_row);
  for_slabs(model.factors(), model.options().threads, [&](int64_t begin, int64_t end) {
    LinearFactor linear;
    for (int64_t i = begin; i < end; ++i) {
      linear.at(model, i, with_jacobian);
      write(model, linear, with_jacobian, first_row[i], out);
    }
  });
  out.cost = model.costs();
  return out;
}

}  // namespace hullrecon
