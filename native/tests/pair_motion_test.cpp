// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/pair_motion.h"

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <vector>

#include "expect.h"

using namespace hullrecon;

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
const Transform kMotion{Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix(), {0.2, -0.05, 0.03}};
const Transform kBottom{Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0.0, -0.1, 0.0}};

std::array<double, 8> seen_of(const StereoCameras& cameras, const Eigen::Vector3d& point) {
  std::array<double, 8> out;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d at = k < 2 ? point : Eigen::Vector3d(cameras.motion.turn * point + cameras.motion.shift);
    const Eigen::Vector3d in =
        k % 2 == 0 ? at : Eigen::Vector3d(cameras.bottom_from_top.turn * at + cameras.bottom_from_top.shift);
    out[2 * k] = in.x() / in.z(), out[2 * k + 1] = in.y() / in.z();
  }
  return out;
}

}  // namespace

TEST_CASE("a feature at its place has no residual, and a camera that missed it no rows") {
  const StereoCameras cameras{kMotion, kBottom};
  const Eigen::Vector3d point(0.2, -0.1, 1.4);
  auto seen = seen_of(cameras, point);
  CHECK(linearise_stereo(cameras, point, seen).residual.norm() < 1e-15);
  seen[2] = seen[3] = kNone;
  const StereoRows rows = linearise_stereo(cameras, point, seen);
  CHECK(rows.by_point.middleRows<2>(2).isZero(0));
  CHECK(linearise_calibration(cameras, 0.5, point, seen).middleRows<2>(2).isZero(0));
  CHECK(reduce(rows).freedom == 3);
}

TEST_CASE("a point behind every camera leaves finite numbers that say nothing") {
  const StereoCameras cameras{kMotion, kBottom};
  const auto seen = seen_of(cameras, {0.2, -0.1, 1.4});
  const ReducedFeature out = reduce(linearise_stereo(cameras, {0.2, -0.1, -9.0}, seen));
  CHECK(out.freedom == -3);
  CHECK(out.information.isZero(0));
  CHECK(out.point_inverse.allFinite());
  CHECK(linearise_calibration(cameras, 0.5, {0.2, -0.1, -9.0}, seen).isZero(0));
}

TEST_CASE("squared reprojections are inf behind the camera and nothing where not seen") {
  const std::vector<double> point{0, 0, 2, 0, 0, -2, 0, 0, 2}, xy{0.03, -0.04, 0, 0, kNone, kNone};
  std::vector<double> squared(3);
  squared_reprojections({Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()}, point, xy, squared);
  CHECK(squared[0] == doctest::Approx(0.0025));
  CHECK(squared[1] == std::numeric_limits<double>::infinity());
  CHECK(squared[2] == 0);
}

TEST_CASE("only the points that count are added") {
  const std::vector<double> point{0.2, -0.1, 1.4, 0.1, 0.3, 1.2}, xy{0.1, 0.1, kNone, kNone};
  const bool first[] = {true, false}, none[] = {false, false};
  MotionNormal sum;
  add_reprojections(kMotion, {point, xy, kBottom, false, 0.1}, none, sum);
  CHECK(sum.cost == 0);
  add_reprojections(kMotion, {point, xy, kBottom, true, 0.1}, first, sum);
  CHECK(sum.cost > 0);
  CHECK(sum.information.allFinite());
}
