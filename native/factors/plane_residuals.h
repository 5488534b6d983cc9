// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Residuals of planar patches of the hull [Ozog2016 2.3.4, B].
//
// A plane is three numbers, pi: its unit normal towards the origin of the frame that holds it, times its distance from it, so
// that pi . x = -|pi|^2 on it. It is singular where the plane passes through that origin, so it is held in the vehicle frame of
// its anchor, the node that first saw it, and never in g.
#pragma once

#include "factors/hull_residuals.h"

namespace hullrecon {

// A plane of anchor a as node j sees it, n . x = -h in the vehicle frame of j [Ozog2016 B.5], with its derivatives: rows normal
// (3) and distance (1). Where the node is the anchor, its own, which moves with no pose.
struct SeenPlane {
  static constexpr double kLeastDistance = 1e-9;  // m
  Vec3 normal;
  double distance;
  Eigen::Matrix<double, 4, 3> by_plane;
  Eigen::Matrix<double, 4, 6> by_node, by_anchor;

  // node, anchor: null where they are one. False: the plane passes through its anchor.
  bool at(const double* plane, const double* node, const double* anchor) {
    const Vec3 pi(plane);
    const double p = pi.norm();
    if (!(p > kLeastDistance)) return false;
    const Vec3 n = pi / p;
    const Mat3 across = (Mat3::Identity() - n * n.transpose()) / p;
    normal = n, distance = p;
    by_plane << across, n.transpose();
    if (!node) return true;
    const Motion j(node), a(anchor);
    const Mat3 anchor_from_global = a.rotation().transpose(), node_from_anchor = (j.q.conjugate() * a.q).toRotationMatrix();
    const Vec3 t = anchor_from_global * (j.t - a.t), n_global = a.q * n;
    normal = node_from_anchor * n, distance = n.dot(t) + p;
    by_plane.topRows<3>() = node_from_anchor * across;
    by_plane.row(3) += t.transpose() * across;
    by_node.setZero(), by_anchor.setZero();
    by_node.topRightCorner<3, 3>() = hat(normal);
    by_node.bottomLeftCorner<1, 3>() = n_global.transpose();
    by_anchor.topRightCorner<3, 3>() = -node_from_anchor * hat(n);
    by_anchor.row(3) << -n_global.transpose(), -t.cross(n).transpose();
    return true;
  }

  // As pi in the vehicle frame of the node, and the derivative of that by (normal, distance).
  Vec3 pi() const { return distance * normal; }
  Eigen::Matrix<double, 3, 4> by_both() const {
    Eigen::Matrix<double, 3, 4> out;
    out << distance * Mat3::Identity(), normal;
    return out;
  }
};

// A plane seen from a pose [Ozog2016 2.2].
// Rows: 3, m. Blocks: plane and, unless the node is its anchor, node and anchor. Frame: vehicle of the node. Sign: predicted -
// measured. Sigma: full square root of the information.
struct PlaneSighting {
  static constexpr int kRows = 3;
  Vec3 measured;
  bool at_anchor;

  std::vector<int> sizes() const { return at_anchor ? std::vector{3} : std::vector{3, 8, 8}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    SeenPlane seen;
    if (!seen.at(x[0], at_anchor ? nullptr : x[1], at_anchor ? nullptr : x[2])) return false;
    Eigen::Map<Vec3> out(r);
    out = seen.pi() - measured;
    const Eigen::Matrix<double, 3, 4> by = seen.by_both();
    derive(J, 0, 3, 3, [&](Jacobian& j) { j.block<3, 3>(0, 0) = by * seen.by_plane; });
    if (at_anchor) return true;
    derive(J, 1, 3, 8, [&](Jacobian& j) { j.block<3, 6>(0, 0) = by * seen.by_node; });
    derive(J, 2, 3, 8, [&](Jacobian& j) { j.block<3, 6>(0, 0) = by * seen.by_anchor; });
    return true;
  }
};

// Two planes of one smooth surface, piecewise planar [Ozog2016 2.3].
// Rows: 3, m. Blocks: first plane, second plane and, unless they share it, the anchor of the first and that of the second.
// Frame: vehicle of the first's anchor. Sign: second as seen there - first - (measured + by_place (y - place)), what the
// curvature between them makes of a second one whose point lies at y: a curved surface turns on the way to it, so that the
// difference would else hold the second where it was when it was measured. Sigma: full square root of the information, from
// the characteristic curvature.
struct PlanePair {
  static constexpr int kRows = 3;
  Vec3 measured;
  Vec3 point, place;  // of the second, in its anchor; where that lay in the first's anchor when `measured` was taken
  Mat3 by_place;
  bool one_anchor;

