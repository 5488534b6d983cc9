// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Which features of two images lie near each other, how far their descriptors are apart, and which are each other's best.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace hullrecon {

struct FeaturePairs {
  std::vector<int64_t> first, second;  // rows of what is wanted and of the points, in order of both
};

// Where a point is sought: a box of half widths about (x, y), and in it xx dx^2 + 2 xy dx dy + yy dy^2 <= 1.
struct SearchRegion {
  double x, y, half_x, half_y;
  double xx = 0, xy = 0, yy = 0;
};

// Pairs of each region with the points (x, y one after the other) in it; with what is not finite there is none.
FeaturePairs pairs_in_regions(std::span<const SearchRegion> regions, std::span<const double> points);

// Euclidean distances of rows of a and b, `width` numbers each, pair by pair. Rows must exist.
void descriptor_distances(const float* a, const float* b, int64_t width, std::span<const int64_t> first,
                          std::span<const int64_t> second, std::span<float> distance);

// For each key the row of its least distance, the first of equals (-1: none), and its second least distance (inf: none).
// Keys are in [0, best.size()).
void best_and_next(std::span<const int64_t> key, std::span<const float> distance, std::span<int64_t> best,
                   std::span<float> next);

}  // namespace hullrecon
