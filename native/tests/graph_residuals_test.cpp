// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "check.h"
#include "factors/mixture.h"
#include "factors/residuals.h"

using namespace hullrecon;
using twin::Frame;
using twin::V;

namespace {

const Vec3 kTray(0.4, 0.02, 0.1);

std::vector<double> pose_block(std::mt19937& rng) {
  auto x = random_seven(rng, 0.8, 0.4);
  x.push_back(0.2);
  return x;
}

template <class T>
Frame<T> camera(const T* pose, const T* mount, const T* bottom) {
  const auto top = Frame<T>::of(pose) * Frame<T>::tray(kTray, pose[7]) * Frame<T>::of(mount);
  return bottom ? top * Frame<T>::of(bottom) : top;
}

Motion motion(const Frame<double>& f) {
  return Motion(f.t, Quaternion(f.R));
}

// The blocks of a link and its exact measurement.
struct Pair {
  Blocks truth;
  CameraPair link;

  Pair(bool first_bottom, bool second_bottom, std::mt19937& rng)
      : truth{pose_block(rng), pose_block(rng), random_seven(rng, 0.1, 0.3)},
        link{kTray, Motion(Vec3::Zero(), Quaternion::Identity()), first_bottom, second_bottom} {
    if (link.meets_bottom()) truth.push_back(random_seven(rng, 0.2, 0.1));
    std::vector<const double*> x;
    for (const auto& block : truth) x.push_back(block.data());
    link.measured = motion(step(x.data()));
  }
  template <class T>
  Frame<T> step(const T* const* x) const {
    const T* const bottom = link.meets_bottom() ? x[3] : nullptr;
    return camera(x[0], x[2], link.first_bottom ? bottom : nullptr).inverse() *
           camera(x[1], x[2], link.second_bottom ? bottom : nullptr);
  }
  template <class T>
  V<T> turn(const Frame<T>& step) const {
    return twin::log<T>(link.measured.rotation().cast<T>().transpose() * step.R);
  }
};

// pi of a plane n . x = -p moved into frame j, by points: the foot of the origin of j on the plane.
template <class T>
V<T> seen(const T* plane, const Frame<T>& anchor_from_node) {
  const V<T> pi(plane[0], plane[1], plane[2]);
  const T p = sqrt(pi.dot(pi));
  const V<T> n = pi / p, foot = anchor_from_node.t - n * (n.dot(anchor_from_node.t) + p);
  return -(anchor_from_node.inverse() * foot);
}

constexpr std::array<std::pair<bool, bool>, 4> kCameras{{{false, false}, {true, false}, {false, true}, {true, true}}};

}  // namespace

TEST_CASE("a link with length, between all cameras") {
  std::mt19937 rng(21);
  for (const auto& [first, second] : kCameras) {
    const Pair pair(first, second, rng);
    const auto by_twin = [&](const auto* const* x, auto* r) {
      using T = std::decay_t<decltype(x[0][0])>;
      const auto step = pair.step(x);
      const V<T> turn = pair.turn(step);
      for (int k = 0; k < 3; ++k) r[k] = step.t[k] - pair.link.measured.t[k], r[3 + k] = turn[k];
    };
    prove(ScaledLink{pair.link}, by_twin, pair.truth, rng, 0.1);
  }
}

TEST_CASE("a link without length, between all cameras") {
  std::mt19937 rng(22);
  for (const auto& [first, second] : kCameras) {
    const Pair pair(first, second, rng);
    const auto by_twin = [&](const auto* const* x, auto* r) {
      using T = std::decay_t<decltype(x[0][0])>;
      const auto step = pair.step(x);
      const V<T> turn = pair.turn(step), z = pair.link.measured.t.normalized().template cast<T>();
      const V<T> across = z.cross(step.t);
      const T sine = sqrt(across.dot(across)), angle = atan2(sine, z.dot(step.t));
      const V<T> tangent = across.cross(z) * (angle / sine);
      const Eigen::Matrix<T, 2, 1> bearing = bearing_basis(pair.link.measured.t).template cast<T>().transpose() * tangent;
      for (int k = 0; k < 5; ++k) r[k] = k < 2 ? bearing[k] : turn[k - 2];
    };
    prove(BearingLink{pair.link}, by_twin, pair.truth, rng, 0.1);
  }
}

