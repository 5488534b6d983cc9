// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Certifies the closest face of MeshIndex where it can be proved, so that the tree need not be searched.
//
// A point p stands at height h over q, inside face f. No other face is nearer if the ball that touches f at q on p's side, of a
// radius r > h, holds no point x of another face. With z the height of x over f's plane and x' its foot there,
//     x is outside the ball  <=>  z^2 + |x' - q|^2 >= 2 r z.                                                      (1)
// Let t be the clearance of q, its distance to f's nearest edge, and d that of x' to f: |x' - q| >= t + d for x' outside f.
//  - A face that touches f: let it rise no steeper than z <= k d. On that cone the smallest of (z^2 + (t + d)^2) / (2 z) is
//    t (1 + sqrt(1 + k^2)) / k, the bisector of two planes: (1) holds for r = t per_clearance.
//  - A face that does not: z^2 + d^2 = D^2 is the squared distance of x to f, and z <= D: (1) holds for r = D^2 / (2 z), which
//    is at least D / 2. The smallest of all is `reach`.
// z counts on either side of the plane. Hence f is the closest where h < min(t per_clearance, reach).
//
// In floating point, too: |p - x|^2 >= h^2 + |x - q|^2 (1 - h / r), so kSure of r, and t and reach of at least kLeast of the
// mesh's size, keep every other face's squared distance above f's by far more than both are rounded. Faces so thin that
// rounding may put their closest point outside of them stand near no certified face.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mesh/mesh_index.h"

namespace hullrecon {
namespace {

constexpr double kSure = 0.99;
constexpr double kLeast = 4e-6;
constexpr double kNoise = 1e-12;   // of the mesh's size: far more than heights are rounded, far less than kLeast
constexpr double kFarthest = 0.5;  // reach at most, by the face's longest edge; faces within twice that are looked at
constexpr int kMostFaces = 500;    // looked at; where more stand as near, none is certified
constexpr int kSteps = 16;         // of a walk

double longest_edge(const Triangle& t) {
  return std::sqrt(std::max({(t.b - t.a).squaredNorm(), (t.c - t.b).squaredNorm(), (t.a - t.c).squaredNorm()}));
}

// The closest point of the triangle to a point at most `far` from it is rounded to much less than its size.
bool sound(const Triangle& t, double far) {
  const Vec3 ab = t.b - t.a, ac = t.c - t.a;
  const double across = ab.cross(ac).squaredNorm(), edge = longest_edge(t);
  if (across <= 1e-28 * ab.squaredNorm() * ac.squaredNorm()) return true;  // taken for its three edges (triangle.cpp)
  return across >= 1e-8 * edge * edge * (edge + far) * (edge + far);
}

}  // namespace

void MeshIndex::find_frames(const std::vector<Edge>& edges) const {
  certificate_ = std::make_unique<Certificate[]>(faces_.size());
  frames_.resize(faces_.size());
  for (int32_t f = 0; f < static_cast<int32_t>(faces_.size()); ++f) {
    const Triangle t = triangle(f);
    const std::array<Vec3, 3> corner{t.a, t.b, t.c};
    FaceFrame& frame = frames_[f];
    frame.across.fill(-1);
    frame.unit = face_normal_[f].norm() > 1e-9 ? face_normal_[f].stableNormalized() : face_normal_[f];
    const bool flat = (t.b - t.a).cross(t.c - t.a).norm() > 1e-2 * (t.b - t.a).norm() * (t.c - t.a).norm();
    frame.normal = flat ? face_normal_[f] : Vec3::Zero();
    frame.level = frame.normal.dot(t.a);
    for (int k = 0; k < 3; ++k) {
      frame.out[k] = (corner[(k + 1) % 3] - corner[k]).cross(frame.normal).stableNormalized();
      frame.at[k] = frame.out[k].dot(corner[k]);
    }
  }
  for (size_t i = 1, first = 0; i < edges.size(); ++i) {
    if (!edges[i].same(edges[first])) {
      first = i;
      continue;
    }
    const auto across = [&](int32_t corner) -> int32_t& { return frames_[corner / 3].across[corner % 3]; };
    across(edges[i].corner) = edges[first].corner / 3;
    across(edges[first].corner) = edges[i].corner / 3;
  }
}

// From face to face, each time over the edge that the point's foot is farthest beyond.
MeshIndex::WalkEnd MeshIndex::walk(const Vec3& point, int32_t face) const {
  for (int step = 0, last = -1; step < kSteps; ++step) {
    const FaceFrame& frame = frames_[face];
    int most = 0;
    std::array<double, 3> beyond;
    for (int k = 0; k < 3; ++k) {
      beyond[k] = frame.out[k].dot(point) - frame.at[k];
      if (beyond[k] > beyond[most]) most = k;
    }
    if (beyond[most] < 0) return {face, -beyond[most]};
    const int32_t next = frame.across[most];
    if (next < 0 || next == last) break;
    last = face, face = next;
  }
  return {face, 0};
}

double MeshIndex::certified(const WalkEnd& stop) const {
  if (stop.clearance < kLeast * size_) return 0;
  const Certificate& certificate = certificate_[stop.face];
  if (certificate.per_clearance.load(std::memory_order_acquire) < 0) compute_certificate(stop.face);
  return std::min(stop.clearance * certificate.per_clearance.load(std::memory_order_relaxed),
                  static_cast<double>(certificate.reach.load(std::memory_order_relaxed)));
}

// The faces about one, and what they leave of its certificate.
struct MeshIndex::Neighbourhood {
  const MeshIndex& mesh;
  const int32_t face;
  const Triangle own = mesh.triangle(face);
  const Vec3 low = own.a.cwiseMin(own.b).cwiseMin(own.c), high = own.a.cwiseMax(own.b).cwiseMax(own.c);
  const double farthest = kFarthest * longest_edge(own), noise = kNoise * mesh.size_;
  double reach = farthest, slope = 0;  // slope: k
  bool certified = sound(own, farthest) && mesh.frames_[face].normal.squaredNorm() > 0.5;
  int looked = 0;

