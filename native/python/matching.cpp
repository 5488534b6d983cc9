// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "python/matching.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <span>

#include "common/errors.h"
#include "matching/feature_pairs.h"
#include "matching/pair_motion.h"
#include "matching/sift_descriptors.h"

namespace py = pybind11;

namespace hullrecon {
namespace {

using Bools = py::array_t<bool, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Int64s = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;
using Index = py::ssize_t;

template <class Number>
std::span<const Number> span_of(const py::array_t<Number, py::array::c_style | py::array::forcecast>& array) {
  return {array.data(), static_cast<size_t>(array.size())};
}

Int64s copied(const std::vector<int64_t>& values) {
  return Int64s(static_cast<py::ssize_t>(values.size()), values.data());
}

py::tuple in_regions(const Doubles& regions, const Doubles& points) {
  static_assert(sizeof(SearchRegion) == 7 * sizeof(double));
  if (regions.ndim() != 2 || regions.shape(1) != 7) throw InputError("the array must be (n, 7)", "regions", "");
  if (points.ndim() != 2 || points.shape(1) != 2) throw InputError("the array must be (n, 2)", "points", "");
  std::vector<SearchRegion> sought(regions.shape(0));
  if (!sought.empty()) std::memcpy(static_cast<void*>(sought.data()), regions.data(), sizeof(SearchRegion) * sought.size());
  FeaturePairs found;
  {
    py::gil_scoped_release free;
    found = pairs_in_regions(sought, span_of(points));
  }
  return py::make_tuple(copied(found.first), copied(found.second));
}

void expect_rows(const Int64s& row, int64_t count, const char* name) {
  for (const int64_t k : span_of(row)) {
    if (k < 0 || k >= count) throw InputError("a row is not there", name, "");
  }
}

Floats distances(const Floats& a, const Floats& b, const Int64s& first, const Int64s& second) {
  if (a.ndim() != 2 || b.ndim() != 2 || a.shape(1) != b.shape(1)) throw InputError("descriptors differ in width", "b", "");
  if (first.size() != second.size()) throw InputError("first and second differ in number", "second", "");
  expect_rows(first, a.shape(0), "first"), expect_rows(second, b.shape(0), "second");
  Floats out(first.size());
  const std::span<float> distance{out.mutable_data(), static_cast<size_t>(out.size())};
  {
    py::gil_scoped_release free;
    descriptor_distances(a.data(), b.data(), a.shape(1), span_of(first), span_of(second), distance);
  }
  return out;
}

py::tuple best_by_key(const Int64s& key, const Floats& distance) {
  if (key.size() != distance.size()) throw InputError("keys and distances differ in number", "distance", "");
  int64_t count = 0;
  for (const int64_t k : span_of(key)) count = std::max(count, k + 1);
  expect_rows(key, count, "key");
  Int64s best(count);
  Floats next(count);
  best_and_next(span_of(key), span_of(distance), {best.mutable_data(), static_cast<size_t>(count)},
                {next.mutable_data(), static_cast<size_t>(count)});
  return py::make_tuple(best, next);
}

void expect_shape(const py::array& array, std::initializer_list<Index> shape, const char* name) {
  const bool same = array.ndim() == static_cast<Index>(shape.size()) && std::equal(shape.begin(), shape.end(), array.shape());
  if (!same) throw InputError("the array is of another shape", name, "");
}

py::array_t<uint8_t> descriptors(const std::vector<Floats>& levels, const Doubles& keypoints, const Int64s& level) {
  expect_shape(keypoints, {keypoints.shape(0), 4}, "keypoints"), expect_shape(level, {keypoints.shape(0)}, "level");
  std::vector<ScaleLevel> space;
  for (const Floats& image : levels) {
    if (image.ndim() != 2 || image.shape(1) < kLeastWidth)
      throw InputError("an image must be (h, w), 10 px wide", "levels", "");
    space.push_back({image.data(), image.shape(0), image.shape(1)});
  }
  expect_rows(level, static_cast<int64_t>(space.size()), "level");
  std::vector<LevelKeypoint> placed;
  for (Index k = 0; k < keypoints.shape(0); ++k) {
    const double* at = keypoints.data(k, 0);
    const ScaleLevel& image = space[*level.data(k)];
    const bool inside = at[0] >= 0 && at[1] >= 0 && at[0] <= image.width - 1.0 && at[1] <= image.height - 1.0;
    if (!inside || !(at[2] > 0) || !std::isfinite(at[3])) throw InputError("a keypoint is not in its level", "keypoints", "");
    placed.push_back({at[0], at[1], at[2], at[3], *level.data(k)});
  }
  py::array_t<uint8_t> out({keypoints.shape(0), Index{kDescriptor}});
  uint8_t* descriptor = out.mutable_data();
  {
    py::gil_scoped_release free;
    describe_keypoints(space, placed, descriptor);
  }
  return out;
}

// A transform (4, 4), row by row.
Transform transform_of(const double* matrix) {
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> m(matrix);
  return {m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>()};
}

Doubles reprojections(const Doubles& motions, const Doubles& points, const Doubles& xy) {
  const Index n = points.shape(0), trials = motions.shape(0);
  expect_shape(motions, {trials, 4, 4}, "motions"), expect_shape(points, {n, 3}, "points"), expect_shape(xy, {n, 2}, "xy");
  Doubles out({trials, n});
  for (Index k = 0; k < trials; ++k) {
    squared_reprojections(transform_of(motions.data(k, 0, 0)), span_of(points), span_of(xy),
                          {out.mutable_data() + k * n, static_cast<size_t>(n)});
  }
  return out;
}

py::tuple normal_of_reprojections(const Doubles& motion, const Doubles& points, const Doubles& xy, const Doubles& camera,
                                  bool backward, double baseline_m, const Bools& counts) {
  const Index n = points.shape(0);
  expect_shape(motion, {4, 4}, "motion"), expect_shape(camera, {4, 4}, "camera_from_node");
  expect_shape(points, {n, 3}, "points"), expect_shape(xy, {n, 2}, "xy"), expect_shape(counts, {n}, "counts");
  MotionNormal sum;
  const SeenPoints seen{span_of(points), span_of(xy), transform_of(camera.data()), backward, baseline_m};
  add_reprojections(transform_of(motion.data()), seen, span_of(counts), sum);
  return py::make_tuple(Doubles({6, 6}, sum.information.data()), Doubles(6, sum.gradient.data()), sum.cost);
}

// The features of two stereo nodes: their cameras, points (m, 3) and where they were seen (m, 8).
struct StereoPair {
  StereoCameras cameras;
  Doubles points, seen;