TEST_CASE("the derivative of a bearing holds from nearly none to nearly a half turn") {
  const std::vector<double> level{0, 0, 0, 0, 0, 0, 1};
  for (double angle : {1e-9, 1e-5, 2.9e-3, 3.1e-3, 0.5, 1.5, 1.7, 3.0, 3.138}) {
    std::vector<double> first = level, second{2 * std::cos(angle), 2 * std::sin(angle), 0, 0, 0, 0, 1};
    first.push_back(0), second.push_back(0);
    const BearingLink link{{Vec3::Zero(), Motion(Vec3::UnitX(), Quaternion::Identity()), false, false}};
    Eigen::VectorXd r;
    const Matrix J = analytic(link, {first, second, level}, r);
    CHECK(r.head<2>().norm() == doctest::Approx(angle));
    // along the circle the angle grows by one over the radius, towards the camera not at all
    const Vec3 around(-std::sin(angle), std::cos(angle), 0);
    const Eigen::VectorXd by_around = J.block<2, 3>(0, 7) * around,
                          inward = J.block<2, 3>(0, 7) * Vec3(around[1], -around[0], 0);
    CHECK(by_around.norm() == doctest::Approx(0.5).epsilon(1e-7));
    CHECK(inward.norm() < 1e-7);
  }
}

TEST_CASE("the axes of a bearing are across it and of one turn, whatever the direction") {
  std::mt19937 rng(23);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 z = trial < 3 ? Vec3(Vec3::Unit(trial)) : Vec3(normal(rng), normal(rng), normal(rng));
    const Eigen::Matrix<double, 3, 2> b = bearing_basis(3 * z);
    CHECK((b.transpose() * b - Eigen::Matrix2d::Identity()).norm() < 1e-14);
    CHECK((b.transpose() * z).norm() < 1e-14 * (1 + z.norm()));
    CHECK(b.col(0).cross(b.col(1)).dot(z) > 0);
  }
}

TEST_CASE("a link behind a switch") {
  std::mt19937 rng(24);
  Pair pair(true, false, rng);
  pair.truth.push_back({1.0});
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const auto step = pair.step(x);
    const V<T> turn = pair.turn(step);
    for (int k = 0; k < 6; ++k) r[k] = x[4][0] * (k < 3 ? T(step.t[k] - pair.link.measured.t[k]) : turn[k - 3]);
    r[6] = x[4][0] - 1.0;
  };
  prove(SwitchedLink<ScaledLink>{{pair.link}}, by_twin, pair.truth, rng, 0.1);
}

TEST_CASE("the loss of links is the integral of the weight that dynamic covariance scaling gives") {
  const ScalingLoss loss(5.0);
  double rho, slope, before = 0, sum = 0;
  for (double u = 0; u < 60; u += 1e-3) {
    loss(u + 5e-4, rho, slope);
    const double s = std::min(1.0, 10 / (5 + u + 5e-4));
    CHECK(slope == doctest::Approx(s * s));
    sum += 1e-3 * s * s;
    loss(u + 1e-3, rho, slope);
    CHECK(rho == doctest::Approx(sum).epsilon(1e-5));
    CHECK(rho > before);
    before = rho;
  }
  loss(1e12, rho, slope);
  CHECK(rho == doctest::Approx(15));
}

TEST_CASE("a plane seen from a pose") {
  std::mt19937 rng(25);
  Blocks truth{{-1.2, 0.3, 0.4}, pose_block(rng), pose_block(rng)};
  PlaneSighting residual{Vec3::Zero(), false};
  residual.measured = value(residual, truth);
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const V<T> pi = seen(x[0], Frame<T>::of(x[2]).inverse() * Frame<T>::of(x[1]));
    for (int k = 0; k < 3; ++k) r[k] = pi[k] - residual.measured[k];
  };
  prove(residual, by_twin, truth, rng);
  const PlaneSighting own{Vec3(-1.2, 0.3, 0.4), true};
  prove(
      own,
      [&](const auto* const* x, auto* r) {
        for (int k = 0; k < 3; ++k) r[k] = x[0][k] - own.measured[k];
      },
      {truth[0]}, rng);
}

TEST_CASE("two planes of one surface") {
  std::mt19937 rng(26);
  Blocks truth{{-1.2, 0.3, 0.4}, {-1.0, 0.2, 0.5}, pose_block(rng), pose_block(rng)};
  Mat3 by_place;
  by_place << 0.3, -0.1, 0.05, 0.2, 0.4, -0.2, -0.1, 0.15, 0.25;
  PlanePair residual{Vec3::Zero(), Vec3(1.1, -0.3, 0.2), Vec3(0.9, 0.4, -0.1), by_place, false};
  residual.measured = value(residual, truth);
  const auto by_twin = [&](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const V<T> pi = seen(x[1], Frame<T>::of(x[3]).inverse() * Frame<T>::of(x[2]));
    const V<T> y = (Frame<T>::of(x[2]).inverse() * Frame<T>::of(x[3])) * V<T>(residual.point.cast<T>());
    const V<T> moved = residual.by_place.cast<T>() * V<T>(y - residual.place.cast<T>());
    for (int k = 0; k < 3; ++k) r[k] = pi[k] - x[0][k] - residual.measured[k] - moved[k];
  };
  prove(residual, by_twin, truth, rng);
  PlanePair one{Vec3::Zero(), Vec3(1, 2, 3), Vec3(3, 2, 1), by_place, true};
  one.measured = value(one, {truth[0], truth[1]});
  prove(
      one,
      [&](const auto* const* x, auto* r) {
        for (int k = 0; k < 3; ++k) r[k] = x[1][k] - x[0][k] - one.measured[k] - (by_place * (one.point - one.place))[k];
      },
      {truth[0], truth[1]}, rng);
}

