// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mosaic/horizon.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hullrecon {

namespace {

using Vec3 = Eigen::Vector3d;

// All of a block is within `radius` of the middle and no lower than `floor` over the tangent plane there, m.
struct Bounds {
  Vec3 middle, normal;
  double floor, radius;
};

Bounds bounds_of(std::span<const double> points, std::span<const double> normals) {
  Bounds block{Vec3::Zero(), Vec3::Zero(), std::numeric_limits<double>::infinity(), 0};
  int64_t count = 0;
  for (size_t i = 0; i < points.size(); i += 3) {
    if (std::isnan(points[i])) continue;
    block.middle += Eigen::Map<const Vec3>(&points[i]), block.normal += Eigen::Map<const Vec3>(&normals[i]);
    ++count;
  }
  block.middle /= static_cast<double>(count);
  block.normal.normalize();
  double squared = 0;
  for (size_t i = 0; i < points.size(); i += 3) {
    if (std::isnan(points[i])) continue;
    const Vec3 off = Eigen::Map<const Vec3>(&points[i]) - block.middle;
    block.floor = std::min(block.floor, block.normal.dot(off));
    squared = std::max(squared, off.squaredNorm());
  }
  block.radius = std::sqrt(squared);
  return block;
}

}  // namespace

OcclusionHorizon::OcclusionHorizon(std::span<const double> points, std::span<const double> normals, const Limits& limits)
    : points_(points), normals_(normals), limits_(limits), origin_(Vec3::Zero()) {
  const size_t count = points.size() / 3, padded = (count + kTogether - 1) / kTogether * kTogether;
  if (count > 0) origin_ = Eigen::Map<const Vec3>(points.data());
  for (int axis = 0; axis < 3; ++axis) {
    place_[axis].assign(padded, 0.0f);
    for (size_t i = 0; i < count; ++i) place_[axis][i] = static_cast<float>(points[3 * i + axis] - origin_[axis]);
  }
}

double OcclusionHorizon::least_tangent(std::span<const double> points, std::span<const double> normals) const {
  constexpr double kRounding = 1e-4;  // m, of places in single precision within hundreds of metres
  const Bounds block = bounds_of(points, normals);
  const double across = std::sqrt(2.0) * limits_.cell;  // a cell's diagonal
  const double slack = block.radius + limits_.cell + across;
  const Eigen::Vector3f up = block.normal.cast<float>();
  const auto low =
      static_cast<float>(block.normal.dot(block.middle - origin_) + block.floor + limits_.least_relief - across - kRounding);
  const size_t count = points_.size() / 3;
  double least = std::numeric_limits<double>::infinity();
  // the bound is never below nothing: a cell that reaches it ends the search
  for (size_t first = 0; first < count && least > 0; first += kTogether) {
    int high = 0;
    for (size_t i = first; i < first + kTogether; ++i) {
      high |= static_cast<int>(up[0] * place_[0][i] + up[1] * place_[1][i] + up[2] * place_[2][i] > low);
    }
    if (high == 0) continue;  // most: none of them stands out
    for (size_t i = first; i < std::min(first + kTogether, count); ++i) {
      const Vec3 off = Eigen::Map<const Vec3>(&points_[3 * i]) - block.middle;
      const double above = block.normal.dot(off), cosine = block.normal.dot(Eigen::Map<const Vec3>(&normals_[3 * i]));
      // other points of the cell may stand higher by its tilt
      const double rise = above + across * std::sqrt(std::max(1 - cosine * cosine, 0.0)) - block.floor;
      if (rise <= limits_.least_relief) continue;
      const double away = std::sqrt(std::max(off.squaredNorm() - above * above, 0.0)) - slack;
      if (away < limits_.span) least = std::min(least, std::max(away, 0.0) / rise);
    }
  }
  return least;
}

}  // namespace hullrecon
