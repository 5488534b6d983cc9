// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Single triangles by hand, and the tree of boxes over them.
#include "mesh/box_tree.h"

#include <Eigen/Geometry>
#include <limits>
#include <random>
#include <set>

#include "expect.h"

using namespace hullrecon;

namespace {

const Triangle kRight{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};

std::vector<Triangle> cloud(int count, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> at(-5, 5), size(-0.3, 0.3);
  std::vector<Triangle> out;
  for (int k = 0; k < count; ++k) {
    const Vec3 a(at(rng), at(rng), at(rng));
    out.push_back({a, a + Vec3(size(rng), size(rng), size(rng)), a + Vec3(size(rng), size(rng), size(rng))});
  }
  return out;
}

auto squared_distance(const Vec3& p) {
  return [p](const Boxes& b, Four& out) { squared_gaps(b, p, p, out); };
}

}  // namespace

TEST_CASE("the closest point of a triangle lies on the feature whose region the query is in") {
  const std::vector<std::tuple<Vec3, Vec3, Feature>> cases{
      {{0.5, 0.5, 3}, {0.5, 0.5, 0}, Feature::Face},     {{0.5, 0.5, -3}, {0.5, 0.5, 0}, Feature::Face},
      {{1, -1, 1}, {1, 0, 0}, Feature::Edge0},           {{2, 2, 1}, {1, 1, 0}, Feature::Edge1},
      {{-1, 1, 1}, {0, 1, 0}, Feature::Edge2},           {{-1, -1, 1}, {0, 0, 0}, Feature::Corner0},
      {{4, -1, 1}, {2, 0, 0}, Feature::Corner1},         {{-1, 4, 1}, {0, 2, 0}, Feature::Corner2},
      {{0, 0, 0}, {0, 0, 0}, Feature::Corner0},          {{2, 0, 5}, {2, 0, 0}, Feature::Corner1},
      {{0.25, 1e-9, 1}, {0.25, 1e-9, 0}, Feature::Face}, {{0.25, -1e-9, 1}, {0.25, 0, 0}, Feature::Edge0},
  };
  for (const auto& [query, point, feature] : cases) {
    const OnTriangle on = closest_on_triangle(query, kRight);
    CHECK((on.point - point).norm() < 1e-15);
    CHECK(on.feature == feature);
  }
}

TEST_CASE("a sliver has edges and corners, but no face") {
  const Triangle sliver{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}};
  const OnTriangle on = closest_on_triangle({2, 1, 0}, sliver);
  CHECK((on.point - Vec3(2, 0, 0)).norm() < 1e-15);
  CHECK((on.feature != Feature::Face && static_cast<int>(on.feature) <= static_cast<int>(Feature::Edge2)));
  const Triangle dot{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  CHECK((closest_on_triangle({5, 5, 5}, dot).point - Vec3(1, 1, 1)).norm() == 0.0);
}

TEST_CASE("the foot over the inside is the closest point, to the last bit") {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> share(0.01, 0.49), height(-2, 2);
  const Triangle t{{0.3, -0.2, 0.1}, {1.7, 0.4, -0.3}, {0.1, 1.9, 0.6}};
  const Vec3 normal = (t.b - t.a).cross(t.c - t.a).normalized();
  for (int k = 0; k < 200; ++k) {
    const Vec3 p = t.a + share(rng) * (t.b - t.a) + share(rng) * (t.c - t.a) + height(rng) * normal;
    const OnTriangle on = closest_on_triangle(p, t);
    REQUIRE(on.feature == Feature::Face);
    CHECK((on.point.array() == foot_inside(p, t).array()).all());
  }
}

TEST_CASE("a ray crosses a triangle from either side, ahead only, and through its edges") {
  CHECK(*cross({0.5, 0.5, 3}, {0, 0, -1}, kRight) == doctest::Approx(3));
  CHECK(*cross({0.5, 0.5, -3}, {0, 0, 2}, kRight) == doctest::Approx(1.5));  // in lengths of the direction
  CHECK(*cross({1, 0, 3}, {0, 0, -1}, kRight) == doctest::Approx(3));
  CHECK_FALSE(cross({0.5, 0.5, 3}, {0, 0, 1}, kRight).has_value());
  CHECK_FALSE(cross({1.5, 1.5, 3}, {0, 0, -1}, kRight).has_value());
  CHECK_FALSE(cross({-1, 0.5, 0}, {1, 0, 0}, kRight).has_value());  // within its plane
  CHECK_FALSE(cross({0.5, 0, 1}, {0, 0, -1}, {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}).has_value());
}

TEST_CASE("every triangle within the limit is visited, once, and none whose box is beyond it need be") {
  for (int count : {1, 2, 4, 5, 16, 17, 300}) {
    const auto faces = cloud(count, static_cast<unsigned>(count));
    const BoxTree tree(faces);
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(4, -4, 2), Vec3(30, 0, 0)}) {
      for (double limit : {1.0, 9.0, 1e9}) {
        std::set<int32_t> seen;
        int visits = 0;
        tree.descend(
            squared_distance(p), [&] { return limit; },
            [&](int32_t face, const Triangle& t) {
              seen.insert(face);
              ++visits;
              CHECK((t.a == faces[face].a && t.b == faces[face].b && t.c == faces[face].c));
            });
        CHECK(visits == static_cast<int>(seen.size()));
        for (int32_t f = 0; f < count; ++f) {
          if ((closest_on_triangle(p, faces[f]).point - p).squaredNorm() < limit) CHECK(seen.count(f) == 1);
        }
        if (limit > 1e8) CHECK(visits == count);
      }
    }
  }
}

TEST_CASE("a limit that falls cuts the search short, and the nearest is found all the same") {
  const auto faces = cloud(2000, 1);
  const BoxTree tree(faces);
  std::mt19937 rng(9);
  std::uniform_real_distribution<double> at(-6, 6);
  int64_t visits = 0;
  for (int k = 0; k < 50; ++k) {
    const Vec3 p(at(rng), at(rng), at(rng));
    double best = std::numeric_limits<double>::infinity(), expected = best;
    for (const Triangle& t : faces) expected = std::min(expected, (closest_on_triangle(p, t).point - p).squaredNorm());
    tree.descend(
        squared_distance(p), [&] { return best; },
        [&](int32_t, const Triangle& t) {
          ++visits;
          best = std::min(best, (closest_on_triangle(p, t).point - p).squaredNorm());
        });
    CHECK(best == expected);
  }
  CHECK(visits < 50 * 200);  // a tenth of all at most
}
