// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Finds closest points and casts rays against a triangle mesh, by a tree of boxes in float64.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "mesh/box_tree.h"

namespace hullrecon {

struct Closest {
  double distance;  // m, positive outside: the side of the angle-weighted pseudonormal [BaerentzenAanaes2005]
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

  // The closest point of the mesh; of faces at equal distances the first is taken. hint: a face likely to be close (-1: none).
  // It saves time and changes no answer.
  Closest closest(const Vec3& point, int32_t hint = -1) const;
  Hit cast(const Vec3& origin, const Vec3& unit_direction) const;
  // Whether no face crosses the straight line between two points, the end itself left out.
  bool is_free(const Vec3& start, const Vec3& end) const;

  int64_t faces() const { return static_cast<int64_t>(faces_.size()); }

 private:
  struct Best;
  struct Neighbourhood;
  // Lines of a face's edges in its plane, for walks over the mesh. Zero where a sliver leaves a direction to rounding.
  struct FaceFrame {
    std::array<Vec3, 3> out;        // unit, in the face's plane, square to edge k, away from the face
    std::array<double, 3> at;       // of edge k along it
    std::array<int32_t, 3> across;  // a face beyond edge k, -1: none
    Vec3 normal;
    double level;  // of the face along it
    Vec3 unit;     // the pseudonormal inside
  };
  // Lower bounds of the two limits on the height up to which a face is the closest (closest_face_certificate.cpp): a ratio to
  // the foot's clearance, and m. per_clearance < 0: not computed yet.
  struct Certificate {
    std::atomic<float> per_clearance{-1}, reach{0};
  };
  struct WalkEnd {
    int32_t face;
    double clearance;  // of the point's foot on the face to its nearest edge; 0: the foot may be outside
  };

  // An edge of a face, by its welded ends: the faces of an edge follow each other.
  struct Edge {
    int32_t low, high, corner;  // corner: 3 face + k
    bool same(const Edge& other) const { return low == other.low && high == other.high; }
  };

  void weld();
  void prepare_closest() const;  // at the first closest point asked for: rays do without
  std::vector<Edge> edges() const;
  void find_normals(const std::vector<Edge>& edges) const;
  void find_frames(const std::vector<Edge>& edges) const;
  WalkEnd walk(const Vec3& point, int32_t face) const;
  double certified(const WalkEnd& stop) const;  // height up to which the face is the closest; 0: none
  void compute_certificate(int32_t face) const;
  bool farther(int32_t face, const Vec3& point, double squared) const;
  void search(const Vec3& point, Best& best) const;
  Closest answer(const Vec3& point, const Best& best) const;
  Triangle triangle(int32_t face) const;
  Vec3 pseudonormal(int32_t face, Feature feature) const;
  static void visit(int32_t face, const Triangle& triangle, const Vec3& point, Best& best);

  std::vector<Vec3> vertices_;
  std::vector<std::array<int32_t, 3>> faces_;
  std::vector<Vec3> face_normal_;  // unit; zero for a sliver
  std::unique_ptr<BoxTree> tree_;
  double size_ = 0;  // m: the largest coordinate
  mutable std::once_flag prepared_;
  mutable std::vector<std::array<Vec3, 3>> edge_normal_;  // sum over the faces that share the edge (not unit)
  mutable std::vector<Vec3> vertex_normal_;               // sum weighted by the corner's angle (not unit)
  mutable std::vector<FaceFrame> frames_;
  mutable std::unique_ptr<Certificate[]> certificate_;  // computed when first asked for: the same number by any thread
};

}  // namespace hullrecon
