// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/box_tree.h"

#include <limits>
#include <numeric>

namespace hullrecon {

BoxTree::BoxTree(std::vector<Triangle> faces) : order_(faces.size()), triangle_(std::move(faces)) {
  for (const Triangle& t : triangle_) {
    for (const Vec3& corner : {t.a, t.b, t.c}) margin_ = std::max(margin_, kMargin * corner.cwiseAbs().maxCoeff());
  }
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(order_.size() / 2 + 1);
  build({0, static_cast<int32_t>(order_.size())});
  arrange();
}

// Cycle by cycle: a second copy would be the largest array of all.
void BoxTree::arrange() {
  std::vector<bool> placed(order_.size());
  for (size_t first = 0; first < order_.size(); ++first) {
    if (placed[first]) continue;
    const Triangle kept = triangle_[first];
    size_t at = first;
    for (size_t from = order_[at]; from != first; at = from, from = order_[at])
      triangle_[at] = triangle_[from], placed[at] = true;
    triangle_[at] = kept, placed[at] = true;
  }
}

// Median split of the centroids along their longest side, ties by face: the tree is the same on every run.
int32_t BoxTree::split(Range range) {
  const int32_t middle = range.first + (range.last - range.first + 1) / 2;
  if (range.last - range.first < 2) return middle;
  const auto centre = [&](int32_t face) { return Vec3(triangle_[face].a + triangle_[face].b + triangle_[face].c); };
  Vec3 low = centre(order_[range.first]), high = low;
  for (int32_t i = range.first; i < range.last; ++i) {
    const Vec3 at = centre(order_[i]);
    low = low.cwiseMin(at), high = high.cwiseMax(at);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  std::nth_element(order_.begin() + range.first, order_.begin() + middle, order_.begin() + range.last,
                   [&](int32_t a, int32_t b) { return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b); });
  return middle;
}

int32_t BoxTree::build(Range range) {
  const auto at = static_cast<int32_t>(nodes_.size());
  nodes_.emplace_back();
  const int32_t half = split(range);
  const std::array<int32_t, 5> cut{range.first, split({range.first, half}), half, split({half, range.last}), range.last};
  for (int k = 0; k < 4; ++k) {
    Vec3 low = Vec3::Constant(kInfinite), high = -low;
    for (int32_t i = cut[k]; i < cut[k + 1]; ++i) {
      const Triangle& t = triangle_[order_[i]];
      low = low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c), high = high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
    }
    for (int axis = 0; axis < 3; ++axis) {
      nodes_[at].boxes.low[axis][k] = low[axis] - margin_, nodes_[at].boxes.high[axis][k] = high[axis] + margin_;
    }
    const int32_t count = cut[k + 1] - cut[k];
    const int32_t child = count == 0 ? -1 : count <= kLeaf ? cut[k] : build({cut[k], cut[k + 1]});
    nodes_[at].first[k] = child, nodes_[at].count[k] = count <= kLeaf ? count : 0;
  }
  return at;
}

}  // namespace hullrecon
