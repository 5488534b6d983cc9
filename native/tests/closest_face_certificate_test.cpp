// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Closest points by tree, walk and certificate, and rays, against all faces in turn, to the last bit.
#include <cmath>
#include <random>

#include "mesh/mesh_index.h"

#include "expect.h"

using namespace hullrecon;

namespace {

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<int32_t, 3>> faces;

  Triangle triangle(size_t f) const { return {vertices[faces[f][0]], vertices[faces[f][1]], vertices[faces[f][2]]}; }
  void add(const Mesh& other) {
    const auto first = static_cast<int32_t>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& f : other.faces) faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  }
};

std::mt19937 rng(7);
double uniform(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}
Vec3 random_point(double size) {
  return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
}

// n by n squares over [-1, 1]^2, each of two triangles.
template <class At>
Mesh sheet(int n, const At& at) {
  Mesh out;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) out.vertices.push_back(at(2.0 * i / n - 1, 2.0 * j / n - 1));
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j;
      out.faces.push_back({a, a + n + 1, a + n + 2}), out.faces.push_back({a, a + n + 2, a + 1});
    }
  }
  return out;
}

Mesh waves(int n, double high) {
  return sheet(n, [=](double x, double y) { return Vec3(x, y, high * std::sin(5 * x) * std::cos(7 * y)); });
}
Mesh rough(int n, double high) {
  return sheet(n, [=](double x, double y) { return Vec3(Vec3(x, y, 0) + random_point(high)); });
}
Mesh thin_plate() {
  Mesh out = sheet(8, [](double x, double y) { return Vec3(x, y, 0.005); });
  out.add(sheet(5, [](double x, double y) { return Vec3(y, x, 0); }));
  return out;
}
Mesh fold() {
  return sheet(8, [](double x, double y) { return Vec3(std::abs(x), y, 0.02 * x); });
}
Mesh cylinder(double radius) {
  return sheet(24, [=](double x, double y) { return Vec3(radius * std::cos(3.2 * x), y, radius * std::sin(3.2 * x)); });
}

// Corners moved to within rounding of an edge, or onto another corner.
Mesh slivers() {
  Mesh out = rough(6, 0.05);
  for (double near : {1e-3, 1e-6, 1e-9, 1e-13, 0.0}) {
    const auto f = static_cast<size_t>(uniform(0, static_cast<double>(out.faces.size())));
    const auto [a, b, c] = out.faces[f];
    const auto fresh = static_cast<int32_t>(out.vertices.size());
    out.vertices.push_back(out.vertices[a] + 0.3 * (out.vertices[b] - out.vertices[a]) +
                           near * (out.vertices[c] - out.vertices[a]));
    out.faces[f] = {fresh, b, c};
    out.faces.push_back({a, fresh, c}), out.faces.push_back({a, b, fresh});
  }
  out.faces.push_back({3, 3, 9}), out.faces.push_back({4, 4, 4});
  return out;
}

// As an STL has it: every face with corners of its own; and some faces twice, also turned over.
Mesh soup(const Mesh& mesh) {
  Mesh out;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Triangle t = mesh.triangle(f);
    out.add({{t.a, t.b, t.c}, {{0, 1, 2}}});
    if (f % 7 == 0) out.add({{t.b, t.c, t.a}, {{0, 1, 2}}});
    if (f % 11 == 0) out.add({{t.a, t.c, t.b}, {{0, 1, 2}}});
  }
  return out;
}

// A corner of many faces, alternately high and low, and large faces beside small ones.
Mesh fan() {
  Mesh out = waves(10, 0.01);
  const auto hub = static_cast<int32_t>(out.vertices.size());
  out.vertices.emplace_back(2.5, 0, 0.2);
  for (int k = 0; k < 40; ++k) {
    out.vertices.emplace_back(2.5 + 1.5 * std::cos(0.157 * k), 1.5 * std::sin(0.157 * k), k % 2 == 0 ? 0.1 : -0.1);
    out.faces.push_back({hub, hub + 1 + k, hub + 1 + (k + 1) % 40});
  }
  return out;
}

struct Nearest {
  double squared = std::numeric_limits<double>::infinity();
  int32_t face = -1;
  Vec3 point;
};

Nearest by_all_faces(const Mesh& mesh, const Vec3& p) {
  Nearest best;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const OnTriangle on = closest_on_triangle(p, mesh.triangle(f));
    const double squared = (p - on.point).squaredNorm();
    if (squared < best.squared) best = {squared, static_cast<int32_t>(f), on.point};
  }
  return best;
}

