// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The incidence from which structures of a surface may hide parts of it (docs/methods.md 13).
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace hullrecon {

// The outermost point of each cell of the chart, with the chart's normal there (n x 3).
class OcclusionHorizon {
 public:
  struct Limits {
    double cell;          // m, side of a cell
    double span;          // m, largest distance from a block to what may hide it
    double least_relief;  // m; what is lower hides nothing
  };
  OcclusionHorizon(std::span<const double> points, std::span<const double> normals, const Limits& limits);

  // Bounds the tangent of the incidence up to which nothing hides a block of the surface, points with the chart's normals
  // (n x 3, NaN where there is no surface): the least distance of a cell over its height above the block, both on the safe
  // side. Infinite where no cell stands out.
  double least_tangent(std::span<const double> points, std::span<const double> normals) const;

 private:
  static constexpr size_t kTogether = 32;  // cells that are ruled out in one go

  std::span<const double> points_, normals_;
  Limits limits_;
  Eigen::Vector3d origin_;
  std::array<std::vector<float>, 3> place_;  // of the points off the origin, by axis
};

}  // namespace hullrecon
