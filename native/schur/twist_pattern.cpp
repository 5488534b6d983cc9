// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/twist_pattern.h"

#include <algorithm>
#include <numeric>

#include "common/parallel.h"

namespace hullrecon {

TwistPattern::TwistPattern(const ReducedLayout& layout, const ImageTerms& images, const SurfaceTerms& surface,
                           const SmallFactors& small, int threads)
    : layout_(layout), images_(images), surface_(surface), small_(small), threads_(threads) {
  std::vector<Neighbours> neighbours(layout.blocks());
  for_slabs(
      layout.blocks(), threads,
      [&](int64_t begin, int64_t end) {
        std::vector<char> met(layout.blocks(), 0);
        for (int64_t b = begin; b < end; ++b) neighbours[b] = neighbours_of(static_cast<int>(b), met);
      },
      8);
  lay_out(neighbours);
}

// The blocks that a landmark of this block, or a small factor, joins it to; itself left out. met: all zero between calls.
TwistPattern::Neighbours TwistPattern::neighbours_of(int block, std::vector<char>& met) const {
  Neighbours out;
  std::vector<int32_t>* to = &out.by_landmarks;
  const auto meet = [&](int32_t other) {
    if (met[other]) return;
    met[other] = 1;
    to->push_back(other);
  };
  const auto meet_landmark = [&](int64_t rank) {
    for (int32_t w = images_.first_view(rank); w < images_.first_view(rank + 1); ++w) meet(images_.view(w).pose);
    if (layout_.nodes() == 0) return;
    for (const SurfaceTerm& term : surface_.of_landmark(rank)) {
      for (int32_t node : surface_.nodes(term)) meet(layout_.node(node));
    }
  };
  met[block] = 1;
  if (block < layout_.poses()) {
    for (int32_t v : images_.views_of_pose(block)) meet_landmark(images_.view(v).landmark);
  } else if (block < layout_.other(0)) {
    for (int32_t k : surface_.of_node(block - layout_.poses())) meet_landmark(surface_[k].rank);
  }
  to = &out.by_factors;
  for (int32_t f : small_.of_block(block)) {
    for (const SmallFactors::Part& part : small_.parts(f)) {
      if (part.border < 0) meet(part.block);
    }
  }
  met[block] = 0;
  for (int32_t other : out.by_landmarks) met[other] = 0;
  for (int32_t other : out.by_factors) met[other] = 0;
  std::sort(out.by_landmarks.begin(), out.by_landmarks.end());
  return out;
}

void TwistPattern::lay_out(std::vector<Neighbours>& neighbours) {
  const int poses = layout_.poses(), blocks = layout_.blocks();
  const auto append = [&](int32_t block, int64_t numbers) {
    row_.push_back({block, size_});
    size_ += numbers;
  };
  neighbour_start_.assign(1, 0), row_start_.assign(1, 0), column_start_.assign(blocks + 1, 0);
  for (int b = 0; b < blocks; ++b) {
    const Neighbours met = std::move(neighbours[b]);
    if (b < poses) {
      if (images_.sees(b)) append(b, 36);
      for (int32_t other : met.by_landmarks) {
        if (other < b) continue;
        append(other, other < poses ? 36 : 6);
        ++column_start_[other + 1];
      }
      row_start_.push_back(static_cast<int64_t>(row_.size()));
    }
    neighbour_.insert(neighbour_.end(), met.by_landmarks.begin(), met.by_landmarks.end());
    neighbour_.insert(neighbour_.end(), met.by_factors.begin(), met.by_factors.end());
    neighbour_start_.push_back(static_cast<int64_t>(neighbour_.size()));
  }
  std::partial_sum(column_start_.begin(), column_start_.end(), column_start_.begin());
  column_.resize(column_start_.back());
  std::vector<int64_t> at(column_start_);
  for (int b = 0; b < poses; ++b) {
    for (const Entry& entry : row(b)) {
      if (entry.block != b) column_[at[entry.block]++] = {b, entry.place};
    }
  }
}

std::unique_ptr<ReducedSystem> TwistPattern::reduced_system(const std::optional<std::vector<int>>& interface,
                                                            std::pmr::memory_resource* pages) const {
  std::vector<int> width(layout_.blocks());
  for (int b = 0; b < layout_.blocks(); ++b) width[b] = layout_.width(b);
  return std::make_unique<ReducedSystem>(std::move(width), layout_.border(), neighbour_start_, neighbour_, threads_, interface,
                                         pages);
}

}  // namespace hullrecon
