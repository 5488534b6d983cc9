// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Every residual of the adjustment, raw: whitening and robust loss are applied in cost.h and mixture.h, once for all.
//
// Call: residual(x, r, J). x[k]: parameter block k. r: kRows numbers. J, and each J[k], may be null; J[k] is row major, kRows
// by the block's size, by the block's tangent in its first columns (manifolds.h says why), zero in the last. False: the point
// cannot be evaluated and the solver refuses the step.
//
// Blocks: pose (8) = T_g_v and tray angle theta; motion (7); landmark (3) in g; navigation (6) = DVL scale error, heading
// drift, roll bias, pitch bias, depth bias, tray play; intrinsics (9); node (1) of the deviation field.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "hullrecon/camera.h"
#include "hullrecon/motion.h"

namespace hullrecon {

template <int Rows, int Size>
using Jacobian = Eigen::Map<Eigen::Matrix<double, Rows, Size, Size == 1 ? Eigen::ColMajor : Eigen::RowMajor>>;

// Calls fill(map) on block k's Jacobian, zeroed, when the solver wants it.
template <int Rows, int Size, class Fill>
void derive(double* const* J, int k, const Fill& fill) {
  if (!J || !J[k]) return;
  Jacobian<Rows, Size> j(J[k]);
  j.setZero();
  fill(j);
}

// Nodes of the deviation field about a place, each once: sum of weight * node, m outward.
struct FieldAt {
  std::vector<double> weight;

  double value(const double* const* node) const {
    double sum = 0;
    for (size_t k = 0; k < weight.size(); ++k) sum += weight[k] * node[k][0];
    return sum;
  }
  std::vector<int> sizes_after(std::vector<int> sizes) const {
    sizes.insert(sizes.end(), weight.size(), 1);
    return sizes;
  }
  void derive_nodes(double* const* J, size_t first, double by_field) const {
    for (size_t k = 0; J && k < weight.size(); ++k) {
      if (J[first + k]) J[first + k][0] = by_field * weight[k];
    }
  }
};

// Prior on a motion or on the motion of a pose (O 4.8), 6 rows: (m, rad) of prior^-1 x. Translation R_z' (t_x - t_z), in the
// prior's own axes; rotation Log(R_z' R_x). Size: 8 for a pose block, 7 for a motion. Whitened by a full square root.
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
    derive<6, Size>(J, 0, [&](auto& j) {
      j.template block<3, 3>(0, 0) = from_parent;
      j.template block<3, 3>(3, 3) = log_derivative(turn);
    });
    return true;
  }
};

// Depth, roll, pitch (O 4.9), 3 rows (m, rad, rad): predicted + bias - measured, by pose and navigation. Depth is z in g of the
// pressure sensor; R = Rz(yaw) Ry(pitch) Rx(roll). Angles differ by at most pi. No answer with the bow straight up or down.
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
    derive<3, 8>(J, 0, [&](auto& j) {
      j(0, 2) = 1;
      j.template block<1, 3>(0, 3) = -R.row(2) * hat(pressure_origin);
      j.template block<2, 3>(1, 3) << 1, s * tan_pitch, c * tan_pitch, 0, c, -s;
    });
    derive<3, 6>(J, 1, [](auto& j) { j(0, 4) = j(1, 2) = j(2, 3) = 1; });
    return true;
  }
};

// Tray angle (O 4.10), 1 row (rad): theta + play * direction - measured, by pose and navigation. The servo's play is a bias
// that flips with the direction of motion (+1, -1; 0 at rest).
struct Tray {
  static constexpr int kRows = 1;
  double measured, direction;

  std::vector<int> sizes() const { return {8, 6}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    r[0] = x[0][7] + x[1][5] * direction - measured;
    derive<1, 8>(J, 0, [](auto& j) { j(6) = 1; });
    derive<1, 6>(J, 1, [&](auto& j) { j(5) = direction; });
    return true;
  }
};

