// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_index.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "common/errors.h"

namespace hullrecon {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kOnSurface = 1e-9;  // m; nearer than this the direction to the closest point is rounding noise

// Squared distance of the point.
auto distance_bound(const Vec3& p) {
  return [p](const Boxes& b) {
    Four sum = Four::Zero();
    for (int k = 0; k < 3; ++k) sum += (b.low[k] - p[k]).max(p[k] - b.high[k]).max(0.0).square();
    return sum;
  };
}

// Range at which the ray enters, infinite where it does not. Along an axis the ray is beyond another's planes at
// once or never; on them it is not, for the boxes have a margin.
auto range_bound(const Vec3& origin, const Vec3& direction) {
  Vec3 inverse;
  for (int k = 0; k < 3; ++k) inverse[k] = std::abs(direction[k]) > 1e-300 ? 1 / direction[k] : 1e300;
  return [origin, inverse](const Boxes& b) {
    Four near = Four::Zero(), far = Four::Constant(kInfinite);
    for (int k = 0; k < 3; ++k) {
      const Four t0 = (b.low[k] - origin[k]) * inverse[k], t1 = (b.high[k] - origin[k]) * inverse[k];
      near = near.max(t0.min(t1)), far = far.min(t0.max(t1));
    }
    return Four((near <= far * (1 + 1e-12) + 1e-12).select(near, kInfinite));
  };
}

}  // namespace

MeshIndex::MeshIndex(std::vector<Vec3> vertices, std::vector<std::array<int32_t, 3>> faces)
    : vertices_(std::move(vertices)), faces_(std::move(faces)) {
  if (faces_.empty()) throw InputError("the mesh has no faces", "faces", "give at least one triangle");
  for (const Vec3& v : vertices_) {
    if (!v.allFinite()) throw InputError("a vertex is not finite", "vertices", "remove or repair it");
  }
  const auto count = static_cast<int32_t>(vertices_.size());
  for (const auto& face : faces_) {
    for (int32_t v : face) {
      if (v < 0 || v >= count) throw InputError("vertex index " + std::to_string(v) + " is out of range", "faces", "");
    }
  }
  weld();
  find_normals();
  std::vector<Triangle> triangles;
  for (size_t f = 0; f < faces_.size(); ++f) triangles.push_back(triangle(static_cast<int32_t>(f)));
  tree_ = std::make_unique<BoxTree>(triangles);
  find_frames();
}

void MeshIndex::weld() {
  std::map<std::array<double, 3>, int32_t> seen;
  std::vector<int32_t> to(vertices_.size());
  for (size_t v = 0; v < vertices_.size(); ++v) {
    const Vec3 at = vertices_[v] + Vec3::Zero();  // -0 becomes 0
    to[v] = seen.try_emplace({at[0], at[1], at[2]}, static_cast<int32_t>(v)).first->second;
  }
  for (auto& face : faces_) {
    for (int32_t& v : face) v = to[v];
  }
}

void MeshIndex::find_normals() {
  std::map<std::pair<int32_t, int32_t>, Vec3> edges;
  const auto key = [](int32_t a, int32_t b) { return std::pair(std::min(a, b), std::max(a, b)); };
  face_normal_.resize(faces_.size());
  vertex_normal_.assign(vertices_.size(), Vec3::Zero());
  for (size_t f = 0; f < faces_.size(); ++f) {
    const Triangle t = triangle(static_cast<int32_t>(f));
    face_normal_[f] = (t.b - t.a).cross(t.c - t.a).stableNormalized();
    if (face_normal_[f].squaredNorm() < 0.5) face_normal_[f].setZero();
    const std::array<Vec3, 3> corner{t.a, t.b, t.c};
    for (int k = 0; k < 3; ++k) {
      const Vec3 one = corner[(k + 1) % 3] - corner[k], two = corner[(k + 2) % 3] - corner[k];
      const double angle = std::atan2(one.cross(two).norm(), one.dot(two));
      vertex_normal_[faces_[f][k]] += angle * face_normal_[f];
      edges.try_emplace(key(faces_[f][k], faces_[f][(k + 1) % 3]), Vec3::Zero()).first->second += face_normal_[f];
    }
  }
  edge_normal_.resize(faces_.size());
  for (size_t f = 0; f < faces_.size(); ++f) {
    for (int k = 0; k < 3; ++k) edge_normal_[f][k] = edges.at(key(faces_[f][k], faces_[f][(k + 1) % 3]));
  }
}

