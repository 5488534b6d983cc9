// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/reduced_system.h"

#include <cholmod.h>

#include <algorithm>
#include <new>

namespace hullrecon {
namespace {

// Fill-reducing, and a postorder of the elimination tree; on the graph of blocks, some thirty times smaller than that of
// scalars. The position of each.
std::vector<int> fill_reducing_order(const std::vector<int64_t>& start, const std::vector<int32_t>& neighbours) {
  const auto blocks = static_cast<int>(start.size() - 1);
  std::vector<int> p{0}, i, position(blocks);
  for (int b = 0; b < blocks; ++b) {
    i.push_back(b);
    for (int64_t k = start[b]; k < start[b + 1]; ++k) {
      if (neighbours[k] > b) i.push_back(neighbours[k]);
    }
    std::sort(i.begin() + p.back(), i.end());
    p.push_back(static_cast<int>(i.size()));
  }
  if (blocks == 0) return position;
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  common.nmethods = 2;
  common.postorder = 1;
  common.method[0].ordering = CHOLMOD_AMD, common.method[1].ordering = CHOLMOD_METIS;
  cholmod_sparse graph{};
  graph.nrow = graph.ncol = blocks;
  graph.nzmax = i.size();
  graph.p = p.data(), graph.i = i.data();
  graph.stype = -1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.dtype = CHOLMOD_DOUBLE;
  graph.sorted = graph.packed = 1;
  cholmod_factor* symbolic = cholmod_analyze(&graph, &common);
  for (int k = 0; symbolic && k < blocks; ++k) position[static_cast<int*>(symbolic->Perm)[k]] = k;
  const bool done = symbolic;
  cholmod_free_factor(&symbolic, &common);
  cholmod_finish(&common);
  if (!done) throw std::bad_alloc();
  return position;
}

}  // namespace

ReducedSystem::ReducedSystem(std::vector<int> width, int border, const std::vector<int64_t>& start,
                             const std::vector<int32_t>& neighbours, int threads)
    : border_(border), position_(fill_reducing_order(start, neighbours)) {
  const auto blocks = static_cast<int>(width.size());
  std::vector<int> at(blocks), width_at;
  for (int b = 0; b < blocks; ++b) at[position_[b]] = b;
  std::vector<int64_t> below_start{0};
  std::vector<int32_t> below;
  for (int b : at) {
    const auto first = static_cast<int64_t>(below.size());
    for (int64_t k = start[b]; k < start[b + 1]; ++k) {
      if (position_[neighbours[k]] > position_[b]) below.push_back(position_[neighbours[k]]);
    }
    std::sort(below.begin() + first, below.end());
    below.push_back(blocks);
    below_start.push_back(static_cast<int64_t>(below.size()));
    width_at.push_back(width[b]);
  }
  position_.push_back(blocks), width_at.push_back(border), below_start.push_back(static_cast<int64_t>(below.size()));
  fronts_ = std::make_unique<Fronts>(FrontTree(width_at, below_start, below), threads);
}

void ReducedSystem::add_diagonal(const Eigen::VectorXd& d) {
  const FrontTree& tree = fronts_->tree();
  int k = 0;
  for (int f = 0; f < static_cast<int>(tree.fronts().size()); ++f) {
    for (int c = 0; c < tree.fronts()[f].size; ++c) *fronts_->at(f, c, c) += d[k++];
  }
}

}  // namespace hullrecon
