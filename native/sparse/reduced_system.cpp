// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/reduced_system.h"

#include <cholmod.h>

#include <algorithm>
#include <new>
#include <utility>

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

// The same where blocks of an interface, met by others still unseen, come last.
std::vector<int> order_before(const std::vector<int>& interface, const std::vector<int64_t>& start,
                              const std::vector<int32_t>& neighbours) {
  const auto blocks = static_cast<int>(start.size() - 1), interior = blocks - static_cast<int>(interface.size());
  std::vector<int> position(blocks, -1), number(blocks, -1), inner;
  for (size_t k = 0; k < interface.size(); ++k) position[interface[k]] = interior + static_cast<int>(k);
  for (int b = 0; b < blocks; ++b) {
    if (position[b] < 0) number[b] = static_cast<int>(inner.size()), inner.push_back(b);
  }
  std::vector<int64_t> inner_start{0};
  std::vector<int32_t> inner_neighbours;
  for (int b : inner) {
    for (int64_t k = start[b]; k < start[b + 1]; ++k) {
      if (number[neighbours[k]] >= 0) inner_neighbours.push_back(number[neighbours[k]]);
    }
    inner_start.push_back(static_cast<int64_t>(inner_neighbours.size()));
  }
  const std::vector<int> order = fill_reducing_order(inner_start, inner_neighbours);
  for (int k = 0; k < interior; ++k) position[inner[k]] = order[k];
  return position;
}

}  // namespace

ReducedSystem::ReducedSystem(std::vector<int> width, int border, const std::vector<int64_t>& start,
                             const std::vector<int32_t>& neighbours, int threads,
                             const std::optional<std::vector<int>>& interface, std::pmr::memory_resource* pages)
    : border_(border),
      position_(interface ? order_before(*interface, start, neighbours) : fill_reducing_order(start, neighbours)) {
  const auto blocks = static_cast<int>(width.size());
  const int interior = blocks - (interface ? static_cast<int>(interface->size()) : 0);
  std::vector<int> at(blocks), width_at;
  for (int b = 0; b < blocks; ++b) at[position_[b]] = b;
  std::vector<int64_t> below_start{0};
  std::vector<int32_t> below;
  for (int b : at) {
    const auto first = static_cast<int64_t>(below.size());
    for (int64_t k = start[b]; k < start[b + 1]; ++k) {
      const int other = position_[neighbours[k]];
      if (other > position_[b] && position_[b] < interior) below.push_back(other);
    }
    std::sort(below.begin() + first, below.end());
    for (int later = position_[b] + 1; position_[b] >= interior && later < blocks; ++later) below.push_back(later);
    below.push_back(blocks);
    below_start.push_back(static_cast<int64_t>(below.size()));
    width_at.push_back(width[b]);
  }
  position_.push_back(blocks), width_at.push_back(border), below_start.push_back(static_cast<int64_t>(below.size()));
  const int kept = interface ? blocks - interior + 1 : 0;
  fronts_ = std::make_unique<Fronts>(FrontTree(width_at, below_start, below, kept), threads, kept > 0, pages);
}

Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> ReducedSystem::lower(int a, int b) const {
  if (is_later(b, a)) std::swap(a, b);
  const auto [front, r, c] = tree().position(position_[a], position_[b]);
  return {fronts_->at(front, r, c), tree().width(position_[a]), tree().width(position_[b]),
          Eigen::OuterStride<>(tree().fronts()[front].height)};
}

Eigen::MatrixXd ReducedSystem::block(int a, int b) const {
  if (is_later(b, a)) return block(b, a).transpose();
  Eigen::MatrixXd m = lower(a, b);
  if (a == b) m.triangularView<Eigen::StrictlyUpper>() = m.transpose();
  return m;
}

void ReducedSystem::add_diagonal(const Eigen::VectorXd& d) {
  const FrontTree& tree = fronts_->tree();
  int k = 0;
  for (int f = 0; f < static_cast<int>(tree.fronts().size()); ++f) {
    for (int c = 0; c < tree.fronts()[f].size; ++c) *fronts_->at(f, c, c) += d[k++];
    fronts_->rest(f);  // each access has mapped the pages around it, in all of the panel
  }
}

}  // namespace hullrecon
