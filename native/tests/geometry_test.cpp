// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Motions, manifolds, cameras.
#include <random>

#include "factors/camera.h"
#include "factors/manifolds.h"
#include "factors/residual.h"

#include "expect.h"

using namespace hullrecon;

namespace {

const double kPlumbBob[9] = {500, 400, 320, 240, -0.3, 0.12, 0.004, -0.003, 0.02};

double number(std::mt19937& rng) {
  return std::normal_distribution<double>()(rng);
}
Vec3 vector(std::mt19937& rng, double scale) {
  return scale * Vec3(number(rng), number(rng), number(rng));
}

}  // namespace

TEST_CASE("hat is the cross product's matrix") {
  std::mt19937 rng(1);
  for (int k = 0; k < 5; ++k) {
    const Vec3 a = vector(rng, 1), b = vector(rng, 1);
    CHECK((hat(a) * b - a.cross(b)).norm() < 1e-15);
  }
}

TEST_CASE("the exponential turns about its axis by its length, also by next to nothing and by whole turns") {
  for (double angle : {0.0, 1e-12, 1e-8, 1e-3, 1.0, M_PI, 4.0, 2 * M_PI, 7.0}) {
    const Vec3 axis = Vec3(1, -2, 2) / 3;
    const Mat3 expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    CHECK((exp(angle * axis).toRotationMatrix() - expected).norm() < 1e-14);
    CHECK(exp(angle * axis).norm() == doctest::Approx(1).epsilon(1e-15));
  }
}

TEST_CASE("the logarithm is the shorter turn, of either sign of the quaternion") {
  for (double angle : {0.0, 1e-10, 0.5, 3.0, M_PI - 1e-9, 3.5, 6.0}) {
    const Vec3 axis = Vec3(2, 1, -2) / 3;
    const Quaternion q = exp(angle * axis);
    const double shorter = angle <= M_PI ? angle : angle - 2 * M_PI;
    CHECK((log(q) - shorter * axis).norm() < 1e-8);
    CHECK((log(Quaternion(-q.w(), -q.x(), -q.y(), -q.z())) - shorter * axis).norm() < 1e-8);
  }
}

TEST_CASE("a motion and its inverse, also of a quaternion that is not quite of unit length") {
  std::mt19937 rng(2);
  const double seven[7] = {1, 2, 3, 0.1 * 1.0004, -0.3 * 1.0004, 0.2 * 1.0004, 0.9273618495495703 * 1.0004};
  const Motion motion(seven);
  CHECK(motion.q.norm() == doctest::Approx(1).epsilon(1e-15));
  for (int k = 0; k < 5; ++k) {
    const Vec3 p = vector(rng, 2);
    CHECK((motion.to_child(motion.apply(p)) - p).norm() < 1e-14);
    CHECK((motion.apply(p) - (motion.rotation() * p + Vec3(1, 2, 3))).norm() < 1e-14);
  }
}

TEST_CASE("a turn about y and its derivative") {
  std::mt19937 rng(3);
  const Vec3 p = vector(rng, 1);
  constexpr double h = 1e-6;
  for (double angle : {-1.0, 0.0, 0.4}) {
    const Vec3 slope = (rotation_y(angle + h) * p - rotation_y(angle - h) * p) / (2 * h);
    CHECK((slope - rotation_y(angle) * turn_y(p)).norm() < 1e-9);
  }
  CHECK((rotation_y(M_PI / 2) * Vec3(0, 0, 1) - Vec3(1, 0, 0)).norm() < 1e-15);
}

TEST_CASE("on every manifold plus has the derivative that it tells, and minus is its inverse") {
  std::mt19937 rng(4);
  const auto prove = [&](const ceres::Manifold& m, bool tray_held) {
    const int n = m.AmbientSize(), d = m.TangentSize();
    std::vector<double> x(n), delta(d), moved(n), back(d), jacobian(n * d), inverse(d * n);
    for (int trial = 0; trial < 4; ++trial) {
      for (double& v : x) v = number(rng);
      Eigen::Map<Eigen::Vector4d>(x.data() + 3).normalize();
      for (double& v : delta) v = 0.3 * number(rng);
      REQUIRE(m.Plus(x.data(), delta.data(), moved.data()));
      CHECK(Eigen::Map<Eigen::Vector4d>(moved.data() + 3).norm() == doctest::Approx(1).epsilon(1e-15));
      REQUIRE(m.Minus(moved.data(), x.data(), back.data()));
      for (int k = 0; k < d; ++k) CHECK(back[k] == doctest::Approx(delta[k]).epsilon(1e-12));
      if (tray_held) CHECK(moved[7] == x[7]);
      REQUIRE(m.PlusJacobian(x.data(), jacobian.data()));
      REQUIRE(m.MinusJacobian(x.data(), inverse.data()));
      for (int r = 0; r < n; ++r) {
        for (int c = 0; c < d; ++c) CHECK((jacobian[r * d + c] == (r == c) && inverse[c * n + r] == (r == c)));
      }
      const std::vector<double> nothing(d, 0.0);
      m.Plus(x.data(), nothing.data(), moved.data());
      for (int k = 0; k < n; ++k) CHECK(moved[k] == doctest::Approx(x[k]).epsilon(1e-15));
    }
  };
  prove(PoseManifold(), false), prove(PoseTrayHeldManifold(), true), prove(RigidManifold(), false);
}