  StereoPair(const Doubles& motion, const Doubles& bottom_from_top, const Doubles& points, const Doubles& seen)
      : points(points), seen(seen) {
    expect_shape(motion, {4, 4}, "motion"), expect_shape(bottom_from_top, {4, 4}, "bottom_from_top");
    expect_shape(points, {points.shape(0), 3}, "points"), expect_shape(seen, {points.shape(0), kStereoRows}, "seen");
    cameras = {transform_of(motion.data()), transform_of(bottom_from_top.data())};
  }

  Index size() const { return points.shape(0); }
  Eigen::Vector3d point(Index k) const { return Eigen::Map<const Eigen::Vector3d>(points.data(k, 0)); }
  std::span<const double, kStereoRows> views(Index k) const {
    return std::span<const double, kStereoRows>{seen.data(k, 0), kStereoRows};
  }
};

template <class Matrix>
void put(Doubles& out, Index row, const Matrix& values) {
  Eigen::Map<Eigen::Matrix<double, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime,
                           Matrix::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor>>(out.mutable_data() +
                                                                                                row * values.size()) = values;
}

py::dict stereo_rows(const Doubles& motion, const Doubles& bottom_from_top, double field, const Doubles& points,
                     const Doubles& seen) {
  const StereoPair pair(motion, bottom_from_top, points, seen);
  const Index m = pair.size();
  Doubles residual({m, Index{8}}), by_point({m, Index{8}, Index{3}}), by_motion({m, Index{8}, Index{6}});
  Doubles by_calibration({m, Index{8}, Index{kCalibration}});
  for (Index k = 0; k < m; ++k) {
    const StereoRows rows = linearise_stereo(pair.cameras, pair.point(k), pair.views(k));
    put(residual, k, rows.residual), put(by_point, k, rows.by_point), put(by_motion, k, rows.by_motion);
    put(by_calibration, k, linearise_calibration(pair.cameras, field, pair.point(k), pair.views(k)));
  }
  py::dict out;
  out["residual"] = residual, out["by_point"] = by_point, out["by_motion"] = by_motion;
  out["by_calibration"] = by_calibration;
  return out;
}

py::dict reduce_stereo(const Doubles& motion, const Doubles& bottom_from_top, const Doubles& points, const Doubles& seen) {
  const StereoPair pair(motion, bottom_from_top, points, seen);
  const Index m = pair.size();
  Doubles information({m, Index{6}, Index{6}}), gradient({m, Index{6}}), cost(m), inverse({m, Index{3}, Index{3}});
  Doubles point_gradient({m, Index{3}}), by_motion({m, Index{6}, Index{3}});
  Int64s freedom(m);
  for (Index k = 0; k < m; ++k) {
    const ReducedFeature f = reduce(linearise_stereo(pair.cameras, pair.point(k), pair.views(k)));
    put(information, k, f.information), put(gradient, k, f.gradient), put(inverse, k, f.point_inverse);
    put(point_gradient, k, f.point_gradient), put(by_motion, k, f.point_by_motion);
    *cost.mutable_data(k) = f.cost, *freedom.mutable_data(k) = f.freedom;
  }
  py::dict out;
  out["information"] = information, out["gradient"] = gradient, out["cost"] = cost, out["freedom"] = freedom;
  out["point_inverse"] = inverse, out["point_gradient"] = point_gradient, out["point_by_motion"] = by_motion;
  return out;
}

}  // namespace

void bind_matching(py::module_& m) {
  m.def("pairs_in_regions", &in_regions);
  m.def("descriptor_distances", &distances);
  m.def("describe_keypoints", &descriptors);
  m.def("best_and_next", &best_by_key);
  m.def("squared_reprojections", &reprojections);
  m.def("normal_of_reprojections", &normal_of_reprojections);
  m.def("linearise_stereo", &stereo_rows);
  m.def("reduce_stereo", &reduce_stereo);
}

}  // namespace hullrecon
