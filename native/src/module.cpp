// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// pybind11: converts and calls, no logic.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "hullrecon/errors.h"
#include "hullrecon/mesh_index.h"
#include "hullrecon/parallel.h"

namespace py = pybind11;

namespace hullrecon {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Int32s = py::array_t<int32_t, py::array::c_style | py::array::forcecast>;

void expect(const py::array& array, const char* name) {
  if (array.ndim() != 2 || array.shape(1) != 3) throw InputError("the array must be (n, 3)", name, "");
}

std::vector<Vec3> rows(const Doubles& array, const char* name) {
  expect(array, name);
  std::vector<Vec3> out(array.shape(0));
  for (size_t i = 0; i < out.size(); ++i) out[i] = Eigen::Map<const Vec3>(array.data(i, 0));
  for (const Vec3& row : out) {
    if (!row.allFinite()) throw InputError("a number is not finite", name, "");
  }
  return out;
}

std::unique_ptr<MeshIndex> make_index(const Doubles& vertices, const Int32s& faces) {
  auto points = rows(vertices, "vertices");
  expect(faces, "faces");
  std::vector<std::array<int32_t, 3>> corners(faces.shape(0));
  for (size_t i = 0; i < corners.size(); ++i) corners[i] = {faces.at(i, 0), faces.at(i, 1), faces.at(i, 2)};
  py::gil_scoped_release free;
  return std::make_unique<MeshIndex>(std::move(points), std::move(corners));
}

py::tuple closest(const MeshIndex& index, const Doubles& points, int threads) {
  const auto query = rows(points, "points");
  const auto n = static_cast<py::ssize_t>(query.size());
  Doubles distance(n), point({n, py::ssize_t{3}}), gradient({n, py::ssize_t{3}});
  Int32s face(n);
  double *d = distance.mutable_data(), *p = point.mutable_data(), *g = gradient.mutable_data();
  int32_t* f = face.mutable_data();
  {
    py::gil_scoped_release free;
    for_slabs(n, threads, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) {
        const Closest c = index.closest(query[i]);
        d[i] = c.distance;
        Eigen::Map<Vec3>(p + 3 * i) = c.point;
        Eigen::Map<Vec3>(g + 3 * i) = c.gradient;
        f[i] = c.face;
      }
    });
  }
  return py::make_tuple(distance, point, gradient, face);
}

py::tuple cast(const MeshIndex& index, const Doubles& origins, const Doubles& directions, int threads) {
  const auto from = rows(origins, "origins"), along = rows(directions, "directions");
  if (from.size() != along.size()) throw InputError("origins and directions differ in number", "directions", "");
  for (const Vec3& d : along) {
    if (!(d.norm() > 0)) throw InputError("a direction has no length", "directions", "");
  }
  const auto n = static_cast<py::ssize_t>(from.size());
  Doubles range(n), normal({n, py::ssize_t{3}});
  Int32s face(n);
  double *r = range.mutable_data(), *m = normal.mutable_data();
  int32_t* f = face.mutable_data();
  {
    py::gil_scoped_release free;
    for_slabs(n, threads, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) {
        const Hit hit = index.cast(from[i], along[i].normalized());
        r[i] = hit.range;
        f[i] = hit.face;
        Eigen::Map<Vec3>(m + 3 * i) = hit.normal;
      }
    });
  }
  return py::make_tuple(range, face, normal);
}

void raise(const char* type, const Error& error) {
  const py::object kind = py::module_::import("hullrecon.errors").attr(type);
  const py::object value = kind(error.what(), py::arg("where") = error.where, py::arg("remedy") = error.remedy);
  PyErr_SetObject(kind.ptr(), value.ptr());
}

void translate(std::exception_ptr pointer) {
  try {
    std::rethrow_exception(pointer);
  } catch (const InputError& error) {
    raise("InputError", error);
  } catch (const UsageError& error) {
    raise("UsageError", error);
  } catch (const StageError& error) {
    raise("StageError", error);
  }
}

}  // namespace

PYBIND11_MODULE(_native, m) {
  py::register_exception_translator(translate);
  py::class_<MeshIndex>(m, "MeshIndex")
      .def(py::init(&make_index))
      .def("closest", &closest)
      .def("cast", &cast)
      .def("__len__", &MeshIndex::faces);
}

}  // namespace hullrecon