TEST_CASE("a step moves by translation in the parent and rotation in the child") {
  const double x[8] = {1, 2, 3, 0, 0, std::sqrt(0.5), std::sqrt(0.5), 0.3};  // heading to y
  const double delta[7] = {0.1, 0, 0, 0.2, 0, 0, 0.05};
  double moved[8];
  PoseManifold().Plus(x, delta, moved);
  CHECK(moved[0] == doctest::Approx(1.1));
  CHECK(moved[7] == doctest::Approx(0.35));
  const Mat3 expected = (Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()) * Eigen::AngleAxisd(0.2, Vec3::UnitX())).toRotationMatrix();
  CHECK((Motion(moved).rotation() - expected).norm() < 1e-15);
}

TEST_CASE("without distortion a pixel is f x / z + c") {
  const double k[9] = {500, 400, 320, 240, 0, 0, 0, 0, 0};
  Projection p;
  REQUIRE(project(k, {0.2, -0.1, 2}, true, p));
  CHECK((p.pixel - Eigen::Vector2d(370, 220)).norm() < 1e-12);
  Eigen::Matrix<double, 2, 3> expected;
  expected << 250, 0, -25, 0, 200, 10;
  CHECK((p.by_point - expected).norm() < 1e-12);
}

TEST_CASE("distortion by hand") {
  Projection p;
  REQUIRE(project(kPlumbBob, {1, 2, 10}, false, p));
  const double x = 0.1, y = 0.2, r2 = 0.05, radial = 1 - 0.3 * r2 + 0.12 * r2 * r2 + 0.02 * r2 * r2 * r2;
  const double u = x * radial + 2 * 0.004 * x * y - 0.003 * (r2 + 2 * x * x);
  const double v = y * radial + 0.004 * (r2 + 2 * y * y) - 2 * 0.003 * x * y;
  CHECK((p.pixel - Eigen::Vector2d(500 * u + 320, 400 * v + 240)).norm() < 1e-12);
}

TEST_CASE("derivatives by point and by intrinsics equal numeric ones") {
  std::mt19937 rng(5);
  for (int trial = 0; trial < 10; ++trial) {
    const Vec3 at = Vec3(0, 0, 2) + vector(rng, 0.4);
    std::vector<double> k(kPlumbBob, kPlumbBob + 9);
    Projection p, there, back;
    REQUIRE(project(k.data(), at, true, p));
    for (int c = 0; c < 3; ++c) {
      const Vec3 step = 1e-5 * Vec3::Unit(c);
      project(k.data(), at + step, false, there), project(k.data(), at - step, false, back);
      CHECK(((there.pixel - back.pixel) / 2e-5 - p.by_point.col(c)).norm() < 1e-5);
    }
    const auto by = by_intrinsics(k.data(), at);
    for (int c = 0; c < 9; ++c) {
      const double known = k[c], h = c < 4 ? 1e-2 : 1e-5;
      k[c] = known + h, project(k.data(), at, false, there);
      k[c] = known - h, project(k.data(), at, false, back);
      k[c] = known;
      CHECK(((there.pixel - back.pixel) / (2 * h) - by.col(c)).norm() < 1e-6 * (1 + by.col(c).norm()));
    }
  }
}

TEST_CASE("a point that is not in front has no pixel") {
  Projection p;
  for (double z : {0.0, 1e-7, -1e-7, -2.0, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_FALSE(project(kPlumbBob, {0.1, 0.1, z}, true, p));
  }
  CHECK(project(kPlumbBob, {0, 0, 2e-6}, true, p));
}

TEST_CASE("a field's value is the sum of its nodes by weight, and its derivative the weights") {
  const std::vector<double> weight{0.5, 0.25, -1};
  const FieldAt field{{weight.data(), weight.size()}};
  const double a = 1, b = 2, c = 3;
  const double* nodes[] = {&a, &b, &c};
  CHECK(field.value(nodes) == 0.5 + 0.5 - 3);
  CHECK((field.sizes_after({3, 7}) == std::vector<int>{3, 7, 1, 1, 1}));
  double to_a = NAN, to_c = NAN;
  double* J[] = {nullptr, &to_a, nullptr, &to_c};
  field.derive_nodes(J, 1, -2);
  CHECK((to_a == -1 && to_c == 2));
}