TEST_CASE("the range of a beam to a plane, from its anchor and from elsewhere") {
  std::mt19937 rng(27);
  const auto ping = random_seven(rng, 0.05, 0.05);
  for (bool at_anchor : {true, false}) {
    Blocks truth{{-2.2, 0.3, -0.4}, pose_block(rng), random_seven(rng, 0.1, 0.3)};
    if (!at_anchor) truth.push_back(truth[1]), truth[3][0] += 0.3, truth[3][1] -= 0.2;
    PlaneRange residual{Motion(ping.data()), 0.02, Vec3(0.9, 0.2, 0.3).normalized(), kTray, 0.0, at_anchor};
    residual.measured = value(residual, truth)[0];
    CHECK(residual.measured > 0.5);
    const auto by_twin = [&](const auto* const* x, auto* r) {
      using T = std::decay_t<decltype(x[0][0])>;
      const auto beam = twin::lift<T>(ping) * Frame<T>::tray(kTray, x[1][7] + 0.02) * Frame<T>::of(x[2]);
      const auto in_anchor = at_anchor ? beam : Frame<T>::of(x[3]).inverse() * Frame<T>::of(x[1]) * beam;
      // pi . (o + l d) = -|pi|^2
      const V<T> pi(x[0][0], x[0][1], x[0][2]), along = in_anchor.R * residual.beam.cast<T>();
      r[0] = -(pi.dot(pi) + pi.dot(in_anchor.t)) / pi.dot(along) - residual.measured;
    };
    prove(residual, by_twin, truth, rng, 0.02);
  }
}

TEST_CASE("a plane through its anchor and a beam along a plane are refused") {
  const std::vector<double> none{0, 0, 0}, level{0, 0, 0, 0, 0, 0, 1, 0}, mount{0, 0, 0, 0, 0, 0, 1}, ahead{-1, 0, 0};
  const Motion still(Vec3::Zero(), Quaternion::Identity());
  double r[3];
  const double* at_none[] = {none.data(), level.data(), mount.data()};
  CHECK_FALSE(PlaneSighting{Vec3::Zero(), true}(at_none, r, nullptr));
  CHECK_FALSE(PlaneRange{still, 0, Vec3::UnitX(), kTray, 1, true}(at_none, r, nullptr));
  const double* at_ahead[] = {ahead.data(), level.data(), mount.data()};
  CHECK_FALSE(PlaneRange{still, 0, Vec3::UnitY(), kTray, 1, true}(at_ahead, r, nullptr));
  CHECK(PlaneRange{still, 0, Vec3::UnitX(), Vec3::Zero(), 1, true}(at_ahead, r, nullptr));
  CHECK(r[0] == doctest::Approx(0));
}

TEST_CASE("constant velocity over three poses") {
  std::mt19937 rng(28);
  const auto step = random_seven(rng, 0.5, 0.2);
  const Frame<double> start = Frame<double>::of(pose_block(rng).data()), by = Frame<double>::of(step.data());
  // the second step turns as the first, scaled by the time; its translation goes on straight in the axes of the middle
  const Vec3 w = twin::log<double>(by.R);
  Frame<double> middle = start * by, end = middle * Frame<double>{Eigen::AngleAxisd(1.5 * w.norm(), w.normalized()).matrix(),
                                                                  1.5 * (by.R.transpose() * by.t)};
  const auto block = [](const Frame<double>& f) {
    const Eigen::Quaterniond q(f.R);
    return std::vector<double>{f.t[0], f.t[1], f.t[2], q.x(), q.y(), q.z(), q.w(), 0.1};
  };
  const auto by_twin = [](const auto* const* x, auto* r) {
    using T = std::decay_t<decltype(x[0][0])>;
    const auto i = Frame<T>::of(x[0]), j = Frame<T>::of(x[1]), k = Frame<T>::of(x[2]);
    const V<T> came = j.R.transpose() * (j.t - i.t), goes = j.R.transpose() * (k.t - j.t);
    const V<T> turned = twin::log<T>(i.R.transpose() * j.R), turns = twin::log<T>(j.R.transpose() * k.R);
    for (int n = 0; n < 3; ++n) r[n] = goes[n] / 3.0 - came[n] / 2.0, r[3 + n] = turns[n] / 3.0 - turned[n] / 2.0;
  };
  prove(Velocity{2.0, 3.0}, by_twin, {block(start), block(middle), block(end)}, rng, 0.1);
}
