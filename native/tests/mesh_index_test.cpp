// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_index.h"

#include <random>

#include "common/errors.h"
#include "model/association.h"

#include "expect.h"

using namespace hullrecon;

namespace {

std::unique_ptr<MeshIndex> plate() {
  std::vector<Vec3> v{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  return std::make_unique<MeshIndex>(v, std::vector<std::array<int32_t, 3>>{{0, 1, 2}, {0, 2, 3}});
}

}  // namespace

TEST_CASE("a hint changes no answer") {
  const auto mesh = plate();
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> at(-1, 5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p(at(rng), at(rng), at(rng));
    const Closest plain = mesh->closest(p);
    for (int hint : {0, 1}) {
      const Closest hinted = mesh->closest(p, hint);
      CHECK((hinted.face == plain.face && hinted.distance == plain.distance && hinted.gradient == plain.gradient));
    }
  }
}

TEST_CASE("a mesh with a vertex that is not there is refused") {
  const std::vector<std::array<int32_t, 3>> faces{{0, 1, 3}};
  CHECK_THROWS_AS(MeshIndex(std::vector<Vec3>(3, Vec3::Zero()), faces), InputError);
}

TEST_CASE("a beam that flickers more than three times is held off") {
  Association a(plate(), 0, 1, 1);
  const auto shoot = [&](bool hit) {
    a.refresh_range([&](int64_t) { return std::pair(Vec3(hit ? 1 : 9, 1, 2), Vec3(0, 0, -1)); }, true);
  };
  shoot(true);
  CHECK(a.range(0)->active);
  for (int k = 0; k < 4; ++k) shoot(k % 2 == 1);
  CHECK(a.hit(0));
  CHECK_FALSE(a.range(0)->active);
}

TEST_CASE("a trial point that loses many beams is refused, a start that misses them is not") {
  Association a(plate(), 0, 100, 1);
  const auto shoot = [&](int lost, bool trial) {
    a.refresh_range([&](int64_t i) { return std::pair(Vec3(i < lost ? 9 : 1, 1, 2), Vec3(0, 0, -1)); }, trial);
  };
  shoot(30, false);
  CHECK_FALSE(*a.refused());
  shoot(40, true);
  CHECK_FALSE(*a.refused());
  shoot(60, true);
  CHECK(*a.refused());
  CHECK(a.missed() == 60);
}

TEST_CASE("a grazing beam counts as a miss") {
  Association a(plate(), 0, 1, 1);
  a.refresh_range([&](int64_t) { return std::pair(Vec3(-1, 1, 0.01), Vec3(1, 0, -0.005).normalized()); }, false);
  CHECK_FALSE(a.range(0)->active);
  CHECK(a.missed() == 1);
}
