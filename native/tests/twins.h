// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Plain twins of the residuals, templated for automatic differentiation: whole frames multiplied out, Ceres' own logarithm,
// nothing shared with residuals.h but the meaning.
#pragma once

#include <ceres/jet.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace twin {

using Jet = ceres::Jet<double, 40>;
template <class T>
using V = Eigen::Matrix<T, 3, 1>;
template <class T>
using M = Eigen::Matrix<T, 3, 3>;

template <class T>
struct Frame {
  M<T> R;
  V<T> t;

  static Frame of(const T* x) {
    return {Eigen::Quaternion<T>(x[6], x[3], x[4], x[5]).toRotationMatrix(), V<T>(x[0], x[1], x[2])};
  }
  static Frame tray(const Eigen::Vector3d& origin, const T& theta) {
    M<T> R;
    R << cos(theta), T(0), sin(theta), T(0), T(1), T(0), -sin(theta), T(0), cos(theta);
    return {R, origin.cast<T>()};
  }
  Frame inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
  Frame operator*(const Frame& o) const { return {R * o.R, R * o.t + t}; }
  V<T> operator*(const V<T>& p) const { return R * p + t; }
};

template <class T>
V<T> log(const M<T>& R) {
  V<T> w;
  ceres::RotationMatrixToAngleAxis(R.data(), w.data());
  return w;
}

template <class T>
Frame<T> lift(const std::vector<double>& seven) {
  std::vector<T> x(seven.begin(), seven.end());
  return Frame<T>::of(x.data());
}

template <class T>
void pixel(const T* k, const V<T>& p, T* uv) {
  const T x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y,
          radial = T(1) + k[4] * r2 + k[5] * r2 * r2 + k[8] * r2 * r2 * r2;
  uv[0] = k[0] * (x * radial + T(2) * k[6] * x * y + k[7] * (r2 + T(2) * x * x)) + k[2];
  uv[1] = k[1] * (y * radial + k[6] * (r2 + T(2) * y * y) + T(2) * k[7] * x * y) + k[3];
}

// x [+] delta for blocks of 8 (pose and tray), 7 (motion) and plain numbers, by the tangent: the definition under test.
template <class T>
std::vector<T> moved(const std::vector<double>& x, const T* delta) {
  std::vector<T> out(x.begin(), x.end());
  if (x.size() != 7 && x.size() != 8) {
    for (size_t k = 0; k < x.size(); ++k) out[k] += delta[k];
    return out;
  }
  for (int k = 0; k < 3; ++k) out[k] += delta[k];
  T turn[4], q[4] = {T(x[6]), T(x[3]), T(x[4]), T(x[5])}, product[4];
  ceres::AngleAxisToQuaternion(delta + 3, turn);
  ceres::QuaternionProduct(q, turn, product);
  for (int k = 0; k < 4; ++k) out[3 + k] = product[(k + 1) % 4];
  if (x.size() == 8) out[7] += delta[6];
  return out;
}

inline int tangent(size_t size) {
  return static_cast<int>(size == 8 || size == 7 ? size - 1 : size);
}

}  // namespace twin
