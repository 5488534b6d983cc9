// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "factors/residuals.h"

#include "check.h"

using namespace hullrecon;
using twin::Frame;
using twin::V;

namespace {

const Vec3 kTray(0.4, 0.02, 0.1);
const std::vector<double> kTop{500, 510, 320, 240, -0.05, 0.01, 0.001, -0.002, 0.003};
const std::vector<double> kBottom{490, 505, 322, 238, 0.03, -0.02, -0.001, 0.001, 0.002};

std::vector<double> pose_block(std::mt19937& rng) {
  auto x = random_seven(rng, 0.5, 0.4);
  x.push_back(0.2);
  return x;
}

// A landmark some 1.5 m before the top camera, the blocks of a stereo factor.
Blocks camera_blocks(std::mt19937& rng) {
  const auto pose = pose_block(rng), mount = random_seven(rng, 0.05, 0.1);
  const auto to_global = Frame<double>::of(pose.data()) * Frame<double>::tray(kTray, pose[7]) * Frame<double>::of(mount.data());
  const Vec3 landmark = to_global * V<double>(0.2, -0.1, 1.5);
  return {{landmark[0], landmark[1], landmark[2]}, pose, mount, random_seven(rng, 0.05, 0.01), kTop, kBottom};
}

template <class T>
V<T> in_top(const T* const* x) {
  const V<T> landmark(x[0][0], x[0][1], x[0][2]);
  return (Frame<T>::of(x[1]) * Frame<T>::tray(kTray, x[1][7]) * Frame<T>::of(x[2])).inverse() * landmark;
}

}  // namespace

TEST_CASE("the prior of a pose and of a motion") {
  std::mt19937 rng(1);
  for (bool pose : {true, false}) {
    const auto prior = random_seven(rng, 1, 0.6);
    const auto by_twin = [&](const auto* const* x, auto* r) {
      using T = std::decay_t<decltype(x[0][0])>;
      const auto d = twin::lift<T>(prior).inverse() * Frame<T>::of(x[0]);
      const V<T> w = twin::log(d.R);
      for (int k = 0; k < 3; ++k) r[k] = d.t[k], r[3 + k] = w[k];
    };
    auto x = prior;
    if (pose) x.push_back(0.1);
    if (pose) {
      // the tray angle is no part of it, so its column is nothing
      prove(MotionPrior<8>{Motion(prior.data())}, by_twin, {x}, rng, 0.3);
    } else {
      prove(MotionPrior<7>{Motion(prior.data())}, by_twin, {x}, rng, 0.3);
    }
  }
}

TEST_CASE("depth, roll and pitch") {
  std::mt19937 rng(2);
  const Vec3 sensor(0.1, 0.2, -0.3);
  const Blocks truth{pose_block(rng), {0.1, 0.2, 0.03, -0.02, 0.05, 0.1}};
  Attitude residual{sensor, Vec3::Zero()};
  residual.measured = value(residual, truth);
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const auto pose = Frame<T>::of(x[0]);
    r[0] = (pose * V<T>(sensor.cast<T>()))[2] + x[1][4] - residual.measured[0];
    r[1] = atan2(pose.R(2, 1), pose.R(2, 2)) + x[1][2] - residual.measured[1];
    r[2] = -asin(pose.R(2, 0)) + x[1][3] - residual.measured[2];
  };
  prove(residual, by_twin, truth, rng);
}

TEST_CASE("roll across the half turn is a small difference") {
  const std::vector<double> on_its_back{0, 0, 0, std::sin(0.5 * 3.14), 0, 0, std::cos(0.5 * 3.14), 0};
  const Attitude residual{Vec3::Zero(), {0, -3.14, 0}};
  CHECK(value(residual, {on_its_back, {0, 0, 0, 0, 0, 0}})[1] == doctest::Approx(6.28 - 2 * M_PI));
}

TEST_CASE("a bow that points straight down has no roll, and the point is refused") {
  const std::vector<double> down{0, 0, 0, 0, std::sqrt(0.5), 0, std::sqrt(0.5), 0}, zero(6, 0.0);
  const double* x[] = {down.data(), zero.data()};
  double r[3];
  CHECK_FALSE(Attitude{Vec3::Zero(), Vec3::Zero()}(x, r, nullptr));
}