// Above a face or beside it, at any height; on a corner, on an edge; far away.
Vec3 place_near(const Mesh& mesh, int i) {
  const Triangle t = mesh.triangle(static_cast<size_t>(uniform(0, static_cast<double>(mesh.faces.size()))));
  if (i % 50 == 0) return t.a;
  if (i % 50 == 1) return 0.5 * (t.b + t.c);
  if (i % 10 == 2) return random_point(4);
  const double u = uniform(-0.1, 1.1), v = uniform(-0.1, 1.1 - u);
  return t.a + u * (t.b - t.a) + v * (t.c - t.a) + std::pow(10, uniform(-7, 0.3)) * random_point(1);
}

// Also along an axis or two, from a corner or beside the mesh.
int differing_rays(const Mesh& mesh, int rays) {
  const MeshIndex index(mesh.vertices, mesh.faces);
  int wrong = 0;
  for (int i = 0; i < rays; ++i) {
    const Vec3 origin = i % 3 == 0 ? mesh.vertices[static_cast<size_t>(i) % mesh.vertices.size()] : place_near(mesh, i);
    Vec3 along = random_point(1) + Vec3(0, 0, 0.01);
    if (i % 4 == 1) along[i % 3] = 0;
    if (i % 4 == 2) along = Vec3::Unit(i % 3) * (i % 8 == 2 ? 1 : -1);
    along.normalize();
    Hit expected{std::numeric_limits<double>::infinity(), -1, Vec3::Zero()};
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto range = cross(origin, along, mesh.triangle(f));
      if (range && *range < expected.range) expected.range = *range, expected.face = static_cast<int32_t>(f);
    }
    const Hit got = index.cast(origin, along);
    wrong += got.face != expected.face || got.range != expected.range;
  }
  return wrong;
}

int differences(const Mesh& mesh, int points) {
  const MeshIndex index(mesh.vertices, mesh.faces);
  int wrong = 0;
  int32_t last = -1;
  for (int i = 0; i < points; ++i) {
    const Vec3 p = place_near(mesh, i);
    const Nearest expected = by_all_faces(mesh, p);
    const Closest plain = index.closest(p);
    const auto any = static_cast<int32_t>(uniform(0, static_cast<double>(mesh.faces.size())));
    for (int32_t hint : {-1, last, any, expected.face}) {
      const Closest got = index.closest(p, hint);
      wrong += got.face != expected.face || got.point != expected.point || got.distance != plain.distance ||
               got.gradient != plain.gradient || std::abs(got.distance) != std::sqrt(expected.squared);
    }
    last = plain.face;
  }
  return wrong;
}

}  // namespace

TEST_CASE("from whatever face the search starts the closest is that of all faces in turn") {
  CHECK(differences(waves(3, 0.4), 3000) == 0);
  CHECK(differences(waves(12, 0.1), 3000) == 0);
  CHECK(differences(sheet(6, [](double x, double y) { return Vec3(x, y, 0); }), 3000) == 0);
  CHECK(differences(rough(8, 0.01), 3000) == 0);
  CHECK(differences(rough(8, 0.3), 3000) == 0);
  CHECK(differences(cylinder(1.0), 2000) == 0);
  CHECK(differences(cylinder(0.03), 2000) == 0);
}

TEST_CASE("so it is where two sides are near each other, faces fold, stand twice or are of no area") {
  CHECK(differences(thin_plate(), 3000) == 0);
  CHECK(differences(fold(), 3000) == 0);
  CHECK(differences(slivers(), 3000) == 0);
  CHECK(differences(soup(waves(6, 0.1)), 3000) == 0);
  CHECK(differences(soup(rough(5, 0.2)), 3000) == 0);
  CHECK(differences(fan(), 3000) == 0);
}

TEST_CASE("so it is far from the origin, where coordinates are coarse") {
  Mesh away = rough(8, 0.05);
  for (Vec3& v : away.vertices) v += Vec3(900, -400, 30);
  CHECK(differences(away, 3000) == 0);
}

TEST_CASE("a ray hits what it hits first of all faces in turn, also along an axis from a corner") {
  CHECK(differing_rays(waves(12, 0.1), 4000) == 0);
  CHECK(differing_rays(sheet(6, [](double x, double y) { return Vec3(x, 0.5, y); }), 4000) == 0);
  CHECK(differing_rays(rough(8, 0.3), 4000) == 0);
  CHECK(differing_rays(thin_plate(), 4000) == 0);
  CHECK(differing_rays(slivers(), 4000) == 0);
}