Triangle MeshIndex::triangle(int32_t face) const {
  const auto& corner = faces_[face];
  return {vertices_[corner[0]], vertices_[corner[1]], vertices_[corner[2]]};
}

Vec3 MeshIndex::pseudonormal(int32_t face, Feature feature) const {
  const int k = static_cast<int>(feature);
  if (k == 0) return frames_[face].unit;
  const Vec3 sum = k < 4 ? edge_normal_[face][k - 1] : vertex_normal_[faces_[face][k - 4]];
  return sum.norm() > 1e-9 ? sum.stableNormalized() : face_normal_[face];  // a fold of two opposite faces sums to nothing
}

struct MeshIndex::Best {
  double squared = kInfinite;
  int32_t face = -1;
  OnTriangle on{};
};

void MeshIndex::visit(int32_t face, const Triangle& triangle, const Vec3& point, Best& best) {
  const OnTriangle on = closest_on_triangle(point, triangle);
  const double squared = (point - on.point).squaredNorm();
  if (squared < best.squared || (squared == best.squared && face < best.face)) best = {squared, face, on};
}

Closest MeshIndex::closest(const Vec3& point, int32_t hint) const {
  Best best;
  if (hint >= 0) {
    const WalkEnd stop = walk(point, hint);
    const double limit = certified(stop);
    if (limit > 0) {
      const Vec3 foot = foot_inside(point, triangle(stop.face));
      best = {(point - foot).squaredNorm(), stop.face, {foot, Feature::Face}};
      if (best.squared < limit * limit) return answer(point, best);
    } else {
      visit(stop.face, triangle(stop.face), point, best);
    }
  }
  search(point, best);
  return answer(point, best);
}

// Whether the face is farther for certain: by its height and by its edges, with more to spare than both are rounded.
bool MeshIndex::farther(int32_t face, const Vec3& point, double squared) const {
  const FaceFrame& frame = frames_[face];
  const double height = frame.normal.dot(point) - frame.level;
  double beside = 0;
  for (int k = 0; k < 3; ++k) beside = std::max(beside, frame.out[k].dot(point) - frame.at[k]);
  return height * height + beside * beside > squared * (1 + 1e-9) + 1e-16 * size_ * size_;
}

void MeshIndex::search(const Vec3& point, Best& best) const {
  tree_->descend(
      distance_bound(point), [&] { return best.squared; },
      [&](int32_t face, const Triangle& triangle) {
        if (!farther(face, point, best.squared)) visit(face, triangle, point, best);
      });
}

Closest MeshIndex::answer(const Vec3& point, const Best& best) const {
  const Vec3 normal = pseudonormal(best.face, best.on.feature), away = point - best.on.point;
  const double length = std::sqrt(best.squared), side = away.dot(normal) < 0 ? -1.0 : 1.0;
  const bool flat = best.on.feature == Feature::Face || length < kOnSurface;
  return {side * length, best.on.point, flat ? normal : Vec3(side / length * away), best.face};
}

Hit MeshIndex::cast(const Vec3& origin, const Vec3& unit_direction) const {
  Hit best{kInfinite, -1, Vec3::Zero()};
  // no box begins at infinity: the limit of a ray that has hit nothing
  const auto limit = [&] { return std::min(best.range, std::numeric_limits<double>::max()); };
  tree_->descend(range_bound(origin, unit_direction), limit, [&](int32_t face, const Triangle& triangle) {
    const auto range = cross(origin, unit_direction, triangle);
    if (range && (*range < best.range || (*range == best.range && face < best.face))) best = {*range, face, face_normal_[face]};
  });
  return best;
}

}  // namespace hullrecon
