// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Products with the lever E = [I, -hat(q)] of a twist on a landmark at q: cross products instead of matrices.
#pragma once

#include "factors/motion.h"

namespace hullrecon {

// E' m
inline Eigen::Matrix<double, 6, 3> lifted(const Vec3& q, const Mat3& m) {
  Eigen::Matrix<double, 6, 3> out;
  out.topRows<3>() = m;
  for (int c = 0; c < 3; ++c) out.col(c).tail<3>() = q.cross(m.col(c));
  return out;
}

inline Eigen::Matrix<double, 6, 1> lifted(const Vec3& q, const Vec3& v) {
  Eigen::Matrix<double, 6, 1> out;
  out << v, q.cross(v);
  return out;
}

// E twist
inline Vec3 lowered(const Vec3& q, const Eigen::Matrix<double, 6, 1>& twist) {
  return twist.head<3>() + twist.tail<3>().cross(q);
}

// x += sign z E
template <class Block>
void add_times_lever(Block& x, double sign, const Eigen::Matrix<double, 6, 3>& z, const Vec3& q) {
  x.template leftCols<3>() += sign * z;
  x.col(3) += (sign * q[1]) * z.col(2) - (sign * q[2]) * z.col(1);
  x.col(4) += (sign * q[2]) * z.col(0) - (sign * q[0]) * z.col(2);
  x.col(5) += (sign * q[0]) * z.col(1) - (sign * q[1]) * z.col(0);
}

}  // namespace hullrecon