  double to_box(const Vec3& from, const Vec3& to) const { return (from - high).cwiseMax(low - to).cwiseMax(0.0).norm(); }
  void look(int32_t other, const Triangle& t);
  double slope_of(const std::array<Vec3, 3>& corner, const Vec3& height, const std::array<int, 3>& shared) const;
  double ball_of(int32_t other, const Triangle& t, const Vec3& height) const;
};

void MeshIndex::Neighbourhood::look(int32_t other, const Triangle& t) {
  if (other == face) return;
  certified &= ++looked <= kMostFaces;
  const std::array<Vec3, 3> corner{t.a, t.b, t.c};
  const auto &mine = mesh.faces_[face], &theirs = mesh.faces_[other];
  Vec3 height;
  std::array<int, 3> shared;  // number of the corner in ours, 3: none
  for (int k = 0; k < 3; ++k) {
    height[k] = mesh.frames_[face].normal.dot(corner[k] - own.a);
    shared[k] = static_cast<int>(std::find(mine.begin(), mine.end(), theirs[k]) - mine.begin());
  }
  const bool touches = shared != std::array{3, 3, 3};
  const double far = touches ? 0 : to_box(t.a.cwiseMin(t.b).cwiseMin(t.c), t.a.cwiseMax(t.b).cwiseMax(t.c));
  if (far / 2 >= reach) return;
  certified &= sound(t, 2 * farthest);
  if (touches) {
    slope = std::max(slope, slope_of(corner, height, shared));
  } else if (far * far < 2 * reach * (height.cwiseAbs().maxCoeff() + noise)) {
    reach = std::min(reach, ball_of(other, t, height));
  }
}

// k of a face that touches ours. Beyond the shared corner or edge ours stays on one side of each line tried; the other face, on
// its far side, is at least as far from ours as from that line. Infinite: it may stand over ours.
double MeshIndex::Neighbourhood::slope_of(const std::array<Vec3, 3>& corner, const Vec3& height,
                                          const std::array<int, 3>& shared) const {
  const auto& out = mesh.frames_[face].out;
  const int anchor = static_cast<int>(std::find_if(shared.begin(), shared.end(), [](int c) { return c < 3; }) - shared.begin());
  const auto steepest = [&](const Vec3& away) {
    double k = 0;
    for (int i = 0; i < 3; ++i) {
      if (shared[i] < 3) continue;
      const double beyond = away.dot(corner[i] - corner[anchor]);
      k = std::max(k, beyond < -noise ? kInfinite : (std::abs(height[i]) + noise) / std::max(beyond, noise));
    }
    return k;
  };
  const auto on_edge = [&](int e) {
    return std::all_of(shared.begin(), shared.end(), [&](int c) { return c == 3 || c == e || c == (e + 1) % 3; });
  };
  double least = kInfinite;
  Vec3 between = Vec3::Zero();
  int edges = 0;
  for (int e = 0; e < 3; ++e) {
    if (!on_edge(e)) continue;
    least = std::min(least, steepest(out[e]));
    between += out[e], ++edges;
  }
  return edges == 2 ? std::min(least, steepest(between.normalized())) : least;
}

// The least radius r that (1) allows a face that does not touch ours. Two triangles are at least as far apart as both are from
// a plane between them that goes through an edge of one or the other.
double MeshIndex::Neighbourhood::ball_of(int32_t other, const Triangle& t, const Vec3& height) const {
  const auto apart = [](const FaceFrame& frame, const Triangle& x) {
    double most = 0;
    for (int e = 0; e < 3; ++e) {
      const Vec3& out = frame.out[e];
      most = std::max(most, std::min({out.dot(x.a), out.dot(x.b), out.dot(x.c)}) - frame.at[e]);
    }
    return most;
  };
  const double beside = apart(mesh.frames_[face], t), from_theirs = apart(mesh.frames_[other], own);
  const double above = std::max({height.minCoeff(), -height.maxCoeff(), 0.0});
  const double squared = std::max(beside * beside + above * above, from_theirs * from_theirs);
  return std::max(squared / (2 * (height.cwiseAbs().maxCoeff() + noise)), std::sqrt(squared) / 2);
}

void MeshIndex::compute_certificate(int32_t face) const {
  Neighbourhood around{*this, face};
  const auto apart = [&](const Boxes& b, Four& half) {
    squared_gaps(b, around.low, around.high, half);
    for (int k = 0; k < 4; ++k) half[k] = std::sqrt(half[k]) / 2;
  };
  tree_->descend(
      apart, [&] { return around.certified ? around.reach : -1; },
      [&](int32_t other, const Triangle& triangle) { around.look(other, triangle); });
  const bool certified = around.certified && around.reach >= kLeast * size_ && std::isfinite(around.slope);
  const double k = std::max(around.slope, 1e-9);
  certificate_[face].reach.store(certified ? static_cast<float>(kSure * around.reach) : 0.0F, std::memory_order_relaxed);
  certificate_[face].per_clearance.store(certified ? static_cast<float>(kSure * (1 + std::sqrt(1 + k * k)) / k) : 0.0F,
                                         std::memory_order_release);
}

}  // namespace hullrecon
