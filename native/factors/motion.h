// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Rigid motions as 7 doubles, x y z qx qy qz qw (T_a_b: p_a = R p_b + t), and the rotations' small change.
// The one convention: rotation perturbed on the right, R Exp(w); translation added in the parent frame a.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace hullrecon {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

inline Mat3 hat(const Vec3& v) {
  Mat3 m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

Quaternion exp(const Vec3& w);

// The rotation vector of at most pi.
Vec3 log(const Quaternion& q);

// d Log(R Exp(w)) / dw at w = 0, where r = Log(R): the inverse of SO(3)'s right Jacobian.
Mat3 log_derivative(const Vec3& r);

// d Ry(theta) p / d theta = Ry(theta) (e_y x p)
inline Vec3 turn_y(const Vec3& p) {
  return {p[2], 0, -p[0]};
}

struct Motion {
  Vec3 t;
  Quaternion q;

  explicit Motion(const double* x) : t(x), q(x[6], x[3], x[4], x[5]) { q.normalize(); }
  Motion(const Vec3& t, const Quaternion& q) : t(t), q(q) {}

  Mat3 rotation() const { return q.toRotationMatrix(); }
  Vec3 apply(const Vec3& p) const { return q * p + t; }
  Vec3 to_child(const Vec3& p) const { return q.conjugate() * (p - t); }
};

Mat3 rotation_y(double angle);

}  // namespace hullrecon
