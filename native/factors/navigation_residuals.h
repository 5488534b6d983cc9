// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Residuals of priors, depth and attitude, tray and odometry [Ozog2016 4.8-4.11], and of position fixes (USBL, GNSS).
#pragma once

#include <array>

#include "factors/residual.h"

namespace hullrecon {

// Prior of a motion, or of the motion in a pose block [Ozog2016 4.8].
// Rows: 6, (m, rad). Blocks: the motion (Size 7) or the pose (Size 8). Frame: the axes of the prior.
// Sign: prior^-1 x, translation R_z' (t_x - t_z), rotation Log(R_z' R_x). Sigma: full square root of the information.
template <int Size>
struct MotionPrior {
  static constexpr int kRows = 6;
  Motion prior;

  std::vector<int> sizes() const { return {Size}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const Motion at(x[0]);
    const Mat3 from_parent = prior.rotation().transpose();
    const Vec3 turn = log(prior.q.conjugate() * at.q);
    Eigen::Map<Vec3> top(r), bottom(r + 3);
    top = from_parent * (at.t - prior.t);
    bottom = turn;
    derive(J, 0, 6, Size, [&](Jacobian& j) {
      j.block<3, 3>(0, 0) = from_parent;
      j.block<3, 3>(3, 3) = log_derivative(turn);
    });
    return true;
  }
};

// Depth, roll and pitch [Ozog2016 4.9].
// Rows: 3, (m, rad, rad). Blocks: pose, navigation. Frame: depth is z in g of the pressure sensor, R = Rz(yaw) Ry(pitch)
// Rx(roll). Sign: predicted + bias - measured, angles within pi. Sigma: one a row. Returns false with the bow straight up or
// down, where roll is not defined.
struct Attitude {
  static constexpr int kRows = 3;
  Vec3 pressure_origin;  // in v
  Vec3 measured;

  std::vector<int> sizes() const { return {8, 6}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const Motion pose(x[0]);
    const Mat3 R = pose.rotation();
    const double cos_pitch = std::hypot(R(2, 1), R(2, 2));
    if (cos_pitch < 1e-6) return false;
    const double roll = std::atan2(R(2, 1), R(2, 2)), pitch = std::atan2(-R(2, 0), cos_pitch);
    r[0] = pose.t[2] + R.row(2).dot(pressure_origin) + x[1][4] - measured[0];
    r[1] = std::remainder(roll + x[1][2] - measured[1], 2 * M_PI);
    r[2] = std::remainder(pitch + x[1][3] - measured[2], 2 * M_PI);
    const double s = std::sin(roll), c = std::cos(roll), tan_pitch = -R(2, 0) / cos_pitch;
    derive(J, 0, 3, 8, [&](Jacobian& j) {
      j(0, 2) = 1;
      j.block<1, 3>(0, 3) = -R.row(2) * hat(pressure_origin);
      j.block<2, 3>(1, 3) << 1, s * tan_pitch, c * tan_pitch, 0, c, -s;
    });
    derive(J, 1, 3, 6, [](Jacobian& j) { j(0, 4) = j(1, 2) = j(2, 3) = 1; });
    return true;
  }
};

// Tray angle with the servo's backlash [Ozog2016 4.10].
// Rows: 1, rad. Blocks: pose, navigation. Sign: theta + backlash * direction - measured; the backlash is a bias that flips with
// the direction of motion (+1, -1; 0 at rest). Sigma: one.
struct Tray {
  static constexpr int kRows = 1;
  double measured, direction;

  std::vector<int> sizes() const { return {8, 6}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    r[0] = x[0][7] + x[1][5] * direction - measured;
    derive(J, 0, 1, 8, [](Jacobian& j) { j(0, 6) = 1; });
    derive(J, 1, 1, 6, [&](Jacobian& j) { j(0, 5) = direction; });
    return true;
  }
};

// Odometry between two poses, its systematic part taken off [Ozog2016 4.11].
// Rows: 6, (m, rad). Blocks: pose i, pose j, navigation, T_s_d. Sigma: full square root of the information.
//   e = [ t_ij - t_z ; Log(R_z' R_ij) ]  with T_ij = T_i^-1 T_j: translation in the axes of vehicle i, rotation in those of the
//       measured j, so that the covariance of z reads (translation in i, rotation perturbed on the right);
//   r = e - by_navigation (scale, drift) - by_mount Log(R_mount' R_s_d) - by_tray ((theta_i + theta_j) / 2 - tray).
// Sign: each by_* is the derivative of the *measured* motion, in the same coordinates, by its cause. A cause c moves what
// dead reckoning should have measured to z [+] by_c c, so it is taken off e.
struct Odometry {
  static constexpr int kRows = 6;
  Motion measured;
  Eigen::Matrix<double, 6, 2> by_navigation;
  Eigen::Matrix<double, 6, 3> by_mount;
  Eigen::Matrix<double, 6, 1> by_tray;
  double tray;       // mean angle that dead reckoning used
  Quaternion mount;  // rotation of T_s_d that it used

