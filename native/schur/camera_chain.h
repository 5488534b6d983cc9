// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The chain from vehicle over tray and mount to the top camera, and how a landmark appears to move when it moves.
//
// However the chain moves, the camera sees a landmark l displaced by  d = tau + phi x (l - origin) = E (tau, phi),
// E = [I, -hat(l - origin)]: six numbers, the twist of the camera, in the axes of g about the vehicle's origin. Seven unknowns
// of the pose and six of the mount act through these six alone, so landmarks are eliminated in twists, at half the cost
// (docs/schur.md, 1 and 2).
#pragma once

#include "factors/motion.h"

namespace hullrecon {

using Twist = Eigen::Matrix<double, 6, 1>;

struct CameraChain {
  Mat3 camera_from_global;
  Vec3 centre, origin;                   // of camera and vehicle, in g
  Eigen::Matrix<double, 6, 7> by_pose;   // P: the twist by a pose's tangent
  Eigen::Matrix<double, 6, 6> by_mount;  // Q: and by that of T_s_ct

  CameraChain() = default;
  CameraChain(const double* pose_block, const Motion& mount, const Vec3& tray_origin) {
    const Motion pose(pose_block);
    const Mat3 vehicle = pose.rotation(), tray = vehicle * rotation_y(pose_block[7]), camera = tray * mount.rotation();
    const Vec3 hinge = vehicle * tray_origin, axis = vehicle.col(1);
    camera_from_global = camera.transpose();
    origin = pose.t;
    centre = origin + hinge + tray * mount.t;
    by_pose.setZero(), by_mount.setZero();
    by_pose.topLeftCorner<3, 3>() = -Mat3::Identity();
    by_pose.block<3, 3>(3, 3) = -vehicle;
    by_pose.col(6) << axis.cross(hinge), -axis;
    by_mount.topLeftCorner<3, 3>() = -tray;
    by_mount.topRightCorner<3, 3>() = -hat(centre - origin) * camera;
    by_mount.bottomRightCorner<3, 3>() = -camera;
  }
};

// Products with E and its adjoint E' for a landmark at q from the origin: cross products instead of matrices.

// E twist
inline Vec3 displacement(const Vec3& q, const Twist& twist) {
  return twist.head<3>() + twist.tail<3>().cross(q);
}

// E' v
inline Twist adjoint(const Vec3& q, const Vec3& v) {
  Twist out;
  out << v, q.cross(v);
  return out;
}

// E' m
inline Eigen::Matrix<double, 6, 3> adjoint(const Vec3& q, const Mat3& m) {
  Eigen::Matrix<double, 6, 3> out;
  out.topRows<3>() = m;
  for (int c = 0; c < 3; ++c) out.col(c).tail<3>() = q.cross(m.col(c));
  return out;
}

// x += sign z E
template <class Block>
void add_times_displacement(Block& x, double sign, const Eigen::Matrix<double, 6, 3>& z, const Vec3& q) {
  x.template leftCols<3>() += sign * z;
  x.col(3) += (sign * q[1]) * z.col(2) - (sign * q[2]) * z.col(1);
  x.col(4) += (sign * q[2]) * z.col(0) - (sign * q[0]) * z.col(2);
  x.col(5) += (sign * q[0]) * z.col(1) - (sign * q[1]) * z.col(0);
}

}  // namespace hullrecon