TEST_CASE("a position from outside") {
  std::mt19937 rng(10);
  const Vec3 antenna(-0.3, 0.15, -0.25);
  const Blocks truth{pose_block(rng), {120.0, -45.0, 2.2}};
  Position residual{antenna, Eigen::Vector2d::Zero()};
  residual.measured = value(residual, truth);
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const V<T> at = Frame<T>::of(x[0]) * V<T>(antenna.cast<T>());
    r[0] = cos(x[1][2]) * at[0] - sin(x[1][2]) * at[1] + x[1][0] - residual.measured[0];
    r[1] = sin(x[1][2]) * at[0] + cos(x[1][2]) * at[1] + x[1][1] - residual.measured[1];
  };
  prove(residual, by_twin, truth, rng);
}

TEST_CASE("a vehicle that goes ahead on the heading of east is found farther east") {
  const std::vector<double> ahead{3, 0, 1, 0, 0, 0, 1, 0}, east{10, 20, 0.5 * M_PI};
  const Eigen::VectorXd r = value(Position{Vec3(0.5, 0, 0), Eigen::Vector2d(10, 20)}, {ahead, east});
  CHECK(r[0] == doctest::Approx(0).epsilon(1e-12));
  CHECK(r[1] == doctest::Approx(3.5));
}

TEST_CASE("the tray's angle and backlash") {
  std::mt19937 rng(3);
  const Blocks truth{pose_block(rng), {0, 0, 0, 0, 0, 0.01}};
  const Tray residual{0.2 - 0.01, -1.0};
  prove(residual, [](const auto* const* x, auto* r) { r[0] = x[0][7] - x[1][5] - 0.19; }, truth, rng);
}

TEST_CASE("odometry with its systematic part") {
  std::mt19937 rng(4);
  const auto mount = random_seven(rng, 0.1, 0.5);
  const Blocks truth{pose_block(rng), pose_block(rng), {0, 0, 0, 0, 0, 0}, mount};
  const auto z = Frame<double>::of(truth[0].data()).inverse() * Frame<double>::of(truth[1].data());
  const Eigen::Quaterniond q(z.R);
  const std::vector<double> measured{z.t[0], z.t[1], z.t[2], q.x(), q.y(), q.z(), q.w()};
  Odometry residual{Motion(measured.data()), {}, {}, {}, 0.2, Motion(mount.data()).q};
  residual.by_navigation.setRandom(), residual.by_mount.setRandom(), residual.by_tray.setRandom();
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const auto step = Frame<T>::of(x[0]).inverse() * Frame<T>::of(x[1]), reference = twin::lift<T>(measured);
    const V<T> turn = twin::log<T>(reference.R.transpose() * step.R);
    const V<T> tilt = twin::log<T>(twin::lift<T>(mount).R.transpose() * Frame<T>::of(x[3]).R);
    const T theta = (x[0][7] + x[1][7]) * 0.5 - 0.2;
    for (int k = 0; k < 6; ++k) {
      r[k] = k < 3 ? T(step.t[k] - reference.t[k]) : turn[k - 3];
      r[k] -= x[2][0] * residual.by_navigation(k, 0) + x[2][1] * residual.by_navigation(k, 1) + theta * residual.by_tray[k];
      for (int m = 0; m < 3; ++m) r[k] -= tilt[m] * residual.by_mount(k, m);
    }
  };
  prove(residual, by_twin, truth, rng, 0.2);
}

TEST_CASE("stereo through the whole chain") {
  std::mt19937 rng(5);
  const Blocks truth = camera_blocks(rng);
  Stereo residual{kTray, Eigen::Vector4d::Zero()};
  residual.measured = value(residual, truth);
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const V<T> top = in_top(x), bottom = Frame<T>::of(x[3]).inverse() * top;
    twin::pixel(x[4], top, r);
    twin::pixel(x[5], bottom, r + 2);
    for (int k = 0; k < 4; ++k) r[k] -= residual.measured[k];
  };
  prove(residual, by_twin, truth, rng, 0.01);
}

TEST_CASE("one camera, top or bottom") {
  std::mt19937 rng(6);
  for (bool bottom : {false, true}) {
    const Blocks all = camera_blocks(rng);
    Blocks truth{all[0], all[1], all[2], bottom ? all[5] : all[4]};
    if (bottom) truth.push_back(all[3]);
    Mono residual{kTray, Eigen::Vector2d::Zero(), bottom};
    residual.measured = value(residual, truth);
    const auto by_twin = [&](const auto* const* x, auto* r) {
      using T = std::decay_t<decltype(x[0][0])>;
      const V<T> top = in_top(x);
      twin::pixel(x[3], bottom ? V<T>(Frame<T>::of(x[4]).inverse() * top) : top, r);
      for (int k = 0; k < 2; ++k) r[k] -= residual.measured[k];
    };
    prove(residual, by_twin, truth, rng, 0.01);
  }
}