// Odometry (O 4.11), 6 rows (m, rad), by pose i, pose j, navigation, T_s_d:
//   e = [ t_ij - t_z ; Log(R_z' R_ij) ]  with T_ij = T_i^-1 T_j: translation in the axes of vehicle i, rotation in those of the
//       measured j, so that the covariance of z reads (translation in i, rotation perturbed on the right);
//   r = e - by_navigation (scale, drift) - by_mount Log(R_mount' R_s_d) - by_tray ((theta_i + theta_j) / 2 - tray).
// Sign: each by_* is the derivative of the *measured* motion, in the same coordinates, by its cause. A cause c moves what
// dead reckoning should have measured to z [+] by_c c, so it is taken off e. Whitened by a full square root.
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
    derive<6, 8>(J, 0, [&](auto& d) {
      d.template block<3, 3>(0, 0) = -from_global;
      d.template block<3, 3>(0, 3) = hat(step);
      d.template block<3, 3>(3, 3) = -by_turn * (j.q.conjugate() * i.q).toRotationMatrix();
      d.col(6) = -0.5 * by_tray;
    });
    derive<6, 8>(J, 1, [&](auto& d) {
      d.template block<3, 3>(0, 0) = from_global;
      d.template block<3, 3>(3, 3) = by_turn;
      d.col(6) = -0.5 * by_tray;
    });
    derive<6, 6>(J, 2, [&](auto& d) { d.template leftCols<2>() = -by_navigation; });
    derive<6, 7>(J, 3, [&](auto& d) { d.template block<6, 3>(0, 3) = -by_mount * log_derivative(tilt); });
    return true;
  }
};

// A landmark in the top camera's frame, T_g_v Trans(tray_origin) Ry(theta) T_s_ct, with its derivatives: of both camera
// factors.
struct InTopCamera {
  Vec3 point;
  Mat3 by_landmark;
  Eigen::Matrix<double, 3, 7> by_pose;
  Eigen::Matrix<double, 3, 6> by_mount;

  InTopCamera(const double* landmark, const double* pose_block, const double* mount_block, const Vec3& tray_origin,
              bool derive) {
    const Motion pose(pose_block), mount(mount_block);
    const Mat3 tray_from_vehicle = rotation_y(-pose_block[7]), camera_from_tray = mount.rotation().transpose();
    const Vec3 in_vehicle = pose.to_child(Eigen::Map<const Vec3>(landmark)),
               in_tray = tray_from_vehicle * (in_vehicle - tray_origin);
    point = camera_from_tray * (in_tray - mount.t);
    if (!derive) return;
    const Mat3 camera_from_vehicle = camera_from_tray * tray_from_vehicle;
    by_landmark = camera_from_vehicle * pose.rotation().transpose();
    by_pose << -by_landmark, camera_from_vehicle * hat(in_vehicle), -camera_from_tray * turn_y(in_tray);
    by_mount << -camera_from_tray, hat(point);
  }
};

// Stereo (O 4.12), 4 rows (px): predicted - measured, top u v, bottom u v, raw pixels; by landmark, pose, T_s_ct, T_ct_cb,
// intrinsics of top and bottom. One sigma for all rows; one Huber loss on the norm of the four (a pair is good or bad as one).
struct Stereo {
  static constexpr int kRows = 4;
  Vec3 tray_origin;
  Eigen::Vector4d measured;

  std::vector<int> sizes() const { return {3, 8, 7, 7, 9, 9}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const InTopCamera top(x[0], x[1], x[2], tray_origin, J != nullptr);
    const Motion bottom_pose(x[3]);
    const Vec3 in_bottom = bottom_pose.to_child(top.point);
    Projection above, below;
    const bool seen = project(x[4], top.point, J, above) && project(x[5], in_bottom, J, below);
    Eigen::Map<Eigen::Vector4d> out(r);
    if (seen) out << above.pixel - measured.head<2>(), below.pixel - measured.tail<2>();
    if (!seen) out.setConstant(kBehindPixels);
    if (!J) return true;
    if (!seen) above.by_point.setZero(), below.by_point.setZero(), above.by_intrinsics.setZero(), below.by_intrinsics.setZero();
    const Mat3 bottom_from_top = bottom_pose.rotation().transpose();
    Eigen::Matrix<double, 4, 3> by_top;  // by the point in the top camera
    by_top << above.by_point, below.by_point * bottom_from_top;
    derive<4, 3>(J, 0, [&](auto& j) { j = by_top * top.by_landmark; });
    derive<4, 8>(J, 1, [&](auto& j) { j.template leftCols<7>() = by_top * top.by_pose; });
    derive<4, 7>(J, 2, [&](auto& j) { j.template leftCols<6>() = by_top * top.by_mount; });
    derive<4, 7>(J, 3, [&](auto& j) {
      j.template block<2, 3>(2, 0) = -below.by_point * bottom_from_top;
      j.template block<2, 3>(2, 3) = below.by_point * hat(in_bottom);
    });
    derive<4, 9>(J, 4, [&](auto& j) { j.template topRows<2>() = above.by_intrinsics; });
    derive<4, 9>(J, 5, [&](auto& j) { j.template bottomRows<2>() = below.by_intrinsics; });
    return true;
  }
};

