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

double least_tangent(const Outermost& cells, std::span<const double> points, std::span<const double> normals) {
  const Bounds block = bounds_of(points, normals);
  const double across = std::sqrt(2.0) * cells.cell;  // of a cell
  const double slack = block.radius + cells.cell + across;
  double least = std::numeric_limits<double>::infinity();
  // the bound is never below nothing: a cell that reaches it ends the search
  for (size_t i = 0; i < cells.point.size() && least > 0; i += 3) {
    const Vec3 off = Eigen::Map<const Vec3>(&cells.point[i]) - block.middle;
    const double above = block.normal.dot(off);
    if (above + across - block.floor <= cells.least_relief) continue;  // of most, without a root
    const double cosine = block.normal.dot(Eigen::Map<const Vec3>(&cells.normal[i]));
    // other points of the cell may stand higher by its tilt
    const double rise = above + across * std::sqrt(std::max(1 - cosine * cosine, 0.0)) - block.floor;
    if (rise <= cells.least_relief) continue;
    const double away = std::sqrt(std::max(off.squaredNorm() - above * above, 0.0)) - slack;
    if (away < cells.span) least = std::min(least, std::max(away, 0.0) / rise);
  }
  return least;
}

}  // namespace hullrecon