TEST_CASE("a point behind the camera is a large constant without derivative") {
  std::mt19937 rng(7);
  Blocks x = camera_blocks(rng);
  for (int k = 0; k < 3; ++k) x[0][k] += 2 * (x[1][k] - x[0][k]);  // to the other side of the vehicle
  Eigen::VectorXd r;
  CHECK(analytic(Stereo{kTray, Eigen::Vector4d::Zero()}, x, r).norm() == 0.0);
  CHECK((r.array() == kBehindPixels).all());
  CHECK(analytic(Mono{kTray, Eigen::Vector2d::Zero(), false}, {x[0], x[1], x[2], x[4]}, r).norm() == 0.0);
  CHECK((r.array() == kBehindPixels).all());
}

TEST_CASE("the range of a beam to a plane, with the field") {
  std::mt19937 rng(8);
  const bool refused = false;
  const Facet facet{Vec3(0.1, -0.2, -0.97).normalized(), 2.0, true};
  Blocks truth{pose_block(rng), random_seven(rng, 0.1, 0.1), random_seven(rng, 0.1, 0.3), {0.02}, {-0.01}};
  const auto ping = random_seven(rng, 0.05, 0.05);
  const std::vector<double> weights{0.3, 0.6};
  Range residual{Motion(ping.data()), 0.02, Vec3(0.3, 0.2, 0.9).normalized(), kTray, 0.0, {weights}, &facet, &refused};
  residual.measured = value(residual, truth)[0];
  CHECK(residual.measured > 0.5);
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const auto instrument = Frame<T>::of(x[1]).inverse() * Frame<T>::of(x[0]) * twin::lift<T>(ping) *
                            Frame<T>::tray(kTray, x[0][7] + 0.02) * Frame<T>::of(x[2]);
    const V<T> n = facet.normal.cast<T>(), along = instrument.R * residual.beam.cast<T>();
    const T slope = n.dot(along), field = x[3][0] * 0.3 + x[4][0] * 0.6;
    r[0] = (-n.dot(instrument.t) - facet.offset + field) / slope - residual.measured;
  };
  prove(residual, by_twin, truth, rng);
}

TEST_CASE("a beam that misses has no residual and no derivative; a refused point is refused") {
  std::mt19937 rng(9);
  bool refused = false;
  const Facet missed;
  const Blocks x{pose_block(rng), random_seven(rng, 0.1, 0.1), random_seven(rng, 0.1, 0.3), {0.02}};
  const Motion still(Vec3::Zero(), Quaternion::Identity());
  const std::vector<double> one{1.0};
  const Range residual{still, 0.0, Vec3::UnitZ(), kTray, 3.0, {one}, &missed, &refused};
  Eigen::VectorXd r;
  CHECK(analytic(residual, x, r).norm() == 0.0);
  CHECK(r[0] == 0.0);
  refused = true;
  const double* at[] = {x[0].data(), x[1].data(), x[2].data(), x[3].data()};
  CHECK_FALSE(residual(at, r.data(), nullptr));
}

TEST_CASE("the signed distance of a landmark, less the field") {
  std::mt19937 rng(10);
  const Facet facet{Vec3(0.3, -0.5, 0.8).normalized(), -0.4, true};
  Blocks truth{{0.5, -0.2, 1.0}, random_seven(rng, 0.3, 0.5), {0.0}, {0.5}};
  const std::vector<double> weights{0.4, 0.25};
  Surface residual{{weights}, &facet};
  truth[2][0] = value(residual, truth)[0] / 0.4;
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const V<T> in_hull = Frame<T>::of(x[1]).inverse() * V<T>(x[0][0], x[0][1], x[0][2]);
    r[0] = V<T>(facet.normal.cast<T>()).dot(in_hull) + facet.offset - x[2][0] * 0.4 - x[3][0] * 0.25;
  };
  prove(residual, by_twin, truth, rng, 0.2);
}

TEST_CASE("priors on plain numbers and on the field") {
  std::mt19937 rng(11);
  prove(
      VectorPrior<6>{{1, 2, 3, 4, 5, 6}},
      [](const auto* const* x, auto* r) {
        for (int k = 0; k < 6; ++k) r[k] = x[0][k] - (k + 1.0);
      },
      {{1, 2, 3, 4, 5, 6}}, rng);
  const std::vector<double> weights{2.0, -1.0, 0.5};
  prove(
      FieldPrior{{weights}}, [](const auto* const* x, auto* r) { r[0] = x[0][0] * 2.0 - x[1][0] + x[2][0] * 0.5; },
      {{1.0}, {3.0}, {2.0}}, rng);
}
