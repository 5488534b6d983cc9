// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Defines how residuals are called, and what they share.
//
// Call: residual(x, r, J). x[k]: parameter block k. r: kRows numbers. J, and each J[k], may be null; J[k] is row major, kRows
// by the block's size, by the block's tangent in its first columns (manifolds.h says why), zero in the last. False: the point
// cannot be evaluated and the solver refuses the step.
//
// Blocks: pose (8) = T_g_v and tray angle theta; motion (7); landmark (3) in g; navigation (6) = DVL scale error, heading
// drift, roll bias, pitch bias, depth bias, tray backlash; intrinsics (9); node (1) of the deviation field; world (3) = north
// and east of g's origin, heading of its x axis.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "factors/motion.h"

namespace hullrecon {

// Of dynamic size: each fixed size would be a type, and the code that fills it would be compiled once for each.
using Jacobian = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

// Calls fill(Jacobian&) on block k's Jacobian, zeroed, when the solver wants it.
template <class Fill>
void derive(double* const* J, int k, int rows, int size, const Fill& fill) {
  if (!J || !J[k]) return;
  std::fill_n(J[k], rows * size, 0.0);
  Jacobian j(J[k], rows, size);
  fill(j);
}

// Tangent plane of the mesh near a query, held until the next refresh: distance(p) = normal . p + offset, in M.
struct Facet {
  Vec3 normal = Vec3::Zero();
  double offset = 0;
  bool active = false;
};

// Interpolates the deviation field: sum of weight * node, m outward, each node once. The weights are held by their owner.
struct FieldAt {
  std::span<const double> weight;

  double value(const double* const* node) const {
    double sum = 0;
    for (size_t k = 0; k < weight.size(); ++k) sum += weight[k] * node[k][0];
    return sum;
  }
  std::vector<int> sizes_after(std::vector<int> sizes) const {
    sizes.insert(sizes.end(), weight.size(), 1);
    return sizes;
  }
  void derive_nodes(double* const* J, size_t first, double by_field) const {
    for (size_t k = 0; J && k < weight.size(); ++k) {
      if (J[first + k]) J[first + k][0] = by_field * weight[k];
    }
  }
};

}  // namespace hullrecon
