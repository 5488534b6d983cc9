// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/pair_motion.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "factors/motion.h"

namespace hullrecon {

namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using Matrix23 = Eigen::Matrix<double, 2, 3>;

constexpr double kAhead = 1e-6;         // m: nearer a point has no image
constexpr double kPointDamping = 1e-9;  // of a point's information: keeps a feature that only one camera saw from dividing by 0
constexpr double kLeastSquare = 1e-12;  // of a depth's error in the image, below which it is nothing
constexpr double kLeastLength = 1e-12;

struct Image {
  Vector2d xy;
  Matrix23 by_point;  // derivative by the point in the frame that the camera is placed in
};

// Behind the camera the image is NaN.
Image project(const Transform& camera, const Vector3d& point) {
  const Vector3d seen = camera.turn * point + camera.shift;
  const double depth = seen.z() > kAhead ? seen.z() : std::numeric_limits<double>::quiet_NaN();
  Image out;
  out.xy = seen.head<2>() / depth;
  out.by_point = (camera.turn.topRows<2>() - out.xy * camera.turn.row(2)) / depth;
  return out;
}

// Vector products of a point with each row of a derivative.
Matrix23 point_cross_rows(const Vector3d& point, const Matrix23& rows) {
  return -rows * hat(point);
}

bool is_seen(const Vector2d& residual) {
  return std::isfinite(residual.x()) && std::isfinite(residual.y());
}

Vector2d at(std::span<const double, 8> seen, int camera) {
  return {seen[2 * camera], seen[2 * camera + 1]};
}

const Transform kSame{Eigen::Matrix3d::Identity(), Vector3d::Zero()};

// A point of the first node's leading camera, there and in the second node's.
std::array<Vector3d, 2> in_nodes(const StereoCameras& cameras, const Vector3d& point) {
  return {point, cameras.motion.turn * point + cameras.motion.shift};
}

}  // namespace

void squared_reprojections(const Transform& camera_from_point, std::span<const double> point, std::span<const double> xy,
                           std::span<double> squared) {
  for (size_t k = 0; k < squared.size(); ++k) {
    const Vector3d seen = camera_from_point.turn * Eigen::Map<const Vector3d>(&point[3 * k]) + camera_from_point.shift;
    const Vector2d gap = seen.head<2>() / seen.z() - Eigen::Map<const Vector2d>(&xy[2 * k]);
    squared[k] = std::isnan(xy[2 * k]) ? 0.0 : seen.z() > kAhead ? gap.squaredNorm() : std::numeric_limits<double>::infinity();
  }
}

void add_reprojections(const Transform& motion, const SeenPoints& seen, std::span<const bool> counts, MotionNormal& sum) {
  const Eigen::Matrix3d back = motion.turn.transpose();
  for (size_t k = 0; k < counts.size(); ++k) {
    if (!counts[k]) continue;
    const Eigen::Map<const Vector3d> point(&seen.point[3 * k]);
    const Vector3d moved =
        seen.backward ? Vector3d(back * (point - motion.shift)) : Vector3d(motion.turn * point + motion.shift);
    const Image image = project(seen.camera_from_node, moved);
    const Eigen::Map<const Vector2d> xy(&seen.xy[2 * k]);
    if (!image.xy.allFinite()) {  // behind the camera: as wrong as from the middle of the image, whatever the motion does
      sum.cost += xy.squaredNorm();
      continue;
    }
    const Matrix23 by_point = image.by_point * (seen.backward ? back : motion.turn);
    Eigen::Matrix<double, 2, 7> rows;  // the derivative by the motion, the residual
    rows.leftCols<3>() = seen.backward ? Matrix23(-by_point) : image.by_point;
    rows.middleCols<3>(3) =
        seen.backward ? Matrix23(-point_cross_rows(moved, image.by_point)) : point_cross_rows(point, by_point);
    rows.col(6) = image.xy - xy;
    // by_depth, d: how far one unit of error in the images that triangulated the point moves this image. The rows are
    // whitened by the covariance I + d d', of which I - (1 - 1 / sqrt(1 + d'd)) d d' / d'd is the inverse square root.
    const Vector2d by_depth = by_point * point * (std::sqrt(2.0) / seen.baseline_m * point.z());
    const double square = std::max(by_depth.squaredNorm(), kLeastSquare);
    rows -= by_depth * ((1 - 1 / std::sqrt(1 + square)) / square * (by_depth.transpose() * rows));
    sum.information.noalias() += rows.leftCols<6>().transpose() * rows.leftCols<6>();
    sum.gradient.noalias() += rows.leftCols<6>().transpose() * rows.col(6);
    sum.cost += rows.col(6).squaredNorm();
  }
}

