// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The top camera at the end of its arm: vehicle pose, tray, mount. However the arm moves, the camera sees a landmark l
// displaced by tau + phi x (l - origin): six numbers, the twist (tau, phi), in the axes of g about the vehicle's origin. Seven
// unknowns of the pose and six of the mount act through these six alone, so landmarks are eliminated in twists, at half the
// cost.
#pragma once

#include "factors/motion.h"

namespace hullrecon {

struct Arm {
  Mat3 camera_from_global;
  Vec3 centre, origin;                   // of camera and vehicle, in g
  Eigen::Matrix<double, 6, 7> by_pose;   // the twist by a pose's tangent
  Eigen::Matrix<double, 6, 6> by_mount;  // and by that of T_s_ct

  Arm() = default;
  Arm(const double* pose_block, const Motion& mount, const Vec3& tray_origin) {
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

}  // namespace hullrecon
