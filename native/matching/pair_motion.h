// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Information of the features that two nodes share on the motion between the nodes: second_from_first of their leading cameras,
// perturbed by (translation in second's axes, rotation vector on the right). Images are in ideal coordinates, NaN where a
// camera did not see the feature; points are metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace hullrecon {

struct Transform {  // moves a point from one frame into another: turn x + shift
  Eigen::Matrix3d turn;
  Eigen::Vector3d shift;
};

// Triangulated points of one node, and where a camera of the other node saw them.
struct SeenPoints {
  std::span<const double> point;  // three a point
  std::span<const double> xy;     // two a point
  Transform camera_from_node;     // the camera in the frame that the points are moved into
  bool backward;                  // the motion wanted carries these points with its inverse
  double baseline_m;              // of the rig that triangulated the points, for their uncertainty in depth
};

struct MotionNormal {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double cost = 0;
};

// Squared distances in the image of points (three each) as a camera sees them from where they saw it (two each): inf behind the
// camera, 0 where not seen.
void squared_reprojections(const Transform& camera_from_point, std::span<const double> point, std::span<const double> xy,
                           std::span<double> squared);

// Adds the normal equations of the motion by the points that `counts` selects, residuals whitened by an image's error and the
// point's depth, z^2 sqrt(2) / b for each unit of error in the image.
void add_reprojections(const Transform& motion, const SeenPoints& seen, std::span<const bool> counts, MotionNormal& sum);

// A feature of two stereo nodes: where the leading and the bottom camera of the first node saw it, then those of the second,
// two numbers each.
constexpr int kStereoRows = 8;
constexpr int kCalibration = 12;  // unknowns: of the rig (translation, rotation vector of T_ct_cb), of the disparity's field

struct StereoCameras {
  Transform motion, bottom_from_top;
};

// Residuals of a feature with their derivatives by its point in the first leading camera and by the motion; rows that were not
// seen are zero.
struct StereoRows {
  Eigen::Matrix<double, kStereoRows, 1> residual;
  Eigen::Matrix<double, kStereoRows, 3, Eigen::RowMajor> by_point;
  Eigen::Matrix<double, kStereoRows, 6, Eigen::RowMajor> by_motion;
};
using CalibrationRows = Eigen::Matrix<double, kStereoRows, kCalibration, Eigen::RowMajor>;

StereoRows linearise_stereo(const StereoCameras& cameras, const Eigen::Vector3d& point, std::span<const double, 8> seen);
// Derivatives of the residuals of StereoRows by the calibration. The disparity's error is a polynomial of 1, x, y, x2, xy, y2,
// (x, y) the feature in the leading image divided by `field`, ideal units.
CalibrationRows linearise_calibration(const StereoCameras& cameras, double field, const Eigen::Vector3d& point,
                                      std::span<const double, 8> seen);

// The normal equations of the motion with the point eliminated. freedom: the feature's redundancy, rows that were seen less
// the point's three numbers; cost: that of the point which suits the motion best. A step s of the motion moves this point by
// -point_inverse (point_gradient + point_by_motion' s).
struct ReducedFeature {
  Eigen::Matrix<double, 6, 6> information;
  Eigen::Matrix<double, 6, 1> gradient;
  double cost;
  int64_t freedom;
  Eigen::Matrix3d point_inverse;
  Eigen::Vector3d point_gradient;
  Eigen::Matrix<double, 6, 3, Eigen::RowMajor> point_by_motion;
};

ReducedFeature reduce(const StereoRows& rows);

}  // namespace hullrecon
