// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_index.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>

#include "common/errors.h"

namespace hullrecon {
namespace {

// A search is compiled as a whole, and for processors with AVX2 too, where four boxes are one register. The bytes are the same:
// no product is fused with a sum.
#define HULLRECON_SEARCH __attribute__((flatten, target_clones("avx2", "default")))

constexpr double kOnSurface = 1e-9;  // m; nearer than this the direction to the closest point is rounding noise

// Squared distance of the point to each of four boxes.
auto distance_bound(const Vec3& p) {
  return [p](const Boxes& b, Four& out) { squared_gaps(b, p, p, out); };
}

// Range at which the ray enters, infinite where it does not. Along an axis the ray is beyond another's planes at
// once or never; on them it is not, for the boxes have a margin.
auto range_bound(const Vec3& origin, const Vec3& direction) {
  Vec3 inverse;
  for (int k = 0; k < 3; ++k) inverse[k] = std::abs(direction[k]) > 1e-300 ? 1 / direction[k] : 1e300;
  return [origin, inverse](const Boxes& b, Four& near) {
    const Four never = Four{} + kInfinite;
    Four far = never;
    near = Four{};
    for (int k = 0; k < 3; ++k) {
      Four low, high;
      load(low, b.low[k]), load(high, b.high[k]);
      Four enter = (low - origin[k]) * inverse[k], leave = enter;
      const Four other = (high - origin[k]) * inverse[k];
      keep_less(enter, other), keep_greater(leave, other);
      keep_greater(near, enter), keep_less(far, leave);
    }
    near = near <= far * (1 + 1e-12) + 1e-12 ? near : never;
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
  std::vector<Triangle> triangles;
  triangles.reserve(faces_.size());
  face_normal_.reserve(faces_.size());
  for (size_t f = 0; f < faces_.size(); ++f) {
    const Triangle t = triangles.emplace_back(triangle(static_cast<int32_t>(f)));
    face_normal_.push_back((t.b - t.a).cross(t.c - t.a).stableNormalized());
    if (face_normal_.back().squaredNorm() < 0.5) face_normal_.back().setZero();
  }
  for (const Vec3& v : vertices_) size_ = std::max(size_, v.cwiseAbs().maxCoeff());
  tree_ = std::make_unique<BoxTree>(std::move(triangles));
}

// Faces name, for a vertex, the first that has its coordinates: so neighbours share the numbers of their corners.
void MeshIndex::weld() {
  std::vector<int32_t> order(vertices_.size()), to(vertices_.size());
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](int32_t v) { return std::tie(vertices_[v][0], vertices_[v][1], vertices_[v][2]); };
  std::sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
    const auto one = place(a), two = place(b);
    return one < two || (one == two && a < b);
  });
  for (size_t i = 0; i < order.size(); ++i) {
    to[order[i]] = i > 0 && place(order[i - 1]) == place(order[i]) ? to[order[i - 1]] : order[i];
  }
  for (auto& face : faces_) {
    for (int32_t& v : face) v = to[v];
  }
}

void MeshIndex::prepare_closest() const {
  std::call_once(prepared_, [this] {
    const std::vector<Edge> sorted = edges();
    find_normals(sorted);
    find_frames(sorted);
  });
}

std::vector<MeshIndex::Edge> MeshIndex::edges() const {
  std::vector<Edge> found;
  found.reserve(3 * faces_.size());
  for (size_t f = 0; f < faces_.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({faces_[f][k], faces_[f][(k + 1) % 3]});
      found.push_back({low, high, static_cast<int32_t>(3 * f + k)});
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Edge& a, const Edge& b) { return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner); });
  return found;
}

void MeshIndex::find_normals(const std::vector<Edge>& edges) const {
  vertex_normal_.assign(vertices_.size(), Vec3::Zero());
  for (size_t f = 0; f < faces_.size(); ++f) {
    const Triangle t = triangle(static_cast<int32_t>(f));
    const std::array<Vec3, 3> corner{t.a, t.b, t.c};
    for (int k = 0; k < 3; ++k) {
      const Vec3 one = corner[(k + 1) % 3] - corner[k], two = corner[(k + 2) % 3] - corner[k];
      const double angle = std::atan2(one.cross(two).norm(), one.dot(two));
      vertex_normal_[faces_[f][k]] += angle * face_normal_[f];
    }
  }
  edge_normal_.resize(faces_.size());
  for (size_t first = 0, last = 0; first < edges.size(); first = last) {
    Vec3 sum = Vec3::Zero();
    for (last = first; last < edges.size() && edges[last].same(edges[first]); ++last)
      sum += face_normal_[edges[last].corner / 3];
    for (size_t i = first; i < last; ++i) edge_normal_[edges[i].corner / 3][edges[i].corner % 3] = sum;
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
  prepare_closest();
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

// Whether the face is farther than `squared` (a squared distance) for certain: by the point's height over its plane and by how
// far it is beyond an edge, with more to spare than both are rounded.
bool MeshIndex::farther(int32_t face, const Vec3& point, double squared) const {
  const FaceFrame& frame = frames_[face];
  const double height = frame.normal.dot(point) - frame.level;
  double beside = 0;
  for (int k = 0; k < 3; ++k) beside = std::max(beside, frame.out[k].dot(point) - frame.at[k]);
  return height * height + beside * beside > squared * (1 + 1e-9) + 1e-16 * size_ * size_;
}

HULLRECON_SEARCH void MeshIndex::search(const Vec3& point, Best& best) const {
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

HULLRECON_SEARCH Hit MeshIndex::cast(const Vec3& origin, const Vec3& unit_direction) const {
  Hit best{kInfinite, -1, Vec3::Zero()};
  // no box begins at infinity: the limit of a ray that has hit nothing
  const auto limit = [&] { return std::min(best.range, std::numeric_limits<double>::max()); };
  tree_->descend(range_bound(origin, unit_direction), limit, [&](int32_t face, const Triangle& triangle) {
    const auto range = cross(origin, unit_direction, triangle);
    if (range && (*range < best.range || (*range == best.range && face < best.face))) best = {*range, face, face_normal_[face]};
  });
  return best;
}

HULLRECON_SEARCH bool MeshIndex::is_free(const Vec3& start, const Vec3& end) const {
  const Vec3 line = end - start;
  const double length = line.norm();
  if (!(length > 0)) return true;
  const Vec3 direction = line / length;
  double limit = length;
  tree_->descend(
      range_bound(start, direction), [&] { return limit; },
      [&](int32_t, const Triangle& triangle) {
        if (limit < 0) return;
        const auto range = cross(start, direction, triangle);
        if (range && *range < length) limit = -1;  // no box is nearer: the search ends
      });
  return limit > 0;
}

}  // namespace hullrecon
