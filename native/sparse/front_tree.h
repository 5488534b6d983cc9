// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Lays out the Cholesky factor of a symmetric matrix of blocks: the elimination tree, its columns gathered to fronts
// (supernodes), and where the rows of one front stand in its parent's. No numbers here.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace hullrecon {

// Neighbouring block columns kept as one dense panel, by columns: their own square block on top, the rows that they meet below.
struct Front {
  int32_t first, last;         // block columns [first, last)
  int32_t parent = -1;         // -1: the root
  int32_t size = 0;            // its columns, in scalars
  int32_t height = 0;          // those and the rows below
  int32_t descendants = 0;     // the fronts of its subtree are those just before it, in number and in turn
  int32_t turn = 0;            // its place in FrontTree::order()
  int64_t value = 0;           // of its panel's first scalar
  int64_t rows = 0, runs = 0;  // ends of its own in FrontTree; they begin where those of the front before end
  double work = 0;             // of its subtree, multiplications
  int below() const { return height - size; }
};

// A block row below a front's own square, and where it stands in scalars from the top of the panel.
struct FrontRow {
  int32_t block, place;
};

// Rows of a front (counted from the first below its square) that stand together in its parent's (from the top), all above
// the end of its square or all below.
struct Run {
  int32_t from, to, length;
};

class FrontTree {
 public:
  // width: of each block, in an order that is a postorder of the elimination tree. below[start[b], start[b + 1]): the blocks
  // after b that b meets, ascending; the last block is met by all. kept: the last blocks, each meeting all after it, that are
  // a front of their own, the root; 0: the root is as it comes.
  FrontTree(const std::vector<int>& width, const std::vector<int64_t>& start, const std::vector<int32_t>& below, int kept = 0);

  const std::vector<Front>& fronts() const { return fronts_; }
  std::span<const FrontRow> rows(int front) const { return part(rows_, front, &Front::rows); }
  std::span<const Run> runs(int front) const { return part(runs_, front, &Front::runs); }
  std::span<const int32_t> children(int front) const {  // in order()
    return {child_.data() + child_start_[front], static_cast<size_t>(child_start_[front + 1] - child_start_[front])};
  }
  // All fronts, children before parents, so that least of what fronts leave to their parents waits at a time [Liu1992].
  std::span<const int32_t> order() const { return order_; }
  // Index of block (row, column), row at or below column: its front, and its first scalar from the top left of the panel.
  struct EntryPosition {
    int front, row, column;
  };
  EntryPosition position(int row, int column) const;
  int offset(int block) const { return offset_[block]; }  // in scalars, of the whole matrix
  int width(int block) const { return offset_[block + 1] - offset_[block]; }
  int64_t values() const { return fronts_.back().value + int64_t{fronts_.back().height} * fronts_.back().size; }

 private:
  using Rows = std::vector<std::vector<int32_t>>;
  template <class T>
  std::span<const T> part(const std::vector<T>& all, int front, int64_t Front::* end) const {
    const int64_t begin = front > 0 ? fronts_[front - 1].*end : 0;
    return {all.data() + begin, static_cast<size_t>(fronts_[front].*end - begin)};
  }
  static Rows fill(const std::vector<int64_t>& start, const std::vector<int32_t>& below);
  void gather(const Rows& rows, int kept);
  void lay_out(const Rows& rows);
  void find_runs();
  void count_work();
  void find_children();
  void find_order();

  std::vector<int> offset_;  // one more than blocks
  std::vector<int> front_of_;
  std::vector<Front> fronts_;
  std::vector<FrontRow> rows_;
  std::vector<Run> runs_;
  std::vector<int32_t> child_start_, child_, order_;
};

}  // namespace hullrecon
