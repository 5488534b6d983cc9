// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/feature_pairs.h"

#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "expect.h"

using namespace hullrecon;

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<std::pair<int64_t, int64_t>> zipped(const FeaturePairs& pairs) {
  std::vector<std::pair<int64_t, int64_t>> out;
  for (size_t k = 0; k < pairs.first.size(); ++k) out.emplace_back(pairs.first[k], pairs.second[k]);
  return out;
}

}  // namespace

TEST_CASE("pairs in regions are those of the plain test, in order") {
  std::mt19937 rng(1);
  for (const double slender : {0.3, 3.0}) {  // points are sought along one axis, then along the other
    std::uniform_real_distribution<double> at(0, 10), half(0.2, 1.5), tilt(-0.9, 0.9);
    std::vector<SearchRegion> regions;
    std::vector<double> points;
    for (int k = 0; k < 60; ++k) {
      const double x = half(rng), y = slender * half(rng), t = tilt(rng), free = 1 - t * t;
      regions.push_back({at(rng), at(rng), x, y, 1 / (x * x * free), -t / (x * y * free), 1 / (y * y * free)});
    }
    for (int k = 0; k < 600; ++k) points.push_back(at(rng));
    regions[7].x = kNone;
    points[11] = kNone;
    std::vector<std::pair<int64_t, int64_t>> plain;
    for (int64_t i = 0; i < std::ssize(regions); ++i) {
      const SearchRegion& r = regions[i];
      for (int64_t k = 0; k < 300; ++k) {
        const double dx = points[2 * k] - r.x, dy = points[2 * k + 1] - r.y;
        const bool box = std::abs(dx) <= r.half_x && std::abs(dy) <= r.half_y;
        if (box && r.xx * dx * dx + 2 * r.xy * dx * dy + r.yy * dy * dy <= 1) plain.emplace_back(i, k);
      }
    }
    CHECK(plain.size() > 20);
    CHECK(zipped(pairs_in_regions(regions, points)) == plain);
  }
}

TEST_CASE("a region without a form is its box, edges included") {
  const std::vector<SearchRegion> regions{{0, 0, 1, 2}};
  const std::vector<double> points{1, 2, 1.1, 0, 0, -2, 0, 2.1};
  CHECK(pairs_in_regions(regions, points).second == std::vector<int64_t>{0, 2});
  CHECK(pairs_in_regions({}, points).first.empty());
  CHECK(pairs_in_regions(regions, {}).first.empty());
}

TEST_CASE("descriptors of any width have the Euclidean distance") {
  std::mt19937 rng(2);
  std::normal_distribution<float> number;
  for (const int64_t width : {1, 16, 23, 128}) {
    std::vector<float> a(5 * width), b(7 * width), distance(35);
    for (float& x : a) x = number(rng);
    for (float& x : b) x = number(rng);
    std::vector<int64_t> first, second;
    for (int64_t k = 0; k < 35; ++k) first.push_back(k % 5), second.push_back(k % 7);
    descriptor_distances(a.data(), b.data(), width, first, second, distance);
    for (int64_t k = 0; k < 35; ++k) {
      double sum = 0;
      for (int64_t i = 0; i < width; ++i) sum += std::pow(a[first[k] * width + i] - b[second[k] * width + i], 2.0);
      CHECK(distance[k] == doctest::Approx(std::sqrt(sum)).epsilon(1e-5));
    }
  }
}

TEST_CASE("of equal distances the first is the best, and the next may be as near") {
  const std::vector<int64_t> key{2, 0, 2, 2, 0};
  const std::vector<float> distance{0.5F, 0.7F, 0.3F, 0.3F, 0.9F};
  std::vector<int64_t> best(4);
  std::vector<float> next(4);
  best_and_next(key, distance, best, next);
  constexpr float kFar = std::numeric_limits<float>::infinity();
  CHECK(best == std::vector<int64_t>{1, -1, 2, -1});
  CHECK(next == std::vector<float>{0.9F, kFar, 0.3F, kFar});
}
