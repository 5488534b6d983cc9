// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Projects points by the pinhole with plumb_bob distortion [Brown1971]: nine numbers fx fy cx cy k1 k2 p1 p2 k3, pixel centres
// as OpenCV has them.
#pragma once

#include <Eigen/Core>

#include "factors/motion.h"

namespace hullrecon {

constexpr double kInFront = 1e-6;      // m along the optical axis
constexpr double kBehindPixels = 1e4;  // the error of a point that is not in front, see below

struct Projection {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_point = Eigen::Matrix<double, 2, 3>::Zero();
};

// The pixel of a point in the camera frame, and its derivative by the point. False for a point behind the camera: its residual
// is then kBehindPixels on each row without derivative. So a step that carries a point behind the camera costs more than it can
// gain and is refused, while an observation that starts there is a constant and poisons nothing else.
inline bool project(const double* k, const Vec3& p, bool derive, Projection& out) {
  if (!(p[2] > kInFront)) return false;
  const double x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y;
  const double k1 = k[4], k2 = k[5], p1 = k[6], p2 = k[7], k3 = k[8];
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3)), slope = k1 + r2 * (2 * k2 + 3 * r2 * k3);  // d radial / d r2
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  out.pixel = {k[0] * xd + k[2], k[1] * yd + k[3]};
  if (!derive) return true;
  const double cross = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;  // d xd / dy = d yd / dx
  const double xx = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x;
  const double yy = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  out.by_point << k[0] * xx, k[0] * cross, -k[0] * (xx * x + cross * y),  //
      k[1] * cross, k[1] * yy, -k[1] * (cross * x + yy * y);
  out.by_point /= p[2];
  return true;
}

// The derivative of the pixel by the nine numbers, for a point that is in front.
inline Eigen::Matrix<double, 2, 9> by_intrinsics(const double* k, const Vec3& p) {
  const double x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial = 1 + r2 * (k[4] + r2 * (k[5] + r2 * k[8]));
  const double xd = x * radial + 2 * k[6] * x * y + k[7] * (r2 + 2 * x * x);
  const double yd = y * radial + k[6] * (r2 + 2 * y * y) + 2 * k[7] * x * y;
  const double fx = k[0] * x, fy = k[1] * y;
  Eigen::Matrix<double, 2, 9> out;
  out << xd, 0, 1, 0, fx * r2, fx * r4, 2 * fx * y, k[0] * (r2 + 2 * x * x), fx * r6,  //
      0, yd, 0, 1, fy * r2, fy * r4, k[1] * (r2 + 2 * y * y), 2 * fy * x, fy * r6;
  return out;
}

}  // namespace hullrecon
