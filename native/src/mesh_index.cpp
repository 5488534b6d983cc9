// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "hullrecon/mesh_index.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "hullrecon/errors.h"

namespace hullrecon {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kOnSurface = 1e-9;  // m; nearer than this the direction to the closest point is rounding noise

double squared_distance_to_box(const Vec3& p, const Vec3& low, const Vec3& high) {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

// Range at which the ray enters the box, infinite when it does not. A zero component gives infinities; NaN (the origin on a
// slab's plane) counts as inside it.
double entry(const Vec3& origin, const Vec3& inverse, const Vec3& low, const Vec3& high) {
  double near = 0, far = kInfinite;
  for (int k = 0; k < 3; ++k) {
    const double t0 = (low[k] - origin[k]) * inverse[k], t1 = (high[k] - origin[k]) * inverse[k];
    near = std::max(near, std::isnan(t0) || std::isnan(t1) ? near : std::min(t0, t1));
    far = std::min(far, std::isnan(t0) || std::isnan(t1) ? far : std::max(t0, t1));
  }
  return near <= far * (1 + 1e-12) + 1e-12 ? near : kInfinite;
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
  order_.resize(faces_.size());
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(faces_.size());
  build(0, static_cast<int32_t>(order_.size()));
  leaf_.reserve(order_.size());
  for (int32_t face : order_) leaf_.push_back(triangle(face));
  find_sheets();
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

// Median split of the centroids along their longest side, ties by face: the tree is the same on every run.
int32_t MeshIndex::build(int32_t first, int32_t last) {
  const auto at = static_cast<int32_t>(nodes_.size());
  Node node{Vec3::Constant(kInfinite), Vec3::Constant(-kInfinite), first, last - first};
  Vec3 low = node.low, high = node.high;
  const auto centre = [&](int32_t face) {
    return Vec3(vertices_[faces_[face][0]] + vertices_[faces_[face][1]] + vertices_[faces_[face][2]]);
  };
  for (int32_t i = first; i < last; ++i) {
    for (int32_t v : faces_[order_[i]]) {
      node.low = node.low.cwiseMin(vertices_[v]);
      node.high = node.high.cwiseMax(vertices_[v]);
    }
    low = low.cwiseMin(centre(order_[i]));
    high = high.cwiseMax(centre(order_[i]));
  }
  nodes_.push_back(node);
  if (node.count <= 4) return at;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const int32_t middle = first + node.count / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](int32_t a, int32_t b) { return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b); });
  build(first, middle);
  const int32_t right = build(middle, last);
  nodes_[at].first = right;
  nodes_[at].count = 0;
  return at;
}

Triangle MeshIndex::triangle(int32_t face) const {
  const auto& corner = faces_[face];
  return {vertices_[corner[0]], vertices_[corner[1]], vertices_[corner[2]]};
}

Vec3 MeshIndex::pseudonormal(int32_t face, Feature feature) const {
  const int k = static_cast<int>(feature);
  if (k == 0) return sheets_[face].unit;
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
    const Stop stop = walk(point, hint);
    const double limit = trusted(stop);
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
  const Sheet& sheet = sheets_[face];
  const double height = sheet.normal.dot(point) - sheet.level;
  double beside = 0;
  for (int k = 0; k < 3; ++k) beside = std::max(beside, sheet.out[k].dot(point) - sheet.at[k]);
  return height * height + beside * beside > squared * (1 + 1e-9) + 1e-16 * size_ * size_;
}

void MeshIndex::search(const Vec3& point, Best& best) const {
  std::array<std::pair<double, int32_t>, 64> stack;  // deeper than any median tree over int32 faces
  int top = 0;
  stack[top++] = {0.0, 0};
  while (top > 0) {
    const auto [bound, at] = stack[--top];
    if (bound > best.squared) continue;
    const Node& node = nodes_[at];
    for (int32_t i = 0; i < node.count; ++i) {
      const int32_t face = order_[node.first + i];
      if (!farther(face, point, best.squared)) visit(face, leaf_[node.first + i], point, best);
    }
    if (node.count > 0) continue;
    std::pair near{squared_distance_to_box(point, nodes_[at + 1].low, nodes_[at + 1].high), at + 1};
    std::pair far{squared_distance_to_box(point, nodes_[node.first].low, nodes_[node.first].high), node.first};
    if (far.first < near.first) std::swap(near, far);
    stack[top++] = far;
    stack[top++] = near;
  }
}

Closest MeshIndex::answer(const Vec3& point, const Best& best) const {
  const Vec3 normal = pseudonormal(best.face, best.on.feature), away = point - best.on.point;
  const double length = std::sqrt(best.squared), side = away.dot(normal) < 0 ? -1.0 : 1.0;
  const bool flat = best.on.feature == Feature::Face || length < kOnSurface;
  return {side * length, best.on.point, flat ? normal : Vec3(side / length * away), best.face};
}

Hit MeshIndex::cast(const Vec3& origin, const Vec3& unit_direction) const {
  Hit best{kInfinite, -1, Vec3::Zero()};
  const Vec3 inverse = unit_direction.cwiseInverse();
  std::array<std::pair<double, int32_t>, 64> stack;
  int top = 0;
  stack[top++] = {entry(origin, inverse, nodes_[0].low, nodes_[0].high), 0};
  while (top > 0) {
    const auto [bound, at] = stack[--top];
    if (bound == kInfinite || bound > best.range) continue;
    const Node& node = nodes_[at];
    for (int32_t i = 0; i < node.count; ++i) {
      const int32_t face = order_[node.first + i];
      const auto range = cross(origin, unit_direction, leaf_[node.first + i]);
      if (range && (*range < best.range || (*range == best.range && face < best.face)))
        best = {*range, face, face_normal_[face]};
    }
    if (node.count > 0) continue;
    std::pair near{entry(origin, inverse, nodes_[at + 1].low, nodes_[at + 1].high), at + 1};
    std::pair far{entry(origin, inverse, nodes_[node.first].low, nodes_[node.first].high), node.first};
    if (far.first < near.first) std::swap(near, far);
    stack[top++] = far;
    stack[top++] = near;
  }
  return best;
}

}  // namespace hullrecon