StereoRows linearise_stereo(const StereoCameras& cameras, const Vector3d& point, std::span<const double, 8> seen) {
  StereoRows out{Eigen::Matrix<double, 8, 1>::Zero(), decltype(StereoRows::by_point)::Zero(),
                 decltype(StereoRows::by_motion)::Zero()};
  const auto node = in_nodes(cameras, point);
  for (int k = 0; k < 4; ++k) {
    const Image image = project(k % 2 == 0 ? kSame : cameras.bottom_from_top, node[k / 2]);
    const Vector2d gap = image.xy - at(seen, k);
    if (!is_seen(gap)) continue;
    const Matrix23 by_point = k < 2 ? image.by_point : Matrix23(image.by_point * cameras.motion.turn);
    out.residual.segment<2>(2 * k) = gap;
    out.by_point.middleRows<2>(2 * k) = by_point;
    if (k < 2) continue;  // the first node's residuals do not move
    out.by_motion.block<2, 3>(2 * k, 0) = image.by_point;
    out.by_motion.block<2, 3>(2 * k, 3) = point_cross_rows(point, by_point);
  }
  return out;
}

CalibrationRows linearise_calibration(const StereoCameras& cameras, double field, const Vector3d& point,
                                      std::span<const double, 8> seen) {
  CalibrationRows out = CalibrationRows::Zero();
  const Transform& bottom = cameras.bottom_from_top;
  const Vector3d from_bottom = bottom.turn.transpose() * bottom.shift;
  const auto node = in_nodes(cameras, point);
  for (const int k : {1, 3}) {
    const Image image = project(bottom, node[k / 2]);
    if (!is_seen(image.xy - at(seen, k))) continue;
    out.block<2, 3>(2 * k, 0) = -image.by_point;
    out.block<2, 3>(2 * k, 3) = -point_cross_rows(node[k / 2] + from_bottom, image.by_point);
    const Vector2d along = image.by_point * node[k / 2];  // where a point goes that is nearer or farther
    const Vector2d place = at(seen, k - 1) / field;
    const double x = place.x(), y = place.y();
    Eigen::Matrix<double, 1, 6> shape;
    shape << 1, x, y, x * x, x * y, y * y;
    out.block<2, 6>(2 * k, 6) = along / std::max(along.norm(), kLeastLength) * shape;
  }
  return out;
}

ReducedFeature reduce(const StereoRows& rows) {
  ReducedFeature out;
  const Eigen::Matrix3d own = rows.by_point.transpose() * rows.by_point;
  const double trace = own.trace();  // 0: a point behind every camera has no information
  out.point_inverse = (own + kPointDamping * (trace > 0 ? trace : 1.0) * Eigen::Matrix3d::Identity()).inverse();
  out.point_gradient = rows.by_point.transpose() * rows.residual;
  const Eigen::Matrix<double, 4, 6> there = rows.by_motion.bottomRows<4>();
  out.point_by_motion = there.transpose() * rows.by_point.bottomRows<4>();
  const Eigen::Matrix<double, 6, 3> carried = out.point_by_motion * out.point_inverse;
  out.information = there.transpose() * there - carried * out.point_by_motion.transpose();
  out.gradient = there.transpose() * rows.residual.tail<4>() - carried * out.point_gradient;
  out.cost = rows.residual.squaredNorm() - out.point_gradient.dot(out.point_inverse * out.point_gradient);
  out.freedom = -3;
  for (int k = 0; k < kStereoRows; ++k) out.freedom += (rows.by_point.row(k).array() != 0).any() ? 1 : 0;
  return out;
}

}  // namespace hullrecon