// One camera (O 4.13), 2 rows (px): predicted - measured; by landmark, pose, T_s_ct, intrinsics of that camera and, for the
// bottom one, T_ct_cb.
struct Mono {
  static constexpr int kRows = 2;
  Vec3 tray_origin;
  Eigen::Vector2d measured;
  bool bottom;

  std::vector<int> sizes() const { return bottom ? std::vector{3, 8, 7, 9, 7} : std::vector{3, 8, 7, 9}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const InTopCamera top(x[0], x[1], x[2], tray_origin, J != nullptr);
    const Motion camera = bottom ? Motion(x[4]) : Motion(Vec3::Zero(), Quaternion::Identity());
    const Vec3 point = camera.to_child(top.point);
    Projection image;
    const bool seen = project(x[3], point, J, image);
    Eigen::Map<Eigen::Vector2d> out(r);
    if (seen) out = image.pixel - measured;
    if (!seen) out.setConstant(kBehindPixels);
    if (!J) return true;
    if (!seen) image.by_point.setZero(), image.by_intrinsics.setZero();
    const Eigen::Matrix<double, 2, 3> by_top = image.by_point * camera.rotation().transpose();
    derive<2, 3>(J, 0, [&](auto& j) { j = by_top * top.by_landmark; });
    derive<2, 8>(J, 1, [&](auto& j) { j.template leftCols<7>() = by_top * top.by_pose; });
    derive<2, 7>(J, 2, [&](auto& j) { j.template leftCols<6>() = by_top * top.by_mount; });
    derive<2, 9>(J, 3, [&](auto& j) { j = image.by_intrinsics; });
    if (!bottom) return true;
    derive<2, 7>(J, 4, [&](auto& j) { j.template leftCols<6>() << -by_top, image.by_point * hat(point); });
    return true;
  }
};

// What the mesh says near a query, held until the next refresh: distance(p) = normal . p + offset, in M.
struct Facet {
  Vec3 normal = Vec3::Zero();
  double offset = 0;
  bool active = false;
};

// A DVL beam through the frames, from the DVL to M: `end` is the point at `length` along it, `along` its direction.
struct Beam {
  Mat3 tray;
  Vec3 end_dvl, end_tray, end_vehicle, end_hull, along_tray, along_vehicle, along_hull;

  Beam(const double* const* x, const Motion& offset, double tray_offset, const Vec3& tray_origin, const Vec3& beam,
       double length) {
    const Motion pose(x[0]), hull(x[1]), mount(x[2]);
    tray = rotation_y(x[0][7] + tray_offset);
    end_dvl = length * beam, end_tray = mount.apply(end_dvl), along_tray = mount.q * beam;
    end_vehicle = offset.apply(tray * end_tray + tray_origin), along_vehicle = offset.q * (tray * along_tray);
    end_hull = hull.to_child(pose.apply(end_vehicle)), along_hull = hull.q.conjugate() * (pose.q * along_vehicle);
  }
};

// Range of a DVL beam (O 4.14), 1 row (m): predicted - measured along the beam to the plane of the triangle that it hits, moved
// outward by the field f: cast + f / (n . d), n the outward normal, d the beam (n . d = -cos(incidence) from outside). By pose,
// T_g_M, T_s_d and field nodes. `offset`: vehicle at the ping in the vehicle of the node. A miss: no residual, no derivative.
// *refused (association.h): too many beams were lost at this point; False, so that no step gains by looking away.
struct Range {
  static constexpr int kRows = 1;
  Motion offset;
  double tray_offset;
  Vec3 beam, tray_origin;  // unit, in d; in v
  double measured;
  FieldAt field;
  const Facet* facet;
  const bool* refused;

