// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Finds the closest point of one triangle, with the feature it lies on, and the crossing of a ray.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <optional>

namespace hullrecon {

using Vec3 = Eigen::Vector3d;

struct Triangle {
  Vec3 a, b, c;
};

// Where on the triangle: its inside, the edge that starts at corner 0, 1, 2 (ab, bc, ca), or corner 0, 1, 2.
enum class Feature { Face, Edge0, Edge1, Edge2, Corner0, Corner1, Corner2 };

struct OnTriangle {
  Vec3 point;
  Feature feature;
};

// By the Voronoi regions of the features [Ericson2005 5.1.5]. A sliver of no area has no Face.
OnTriangle closest_on_triangle(const Vec3& p, const Triangle& t);

// The same point, to the last bit, for a point known to be over the inside.
Vec3 foot_inside(const Vec3& p, const Triangle& t);

// Range along the direction, in its lengths [MollerTrumbore1997]; either side counts. Empty: no crossing ahead, or a triangle
// of no area.
inline std::optional<double> cross(const Vec3& origin, const Vec3& direction, const Triangle& t) {
  const Vec3 ab = t.b - t.a, ac = t.c - t.a, h = direction.cross(ac);
  const double det = ab.dot(h);
  if (det * det <= 1e-24 * ab.squaredNorm() * h.squaredNorm() || !(std::abs(det) > 0)) return std::nullopt;
  constexpr double kSlack = 1e-10;  // a ray through a shared edge must not slip between its two faces
  const Vec3 s = origin - t.a;
  const double u = s.dot(h) / det;
  if (u < -kSlack || u > 1 + kSlack) return std::nullopt;
  const Vec3 q = s.cross(ab);
  const double v = direction.dot(q) / det;
  if (v < -kSlack || u + v > 1 + kSlack) return std::nullopt;
  const double range = ac.dot(q) / det;
  return range > 0 ? std::optional(range) : std::nullopt;
}

}  // namespace hullrecon
