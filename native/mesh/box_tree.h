// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Tree of bounding boxes over triangles, four children to a node, whose bounds are computed side by side [Wald2014].
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "mesh/triangle.h"

namespace hullrecon {

constexpr double kInfinite = std::numeric_limits<double>::infinity();  // a distance or range where nothing is met

using Four = double __attribute__((vector_size(32)));

// By reference: without AVX no register holds four, and what returns them has another calling convention.
inline void load(Four& four, const std::array<double, 4>& from) {
  std::memcpy(&four, from.data(), sizeof four);
}
inline void keep_less(Four& a, const Four& b) {
  a = a < b ? a : b;
}
inline void keep_greater(Four& a, const Four& b) {
  a = a > b ? a : b;
}

// The boxes of four children, axis by axis. That of an empty child is inside out: nothing is near it.
struct Boxes {
  std::array<std::array<double, 4>, 3> low, high;
};

// Squared distances of the boxes from another one, which may be a point.
inline void squared_gaps(const Boxes& boxes, const Vec3& low, const Vec3& high, Four& sum) {
  sum = Four{};
  for (int k = 0; k < 3; ++k) {
    Four gap, beyond;
    load(gap, boxes.low[k]), load(beyond, boxes.high[k]);
    gap -= high[k];
    keep_greater(gap, low[k] - beyond);
    keep_greater(gap, Four{});
    sum += gap * gap;
  }
}

class BoxTree {
 public:
  explicit BoxTree(std::vector<Triangle> faces);

  // Calls visit(face, triangle) of every triangle in boxes whose bound is at most limit(), nearer boxes first.
  // bound(boxes, out): of each child no more than any triangle in it could be; limit(): may fall as triangles are visited.
  template <class Bound, class Limit, class Visit>
  void descend(const Bound& bound, const Limit& limit, const Visit& visit) const;

 private:
  static constexpr int kLeaf = 4;  // triangles at most
  static constexpr double kMargin =
      1e-10;  // of the largest coordinate, about each box: bounds are safe though they are rounded
  struct Node {
    Boxes boxes;
    std::array<int32_t, 4> first, count;  // count > 0: triangles of order_; 0: first is a node
  };
  struct Range {
    int32_t first, last;
  };
  int32_t build(Range range);  // with triangle_ by face still, as split
  int32_t split(Range range);
  void arrange();

  double margin_ = 0;
  std::vector<Node> nodes_;
  std::vector<int32_t> order_;
  std::vector<Triangle> triangle_;  // in this order: what a leaf visits lies together
};

template <class Bound, class Limit, class Visit>
void BoxTree::descend(const Bound& bound, const Limit& limit, const Visit& visit) const {
  struct Open {
    double bound;
    int32_t first, count;
  };
  std::array<Open, 64> stack;  // three more a level; int32 faces make no more than sixteen levels
  int top = 0;
  stack[top++] = {0.0, 0, 0};
  while (top > 0) {
    const Open open = stack[--top];
    if (open.bound > limit()) continue;
    for (int32_t i = open.first; i < open.first + open.count; ++i) visit(order_[i], triangle_[i]);
    if (open.count > 0) continue;
    const Node& node = nodes_[open.first];
    Four bounds;
    bound(node.boxes, bounds);
    const int base = top;
    for (int k = 0; k < 4; ++k) {
      if (!(bounds[k] <= limit()) || node.first[k] < 0) continue;
      int at = top++;
      for (; at > base && stack[at - 1].bound < bounds[k]; --at) stack[at] = stack[at - 1];
      stack[at] = {bounds[k], node.first[k], node.count[k]};
    }
  }
}

}  // namespace hullrecon