  std::vector<int> sizes() const { return one_anchor ? std::vector{3, 3} : std::vector{3, 3, 8, 8}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    SeenPlane seen;
    if (!seen.at(x[1], one_anchor ? nullptr : x[2], one_anchor ? nullptr : x[3])) return false;
    Eigen::Map<Vec3> out(r);
    out = seen.pi() - Vec3(x[0]) - measured;
    const Eigen::Matrix<double, 3, 4> by = seen.by_both();
    derive(J, 0, 3, 3, [](Jacobian& j) { j.block<3, 3>(0, 0) = -Mat3::Identity(); });
    derive(J, 1, 3, 3, [&](Jacobian& j) { j.block<3, 3>(0, 0) = by * seen.by_plane; });
    if (one_anchor) {
      out -= by_place * (point - place);
      return true;
    }
    const Motion node(x[2]), anchor(x[3]);
    const Mat3 node_from_global = node.rotation().transpose(),
               node_from_anchor = (node.q.conjugate() * anchor.q).toRotationMatrix();
    const Vec3 y = node_from_global * (anchor.t - node.t) + node_from_anchor * point;
    out -= by_place * (y - place);
    derive(J, 2, 3, 8, [&](Jacobian& j) {
      j.block<3, 6>(0, 0) = by * seen.by_node;
      j.block<3, 3>(0, 0) += by_place * node_from_global;
      j.block<3, 3>(0, 3) -= by_place * hat(y);
    });
    derive(J, 3, 3, 8, [&](Jacobian& j) {
      j.block<3, 6>(0, 0) = by * seen.by_anchor;
      j.block<3, 3>(0, 0) -= by_place * node_from_global;
      j.block<3, 3>(0, 3) += by_place * node_from_anchor * hat(point);
    });
    return true;
  }
};

// Range of a DVL beam to a plane [Ozog2016 2.4; its sign and square are misprinted, docs/methods.md 16].
// Rows: 1, m. Blocks: plane, node, T_s_d and, unless the node is it, the plane's anchor. Frames: as Range. Sign: predicted -
// measured; predicted is -(h + n . o) / (n . d), o the beam's origin and d its direction in the vehicle of the node. Sigma: one
// a beam, under Huber's loss. Returns false where the beam runs along the plane.
struct PlaneRange {
  static constexpr int kRows = 1;
  Motion offset;
  double tray_offset;
  Vec3 beam, tray_origin;  // unit, in d; in v
  double measured;
  bool at_anchor;

  std::vector<int> sizes() const { return at_anchor ? std::vector{3, 8, 7} : std::vector{3, 8, 7, 8}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    constexpr std::array<double, 7> kVehicle{0, 0, 0, 0, 0, 0, 1};  // the beam is wanted in the vehicle of the node
    const double* const of_beam[] = {x[1], kVehicle.data(), x[2]};
    SeenPlane seen;
    if (!seen.at(x[0], at_anchor ? nullptr : x[1], at_anchor ? nullptr : x[3])) return false;
    const Beam start(of_beam, offset, tray_offset, tray_origin, beam, 0);
    const double slope = seen.normal.dot(start.along_vehicle);
    if (!(std::abs(slope) > 1e-6)) return false;
    const double cast = -(seen.normal.dot(start.end_vehicle) + seen.distance) / slope;
    r[0] = cast - measured;
    if (!J) return true;
    const Beam b(of_beam, offset, tray_offset, tray_origin, beam, cast);
    const Vec3 n_tray = b.tray.transpose() * (offset.q.conjugate() * seen.normal), n_dvl = Motion(x[2]).q.conjugate() * n_tray;
    Eigen::Matrix<double, 1, 4> by;
    by << -b.end_vehicle.transpose() / slope, -1 / slope;
    derive(J, 0, 1, 3, [&](Jacobian& j) { j.block<1, 3>(0, 0) = by * seen.by_plane; });
    derive(J, 1, 1, 8, [&](Jacobian& j) {
      if (!at_anchor) j.block<1, 6>(0, 0) = by * seen.by_node;
      j(0, 6) = -n_tray.dot(turn_y(b.end_tray)) / slope;
    });
    derive(J, 2, 1, 7, [&](Jacobian& j) { j << -n_tray.transpose() / slope, -b.end_dvl.cross(n_dvl).transpose() / slope, 0; });
    if (at_anchor) return true;
    derive(J, 3, 1, 8, [&](Jacobian& j) { j.block<1, 6>(0, 0) = by * seen.by_anchor; });
    return true;
  }
};

}  // namespace hullrecon
