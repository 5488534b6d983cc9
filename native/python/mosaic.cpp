// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "python/mosaic.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <vector>

#include "common/errors.h"
#include "mosaic/horizon.h"
#include "mosaic/views.h"

namespace py = pybind11;

namespace hullrecon {
namespace {

using Index = py::ssize_t;
template <class Number>
using Values = py::array_t<Number, py::array::c_style | py::array::forcecast>;
template <class Number>
using Sums = py::array_t<Number, py::array::c_style>;  // written to: never a copy

template <class Array>
auto span_of(const Array& array) {
  return std::span(array.data(), static_cast<size_t>(array.size()));
}

void expect(const py::array& array, std::initializer_list<Index> shape, const char* name) {
  const bool same = array.ndim() == static_cast<Index>(shape.size()) && std::equal(shape.begin(), shape.end(), array.shape());
  if (!same) throw InputError("the array is of another shape", name, "");
}

py::tuple project(const Values<double>& points, const Values<double>& camera_from_frame, const Values<double>& center,
                  const Values<double>& lens, double width, double height, double widest) {
  const Index n = points.shape(0);
  expect(points, {n, 3}, "points"), expect(camera_from_frame, {3, 3}, "camera_from_frame");
  expect(center, {3}, "center"), expect(lens, {9}, "lens");
  PlacedImage image{Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(camera_from_frame.data()),
                    Eigen::Map<const Eigen::Vector3d>(center.data()),
                    {},
                    width,
                    height,
                    widest};
  std::copy_n(lens.data(), 9, image.lens.begin());
  Values<double> pixel({n, Index{2}}), ratio(n);
  double *at = pixel.mutable_data(), *away = ratio.mutable_data();
  {
    py::gil_scoped_release free;
    project_into(image, span_of(points), at, away);
  }
  return py::make_tuple(pixel, ratio);
}

Values<double> cosines(const Values<double>& points, const Values<double>& normals, const Values<double>& sensor) {
  const Index n = points.shape(0);
  expect(points, {n, 3}, "points"), expect(normals, {n, 3}, "normals"), expect(sensor, {3}, "sensor");
  Values<double> out(n);
  double* cosine = out.mutable_data();
  {
    py::gil_scoped_release free;
    incidence(span_of(points), span_of(normals), Eigen::Map<const Eigen::Vector3d>(sensor.data()), cosine);
  }
  return out;
}

void insert(Sums<int32_t>& best_view, Sums<float>& best_cost, int32_t view, const Values<float>& cost) {
  const Index places = best_view.shape(0), texels = cost.size();
  expect(best_view, {places, texels}, "best_view"), expect(best_cost, {places, texels}, "best_cost");
  int32_t* views = best_view.mutable_data();
  float* costs = best_cost.mutable_data();
  py::gil_scoped_release free;
  insert_view(view, span_of(cost), places, views, costs);
}

void blend(Sums<float>& value, Sums<float>& weight, Sums<float>& moment, Sums<uint8_t>& views, const Values<int64_t>& rows,
           const Values<float>& pixel, const Values<double>& ratio, const Values<double>& steepness,
           const std::vector<Values<float>>& bands) {
  const Index count = static_cast<Index>(bands.size()), texels = views.size(), n = rows.size();
  if (bands.empty() || bands[0].ndim() != 3) throw InputError("the array is of another shape", "bands", "");
  const Index height = bands[0].shape(0), width = bands[0].shape(1), channels = bands[0].shape(2);
  std::vector<const float*> band;
  if (channels != 1 && channels != 3) throw InputError("the picture has neither one channel nor three", "bands", "");
  for (const auto& one : bands) expect(one, {height, width, channels}, "bands"), band.push_back(one.data());
  expect(value, {texels, count, channels}, "value"), expect(weight, {texels, count}, "weight");
  expect(moment, {texels, 3}, "moment"), expect(steepness, {count}, "steepness");
  expect(pixel, {n, 2}, "pixel"), expect(ratio, {n}, "ratio");
  for (const int64_t row : span_of(rows)) {
    if (row < 0 || row >= texels) throw InputError("a row is not there", "rows", "");
  }
  const Bands picture{band, height, width, channels};
  const BlendSums sums{value.mutable_data(), weight.mutable_data(), moment.mutable_data(), views.mutable_data()};
  py::gil_scoped_release free;
  add_view(picture, span_of(rows), span_of(pixel), span_of(ratio), span_of(steepness), sums);
}

Values<double> least_tangents(const Values<double>& top, const Values<double>& top_normal, double cell, double span,
                              double least_relief, const Values<double>& points, const Values<double>& normals) {
  const Index cells = top.shape(0);
  expect(top, {cells, 3}, "top"), expect(top_normal, {cells, 3}, "top_normal");
  if (points.ndim() != 3) throw InputError("the array is of another shape", "points", "");
  const Index n = points.shape(0), texels = points.shape(1);
  expect(points, {n, texels, 3}, "points"), expect(normals, {n, texels, 3}, "normals");
  const OcclusionHorizon horizon(span_of(top), span_of(top_normal), {cell, span, least_relief});
  Values<double> out(n);
  double* least = out.mutable_data();
  {
    py::gil_scoped_release free;
    const auto size = static_cast<size_t>(3 * texels);
    for (Index i = 0; i < n; ++i) {
      least[i] = horizon.least_tangent(span_of(points).subspan(i * size, size), span_of(normals).subspan(i * size, size));
    }
  }
  return out;
}

}  // namespace

void bind_mosaic(py::module_& m) {
  // of arrays that are written to only the very type, which no conversion copies
  m.def("project_into", &project);
  m.def("incidence", &cosines);
  m.def("insert_view", &insert, py::arg("best_view").noconvert(), py::arg("best_cost").noconvert(), py::arg("view"),
        py::arg("cost"));
  m.def("add_view", &blend, py::arg("value").noconvert(), py::arg("weight").noconvert(), py::arg("moment").noconvert(),
        py::arg("views").noconvert(), py::arg("rows"), py::arg("pixel"), py::arg("ratio"), py::arg("steepness"),
        py::arg("bands"));
  m.def("least_tangents", &least_tangents);
}

}  // namespace hullrecon
