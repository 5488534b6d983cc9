// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// From which incidence on what stands out of a surface may hide parts of it (docs/methods.md 13).
#pragma once

#include <Eigen/Core>
#include <span>

namespace hullrecon {

// The outermost point of each cell of the chart, with the chart's normal there.
struct Outermost {
  std::span<const double> point, normal;  // (n x 3)
  double cell;                            // m, side of a cell
  double span;                            // m from a block to whatever stands in front of an instrument
  double least_relief;                    // m; what is lower hides nothing
};

// Bounds the tangent of the incidence up to which nothing hides a block of the surface, points with the chart's normals
// (n x 3, NaN where there is no surface): the least distance of a cell over its height above the block, both on the safe side.
// Infinite where no cell stands out.
double least_tangent(const Outermost& cells, std::span<const double> points, std::span<const double> normals);

}  // namespace hullrecon