  std::vector<int> sizes() const { return {8, 8, 6, 7}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const Motion i(x[0]), j(x[1]);
    const Mat3 from_global = i.rotation().transpose();
    const Vec3 step = from_global * (j.t - i.t), turn = log(measured.q.conjugate() * i.q.conjugate() * j.q);
    const Vec3 tilt = log(mount.conjugate() * Motion(x[3]).q);
    const double theta = 0.5 * (x[0][7] + x[1][7]) - tray;
    Eigen::Map<Eigen::Matrix<double, 6, 1>> out(r);
    out << step - measured.t, turn;
    out -= by_navigation * Eigen::Map<const Eigen::Vector2d>(x[2]) + by_mount * tilt + by_tray * theta;
    const Mat3 by_turn = log_derivative(turn);
    derive(J, 0, 6, 8, [&](Jacobian& d) {
      d.block<3, 3>(0, 0) = -from_global;
      d.block<3, 3>(0, 3) = hat(step);
      d.block<3, 3>(3, 3) = -by_turn * (j.q.conjugate() * i.q).toRotationMatrix();
      d.block<6, 1>(0, 6) = -0.5 * by_tray;
    });
    derive(J, 1, 6, 8, [&](Jacobian& d) {
      d.block<3, 3>(0, 0) = from_global;
      d.block<3, 3>(3, 3) = by_turn;
      d.block<6, 1>(0, 6) = -0.5 * by_tray;
    });
    derive(J, 2, 6, 6, [&](Jacobian& d) { d.block<6, 2>(0, 0) = -by_navigation; });
    derive(J, 3, 6, 7, [&](Jacobian& d) { d.block<6, 3>(0, 3) = -by_mount * log_derivative(tilt); });
    return true;
  }
};

// Constant velocity over three poses in a row, across a gap of the sensors [KimEustice2009 II-A].
// Rows: 6, (m/s, rad/s). Blocks: pose i, j, k. Frame: translation in the axes of vehicle j, rotation vectors of the two steps.
// Sign: velocity from j to k less that from i to j, each the mean over its interval. Sigma: one a row.
struct Velocity {
  static constexpr int kRows = 6;
  double before, after;  // s, from i to j and from j to k

  std::vector<int> sizes() const { return {8, 8, 8}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const Motion i(x[0]), j(x[1]), k(x[2]);
    const Mat3 from_global = j.rotation().transpose();
    const Vec3 came = from_global * (j.t - i.t) / before, goes = from_global * (k.t - j.t) / after;
    const Vec3 turned = log(i.q.conjugate() * j.q), turns = log(j.q.conjugate() * k.q);
    Eigen::Map<Eigen::Matrix<double, 6, 1>>(r) << goes - came, turns / after - turned / before;
    const Mat3 by_turned = log_derivative(turned) / before, by_turns = log_derivative(turns) / after;
    derive(J, 0, 6, 8, [&](Jacobian& d) {
      d.block<3, 3>(0, 0) = from_global / before;
      d.block<3, 3>(3, 3) = by_turned * (j.q.conjugate() * i.q).toRotationMatrix();
    });
    derive(J, 1, 6, 8, [&](Jacobian& d) {
      d.block<3, 3>(0, 0) = -from_global * (1 / before + 1 / after);
      d.block<3, 3>(0, 3) = hat(goes - came);
      d.block<3, 3>(3, 3) = -by_turned - by_turns * (k.q.conjugate() * j.q).toRotationMatrix();
    });
    derive(J, 2, 6, 8, [&](Jacobian& d) {
      d.block<3, 3>(0, 0) = from_global / after;
      d.block<3, 3>(3, 3) = by_turns;
    });
    return true;
  }
};

// A position fix of USBL or GNSS.
// Rows: 2, m, north and east. Blocks: pose, world = north and east of the origin of g (m), heading of its x axis (rad). Frame:
// world, level, z down as in g, so that a heading turns from north to east. Sign: predicted - measured. Sigma: one a row, under
// Huber's loss.
struct Position {
  static constexpr int kRows = 2;
  Vec3 antenna;  // where the position was measured, in the vehicle of the node
  Eigen::Vector2d measured;

  std::vector<int> sizes() const { return {8, 3}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const Motion pose(x[0]);
    const Vec3 at = pose.apply(antenna);
    const double c = std::cos(x[1][2]), s = std::sin(x[1][2]);
    Eigen::Matrix2d turn;
    turn << c, -s, s, c;
    const Eigen::Vector2d turned = turn * at.head<2>();
    Eigen::Map<Eigen::Vector2d> out(r);
    out = turned + Eigen::Vector2d(x[1]) - measured;
    derive(J, 0, 2, 8, [&](Jacobian& j) {
      j.block<2, 2>(0, 0) = turn;
      j.block<2, 3>(0, 3) = -turn * (pose.rotation() * hat(antenna)).topRows<2>();
    });
    derive(J, 1, 2, 3, [&](Jacobian& j) {
      j.block<2, 2>(0, 0).setIdentity();
      j.block<2, 1>(0, 2) << -turned[1], turned[0];
    });
    return true;
  }
};

// Prior of plain numbers: navigation and world about zero, intrinsics about the start.
// Rows: Size, in the units of the numbers. Blocks: the numbers. Sign: x - expected. Sigma: one a row.
template <int Size>
struct VectorPrior {
  static constexpr int kRows = Size;
  std::array<double, Size> expected;

  std::vector<int> sizes() const { return {Size}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    for (int k = 0; k < Size; ++k) r[k] = x[0][k] - expected[k];
    derive(J, 0, Size, Size, [](Jacobian& j) { j.diagonal().setOnes(); });
    return true;
  }
};

}  // namespace hullrecon
