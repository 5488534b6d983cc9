// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/feature_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace hullrecon {

namespace {

// The points sorted along one axis: which they are, and their coordinates along it and across.
struct Sorted {
  std::vector<int64_t> row;
  std::vector<double> along, across;
};

struct Band {
  int64_t begin, end;
};

Sorted sorted(std::span<const double> points, int axis) {
  Sorted out;
  for (int64_t k = 0; k < std::ssize(points) / 2; ++k) {
    if (std::isfinite(points[2 * k]) && std::isfinite(points[2 * k + 1])) out.row.push_back(k);
  }
  std::sort(out.row.begin(), out.row.end(), [&](int64_t a, int64_t b) { return points[2 * a + axis] < points[2 * b + axis]; });
  for (const int64_t k : out.row) {
    out.along.push_back(points[2 * k + axis]);
    out.across.push_back(points[2 * k + 1 - axis]);
  }
  return out;
}

Band band(const Sorted& points, double from, double to) {
  const auto begin = std::lower_bound(points.along.begin(), points.along.end(), from);
  const auto end = std::upper_bound(begin, points.along.end(), to);
  return {begin - points.along.begin(), end - points.along.begin()};
}

bool is_finite(const SearchRegion& r) {
  return std::isfinite(r.x) && std::isfinite(r.y) && std::isfinite(r.half_x) && std::isfinite(r.half_y);
}

}  // namespace

FeaturePairs pairs_in_regions(std::span<const SearchRegion> regions, std::span<const double> points) {
  const std::array<Sorted, 2> by_axis{sorted(points, 0), sorted(points, 1)};
  std::array<std::vector<Band>, 2> bands;
  std::array<int64_t, 2> inside{0, 0};
  for (const SearchRegion& r : regions) {
    const std::array<double, 2> at{r.x, r.y}, half{r.half_x, r.half_y};
    for (int axis = 0; axis < 2; ++axis) {
      const Band in = is_finite(r) ? band(by_axis[axis], at[axis] - half[axis], at[axis] + half[axis]) : Band{0, 0};
      bands[axis].push_back(in);
      inside[axis] += in.end - in.begin;
    }
  }
  const int axis = inside[1] < inside[0] ? 1 : 0;  // whose bands hold fewer
  const Sorted& sought = by_axis[axis];
  FeaturePairs out;
  for (int64_t k = 0; k < std::ssize(regions); ++k) {
    const SearchRegion& r = regions[k];
    const double centre = axis == 0 ? r.y : r.x, half = axis == 0 ? r.half_y : r.half_x;
    const auto start = std::ssize(out.second);
    for (int64_t i = bands[axis][k].begin; i < bands[axis][k].end; ++i) {
      if (!(sought.across[i] >= centre - half && sought.across[i] <= centre + half)) continue;
      const double dx = (axis == 0 ? sought.along[i] : sought.across[i]) - r.x;
      const double dy = (axis == 0 ? sought.across[i] : sought.along[i]) - r.y;
      if ((r.xx * dx + 2 * r.xy * dy) * dx + r.yy * dy * dy <= 1) out.second.push_back(sought.row[i]);
    }
    std::sort(out.second.begin() + start, out.second.end());
    out.first.resize(out.second.size(), k);
  }
  return out;
}

void descriptor_distances(const float* a, const float* b, int64_t width, std::span<const int64_t> first,
                          std::span<const int64_t> second, std::span<float> distance) {
  constexpr int64_t kLanes = 16;  // sums side by side, which the compiler keeps in vector registers
  for (size_t k = 0; k < first.size(); ++k) {
    const float *x = a + first[k] * width, *y = b + second[k] * width;
    std::array<float, kLanes> sum{};
    int64_t i = 0;
    for (; i + kLanes <= width; i += kLanes) {
      for (int64_t lane = 0; lane < kLanes; ++lane) {
        const float gap = x[i + lane] - y[i + lane];
        sum[lane] += gap * gap;
      }
    }
    for (; i < width; ++i) sum[0] += (x[i] - y[i]) * (x[i] - y[i]);
    distance[k] = std::sqrt(std::accumulate(sum.begin(), sum.end(), 0.0F));
  }
}

void best_and_next(std::span<const int64_t> key, std::span<const float> distance, std::span<int64_t> best,
                   std::span<float> next) {
  std::fill(best.begin(), best.end(), -1);
  std::fill(next.begin(), next.end(), std::numeric_limits<float>::infinity());
  for (int64_t k = 0; k < std::ssize(key); ++k) {
    int64_t& least = best[key[k]];
    float& second = next[key[k]];
    if (least < 0) {
      least = k;
    } else if (distance[k] < distance[least]) {
      second = distance[least];
      least = k;
    } else {
      second = std::min(second, distance[k]);
    }
  }
}

}  // namespace hullrecon
