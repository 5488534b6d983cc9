// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "factors/motion.h"

#include <cmath>

namespace hullrecon {

Quaternion exp(const Vec3& w) {
  const double angle2 = w.squaredNorm(), angle = std::sqrt(angle2);
  const double half = angle2 > 1e-16 ? std::sin(0.5 * angle) / angle : 0.5 - angle2 / 48;
  return Quaternion(std::cos(0.5 * angle), half * w[0], half * w[1], half * w[2]);
}

Vec3 log(const Quaternion& q) {
  const double sine = q.vec().norm(), sign = q.w() < 0 ? -1.0 : 1.0;
  const double scale = sine > 1e-9 ? 2 * std::atan2(sine, std::abs(q.w())) / sine : 2 / std::abs(q.w());
  return sign * scale * q.vec();
}

Mat3 log_derivative(const Vec3& r) {
  const double angle2 = r.squaredNorm(), half = 0.5 * std::sqrt(angle2);
  const double c = angle2 > 1e-6 ? (1 - half / std::tan(half)) / angle2 : 1.0 / 12 + angle2 / 720;
  const Mat3 h = hat(r);
  return Mat3::Identity() + 0.5 * h + c * h * h;
}

Mat3 rotation_y(double angle) {
  return Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix();
}

}  // namespace hullrecon
