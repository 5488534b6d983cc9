// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/camera_chain.h"

#include "factors/manifolds.h"

#include "expect.h"

using namespace hullrecon;

TEST_CASE("however pose or mount move, the camera sees the landmark displaced by E times the twist") {
  const double pose[8] = {1, 2, 3, 0.1, -0.3, 0.2, 0.9273618495495703, 0.4}, mount[7] = {0.05, -0.02, 0.1, 0.5, 0.5, -0.5, 0.5};
  const Vec3 tray(0.4, 0.02, 0.1), landmark(1.7, 2.9, 4.1);
  const CameraChain chain(pose, Motion(mount), tray);
  const auto seen = [&](const CameraChain& a) {
    return Vec3(chain.camera_from_global.transpose() * a.camera_from_global * (landmark - a.centre));
  };
  const Vec3 q = landmark - chain.origin;
  constexpr double h = 1e-6;
  for (int k = 0; k < 13; ++k) {
    Vec3 at[2];
    for (int side : {0, 1}) {
      double delta[13] = {}, moved_pose[8], moved_mount[7];
      delta[k] = side ? h : -h;
      PoseManifold().Plus(pose, delta, moved_pose), RigidManifold().Plus(mount, delta + 7, moved_mount);
      at[side] = seen(CameraChain(moved_pose, Motion(moved_mount), tray));
    }
    Eigen::Matrix<double, 6, 13> by;
    by << chain.by_pose, chain.by_mount;
    const Eigen::Matrix<double, 6, 1> twist = by.col(k);
    CHECK(((at[1] - at[0]) / (2 * h) - displacement(q, twist)).norm() < 1e-8);
  }
}

TEST_CASE("products with E and its adjoint are those with its matrix") {
  const Vec3 q(0.3, -1.2, 2.0);
  Eigen::Matrix<double, 3, 6> E;
  E << Mat3::Identity(), -hat(q);
  const Mat3 m = Mat3::Random();
  CHECK((adjoint(q, m) - E.transpose() * m).norm() < 1e-14);
  CHECK((adjoint(q, Vec3(m.col(0))) - E.transpose() * m.col(0)).norm() < 1e-14);
  const Eigen::Matrix<double, 6, 3> z = Eigen::Matrix<double, 6, 3>::Random();
  Eigen::Matrix<double, 6, 6> x = Eigen::Matrix<double, 6, 6>::Ones();
  add_times_displacement(x, -1.0, z, q);
  CHECK((x - (Eigen::Matrix<double, 6, 6>::Ones() - z * E)).norm() < 1e-13);
}