  std::vector<int> sizes() const { return field.sizes_after({8, 7, 7}); }
  Beam at(const double* const* x, double length) const { return Beam(x, offset, tray_offset, tray_origin, beam, length); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const bool on = facet->active;
    const Beam start = at(x, 0);
    const double slope = on ? facet->normal.dot(start.along_hull) : 1.0, f = field.value(x + 3);
    const double cast = -(facet->normal.dot(start.end_hull) + facet->offset) / slope;
    r[0] = on ? cast + f / slope - measured : 0.0;
    if (!J) return !*refused;
    // dr = -n . d(end) / slope - f n . d(along) / slope^2; a turn moves both at once, hence the arm.
    const Beam b = at(x, cast);
    const auto arm = [&](const Vec3& end, const Vec3& along) { return Vec3(-end / slope - f / (slope * slope) * along); };
    const Vec3 n_global = Motion(x[1]).q * facet->normal, n_vehicle = Motion(x[0]).q.conjugate() * n_global;
    const Vec3 n_tray = b.tray.transpose() * (offset.q.conjugate() * n_vehicle), n_dvl = Motion(x[2]).q.conjugate() * n_tray;
    derive<1, 8>(J, 0, [&](auto& j) {
      j << -n_global.transpose() / slope, arm(b.end_vehicle, b.along_vehicle).cross(n_vehicle).transpose(),
          n_tray.dot(turn_y(arm(b.end_tray, b.along_tray))), 0;
    });
    derive<1, 7>(J, 1, [&](auto& j) {
      j << n_global.transpose() / slope, facet->normal.cross(arm(b.end_hull, b.along_hull)).transpose(), 0;
    });
    derive<1, 7>(J, 2, [&](auto& j) { j << -n_tray.transpose() / slope, arm(b.end_dvl, beam).cross(n_dvl).transpose(), 0; });
    field.derive_nodes(J, 3, on ? 1 / slope : 0.0);
    return !*refused;
  }
};

// Surface (O 4.4, 4.5), 1 row (m): signed distance of T_g_M^-1 l to the drawing, less the field; by landmark, T_g_M and field
// nodes. The derivative is that of the true distance: `facet` is its tangent plane at the last refresh.
struct Surface {
  static constexpr int kRows = 1;
  FieldAt field;
  const Facet* facet;

  std::vector<int> sizes() const { return field.sizes_after({3, 7}); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    const Motion hull(x[1]);
    const Vec3 in_hull = hull.to_child(Eigen::Map<const Vec3>(x[0])), n_global = hull.q * facet->normal;
    r[0] = facet->normal.dot(in_hull) + facet->offset - field.value(x + 2);
    derive<1, 3>(J, 0, [&](auto& j) { j = n_global.transpose(); });
    derive<1, 7>(J, 1, [&](auto& j) {
      j.template segment<3>(0) = -n_global;
      j.template segment<3>(3) = facet->normal.cross(in_hull);
    });
    field.derive_nodes(J, 2, -1.0);
    return true;
  }
};

// Prior of the deviation field, 1 row (no unit): a row of its whitening operator times the nodes.
struct FieldPrior {
  static constexpr int kRows = 1;
  FieldAt row;

  std::vector<int> sizes() const { return row.sizes_after({}); }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    r[0] = row.value(x);
    row.derive_nodes(J, 0, 1.0);
    return true;
  }
};

// Prior on numbers that add (navigation about zero, intrinsics about the start), Size rows: x - expected.
template <int Size>
struct VectorPrior {
  static constexpr int kRows = Size;
  std::array<double, Size> expected;

  std::vector<int> sizes() const { return {Size}; }
  bool operator()(const double* const* x, double* r, double* const* J) const {
    for (int k = 0; k < Size; ++k) r[k] = x[0][k] - expected[k];
    derive<Size, Size>(J, 0, [](auto& j) { j.setIdentity(); });
    return true;
  }
};

}  // namespace hullrecon
