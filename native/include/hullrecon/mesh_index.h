// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Closest point and ray cast against a triangle mesh: a bounding volume tree in float64.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hullrecon/triangle.h"

namespace hullrecon {

struct Closest {
  double distance;  // positive outside (side of the angle-weighted pseudonormal)
  Vec3 point;
  Vec3 gradient;  // unit: of the signed distance
  int32_t face;
};

struct Hit {
  double range;  // metres, infinite on a miss
  int32_t face;  // -1 on a miss
  Vec3 normal;   // unit, outward by the face's order of corners; zero on a miss
};

class MeshIndex {
 public:
  // Corners at equal coordinates are one (an STL repeats them): pseudonormals need the neighbours. Throws InputError.
  MeshIndex(std::vector<Vec3> vertices, std::vector<std::array<int32_t, 3>> faces);

  // hint: a face likely to be close (-1: none). It saves time and does not change the answer.
  Closest closest(const Vec3& point, int32_t hint = -1) const;
  Hit cast(const Vec3& origin, const Vec3& unit_direction) const;

  int64_t faces() const { return static_cast<int64_t>(faces_.size()); }

 private:
  struct Node {
    Vec3 low, high;
    int32_t first, count;  // count > 0: a leaf over order_[first, first + count); else first is the right child, left is next
  };
  struct Best;

  void weld();
  void find_normals();
  int32_t build(int32_t first, int32_t last);
  Triangle triangle(int32_t face) const;
  Vec3 pseudonormal(int32_t face, Feature feature) const;
  static void visit(int32_t face, const Triangle& triangle, const Vec3& point, Best& best);

  std::vector<Vec3> vertices_;
  std::vector<std::array<int32_t, 3>> faces_;
  std::vector<Vec3> face_normal_;                 // unit; zero for a sliver
  std::vector<std::array<Vec3, 3>> edge_normal_;  // sum over the faces that share the edge (not unit)
  std::vector<Vec3> vertex_normal_;               // sum weighted by the corner's angle (not unit)
  std::vector<int32_t> order_;
  std::vector<Triangle> leaf_;  // in this order: what a leaf visits lies together
  std::vector<Node> nodes_;
};

}  // namespace hullrecon
