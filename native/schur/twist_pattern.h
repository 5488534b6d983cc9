// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Which blocks of the reduced system are not zero: two blocks meet where a landmark or a small factor joins them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/small_factors.h"
#include "schur/surface_terms.h"
#include "sparse/reduced_system.h"

namespace hullrecon {

// Blocks of X, the information on the poses' twists and the field's nodes (docs/schur.md, 9): of each pose's row those from the
// diagonal on, 6 by 6 with poses, 6 by 1 with nodes, one after another in one array.
class TwistPattern {
 public:
  TwistPattern(const ReducedLayout& layout, const ImageTerms& images, const SurfaceTerms& surface, const SmallFactors& small,
               int threads);

  struct Entry {
    int32_t block;  // its column, or in below() its row
    int64_t place;  // of its first number
  };
  // Row of a pose, the diagonal first; of one that sees no landmark empty.
  std::span<const Entry> row(int pose) const {
    return {row_.data() + row_start_[pose], static_cast<size_t>(row_start_[pose + 1] - row_start_[pose])};
  }
  // Rows of other poses that have an entry in the column of this block.
  std::span<const Entry> below(int block) const {
    return {column_.data() + column_start_[block], static_cast<size_t>(column_start_[block + 1] - column_start_[block])};
  }
  int64_t size() const { return size_; }
  void shelve(Shelf& shelf) { shelf.add(row_start_, column_start_, neighbour_start_, row_, column_, neighbour_); }
  // The reduced system on this pattern, small factors counted in. interface: of a part, its blocks that others meet.
  std::unique_ptr<ReducedSystem> reduced_system(const std::optional<std::vector<int>>& interface,
                                                std::pmr::memory_resource* pages) const;

 private:
  struct Neighbours {
    std::vector<int32_t> by_landmarks, by_factors;  // ascending; those not met by landmarks
  };
  Neighbours neighbours_of(int block, std::vector<char>& met) const;
  void lay_out(std::vector<Neighbours>& neighbours);

  const ReducedLayout& layout_;
  const ImageTerms& images_;
  const SurfaceTerms& surface_;
  const SmallFactors& small_;
  int threads_;
  std::vector<int64_t> row_start_, column_start_, neighbour_start_;
  std::vector<Entry> row_, column_;
  std::vector<int32_t> neighbour_;
  int64_t size_ = 0;
};

}  // namespace hullrecon
