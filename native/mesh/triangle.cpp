// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/triangle.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace hullrecon {
namespace {

// A sliver has no area to be inside of: the nearest of its three edges, in order.
OnTriangle closest_on_edges(const Vec3& p, const Triangle& t) {
  const std::array<Vec3, 3> corner{t.a, t.b, t.c};
  OnTriangle best{t.a, Feature::Corner0};
  for (int k = 0; k < 3; ++k) {
    const Vec3 edge = corner[(k + 1) % 3] - corner[k];
    const double length2 = edge.squaredNorm();
    const double share = length2 > 0 ? (p - corner[k]).dot(edge) / length2 : 0.0;
    if (share >= 1) continue;  // the next corner's turn
    const Vec3 q = share <= 0 ? corner[k] : Vec3(corner[k] + share * edge);
    if ((p - q).squaredNorm() >= (p - best.point).squaredNorm() && k > 0) continue;
    best = {q, static_cast<Feature>((share <= 0 ? 4 : 1) + k)};
  }
  return best;
}

}  // namespace

OnTriangle closest_on_triangle(const Vec3& p, const Triangle& t) {
  const Vec3 ab = t.b - t.a, ac = t.c - t.a;
  if (ab.cross(ac).squaredNorm() <= 1e-28 * ab.squaredNorm() * ac.squaredNorm()) return closest_on_edges(p, t);
  const Vec3 ap = p - t.a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {t.a, Feature::Corner0};
  const Vec3 bp = p - t.b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {t.b, Feature::Corner1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {t.a + d1 / (d1 - d3) * ab, Feature::Edge0};
  const Vec3 cp = p - t.c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {t.c, Feature::Corner2};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {t.a + d2 / (d2 - d6) * ac, Feature::Edge2};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return {t.b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t.c - t.b), Feature::Edge1};
  const double sum = va + vb + vc;
  return {t.a + vb / sum * ab + vc / sum * ac, Feature::Face};
}

Vec3 foot_inside(const Vec3& p, const Triangle& t) {
  const Vec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a, bp = p - t.b, cp = p - t.c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4, sum = va + vb + vc;
  return t.a + vb / sum * ab + vc / sum * ac;
}

}  // namespace hullrecon
