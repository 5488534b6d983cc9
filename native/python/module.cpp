// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// pybind11: converts and calls, no logic.
#include <glog/logging.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>
#include <span>

#include "common/errors.h"
#include "common/parallel.h"
#include "mesh/drawing.h"
#include "mesh/mesh_index.h"
#include "python/convert.h"
#include "python/matching.h"
#include "python/mosaic.h"
#include "solve/covariance.h"
#include "solve/evaluate.h"
#include "solve/pair_covariance.h"
#include "solve/solve.h"

namespace py = pybind11;

namespace hullrecon {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Int32s = py::array_t<int32_t, py::array::c_style | py::array::forcecast>;

constexpr int64_t kRaysOfThread = 4096;  // a ray takes some 0.4 us, to start a thread as much as a hundred

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
    const auto work = [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) {
        const Hit hit = index.cast(from[i], along[i].normalized());
        r[i] = hit.range;
        f[i] = hit.face;
        Eigen::Map<Vec3>(m + 3 * i) = hit.normal;
      }
    };
    for_slabs(n, threads, work, kRaysOfThread);
  }
  return py::make_tuple(range, face, normal);
}

py::array_t<bool> is_free(const MeshIndex& index, const Doubles& starts, const Doubles& ends, int threads) {
  const auto from = rows(starts, "starts"), to = rows(ends, "ends");
  if (from.size() != to.size()) throw InputError("starts and ends differ in number", "ends", "");
  const auto n = static_cast<py::ssize_t>(from.size());
  py::array_t<bool> out(n);
  bool* is = out.mutable_data();
  {
    py::gil_scoped_release free;
    const auto work = [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) is[i] = index.is_free(from[i], to[i]);
    };
    for_slabs(n, threads, work, kRaysOfThread);
  }
  return out;
}

void draw_triangles(Floats& picture, const Doubles& points, const Int32s& faces, const Floats& values) {
  if (picture.ndim() != 3) throw InputError("the array must be (h, w, channels)", "picture", "");
  if (points.ndim() != 2 || points.shape(1) != 2) throw InputError("the array must be (n, 2)", "points", "");
  if (values.ndim() != 2 || values.shape(0) != points.shape(0) || values.shape(1) != picture.shape(2)) {
    throw InputError("the array must be (n, channels)", "values", "");
  }
  expect(faces, "faces");
  for (py::ssize_t i = 0; i < faces.size(); ++i) {
    if (faces.data()[i] < 0 || faces.data()[i] >= points.shape(0)) throw InputError("a corner is not there", "faces", "");
  }
  const Canvas canvas{picture.mutable_data(), picture.shape(0), picture.shape(1), picture.shape(2)};
  const double* at = points.data();
  const float* value = values.data();
  const int32_t* corner = faces.data();
  const py::ssize_t count = faces.shape(0);
  py::gil_scoped_release free;
  for (py::ssize_t i = 0; i < count; ++i, corner += 3) {
    draw_triangle(
        canvas, {at + 2 * corner[0], at + 2 * corner[1], at + 2 * corner[2]},
        {value + canvas.channels * corner[0], value + canvas.channels * corner[1], value + canvas.channels * corner[2]});
  }
}

template <class Number, class Value>
py::array_t<Number> column(const std::vector<Value>& values) {
  py::array_t<Number> out(static_cast<py::ssize_t>(values.size()));
  std::copy(values.begin(), values.end(), out.mutable_data());
  return out;
}

py::dict unknowns(const Model& model) {
  const auto gather = [&](int64_t first, int64_t count, int width) {
    Doubles out({static_cast<py::ssize_t>(count), static_cast<py::ssize_t>(width)});
    for (int64_t i = 0; i < count; ++i) std::copy_n(model.blocks()[first + i].data, width, out.mutable_data(i, 0));
    return out;
  };
  py::dict out;
  out["pose"] = gather(0, model.poses(), 8);
  out["landmark"] = gather(model.poses(), model.landmarks(), 3);
  const auto globals = static_cast<int>(model.poses() + model.landmarks());
  for (int b = globals; b < model.first_node(); ++b) {
    const Block& block = model.blocks()[b];
    out[model.name_of(b).c_str()] = py::array_t<double>(block.size, block.data);
  }
  const auto numbers = [&](int first, py::ssize_t count) { return gather(first, count, 1).reshape({count}); };
  out["deviation"] = numbers(model.first_node(), model.nodes());
  out["plane"] = gather(model.first_plane(), model.planes(), 3);
  out["link_switch"] = numbers(model.first_switch(), model.tables().link_switch.rows());
  return out;
}

py::dict record(const std::vector<IterationRow>& rows) {
  const auto of = [&]<class Number>(Number, auto field) {
    py::array_t<Number> out(static_cast<py::ssize_t>(rows.size()));
    for (size_t i = 0; i < rows.size(); ++i) out.mutable_at(i) = rows[i].*field;
    return out;
  };
  py::dict out, by;
  out["cost"] = of(0.0, &IterationRow::cost);
  out["cost_change"] = of(0.0, &IterationRow::cost_change);
  out["step_norm"] = of(0.0, &IterationRow::step_norm);
  out["gradient_norm"] = of(0.0, &IterationRow::gradient_norm);
  out["radius"] = of(0.0, &IterationRow::radius);
  out["accepted"] = of(false, &IterationRow::accepted);
  out["seconds"] = of(0.0, &IterationRow::seconds);
  for (size_t k = 0; k < kKindNames.size(); ++k) {
    std::vector<double> cost;
    for (const IterationRow& row : rows) cost.push_back(row.cost_by_kind[k]);
    by[kKindNames[k]] = column<double>(cost);
  }
  out["cost_by_factor"] = by;
  out["on_surface"] = of(int64_t{}, &IterationRow::on_surface);
  out["label_changes"] = of(int64_t{}, &IterationRow::label_changes);
  out["rays_missed"] = of(int64_t{}, &IterationRow::rays_missed);
  return out;
}

bool interrupted() {
  py::gil_scoped_acquire hold;
  return PyErr_CheckSignals() != 0;
}

// Unknowns, and what became of rows.
py::dict rows_of(const Model& model) {
  py::dict out;
  out["unknowns"] = unknowns(model);
  out["label"] = column<int32_t>(model.labels());
  out["distance"] = column<double>(model.association().distance());
  std::vector<char> hit;
  for (int64_t i = 0; i < model.tables().range_node.rows(); ++i) hit.push_back(model.association().hit(i));
  out["ray_hit"] = column<bool>(hit);
  return out;
}

void add_record(py::dict& out, const Solution& solution) {
  py::dict seconds;
  out["iterations"] = record(solution.iterations);
  out["converged"] = solution.converged;
  out["message"] = solution.message;
  for (const auto& [part, time] : solution.seconds) seconds[part] = time;
  out["seconds"] = seconds;
}

py::dict run_solve(const py::object& problem, const py::object& settings) {
  const BoundProblem bound(problem, settings);
  std::unique_ptr<Model> model;
  Solution solution;
  try {
    py::gil_scoped_release free;
    model = std::make_unique<Model>(bound.tables, bound.options);
    solution = solve(*model, interrupted);
  } catch (const Interrupted&) {
    throw py::error_already_set();
  }
  py::dict out = rows_of(*model);
  add_record(out, solution);
  return out;
}

py::dict run_solve_parts(const py::iterable& parts, const py::object& settings, const std::optional<std::string>& folder) {
  const BoundParts bound(parts, settings, folder);
  std::deque<Model> models;
  Solution solution;
  try {
    py::gil_scoped_release free;
    solution = solve(bound.models(models), interrupted);
  } catch (const Interrupted&) {
    throw py::error_already_set();
  }
  py::list found;
  for (Model& model : models) {
    model.wake();
    found.append(rows_of(model));
    model.rest();
  }
  py::dict out;
  out["parts"] = found;
  add_record(out, solution);
  return out;
}

py::dict run_evaluate(const py::object& problem, const py::object& settings, bool jacobian) {
  const BoundProblem bound(problem, settings);
  std::unique_ptr<Model> model;
  Evaluation e;
  {
    py::gil_scoped_release free;
    model = std::make_unique<Model>(bound.tables, bound.options);
    e = evaluate(*model, jacobian);
  }
  py::dict out, columns, cost;
  for (int b = 0; jacobian && b < static_cast<int>(model->blocks().size()); ++b) {
    const Block& block = model->blocks()[b];
    if (block.tangent > 0) columns[model->name_of(b).c_str()] = py::make_tuple(block.column, block.tangent);
  }
  for (size_t k = 0; k < kKindNames.size(); ++k) cost[kKindNames[k]] = e.cost[k];
  out["residual"] = column<double>(e.residual), out["weight"] = column<double>(e.weight);
  out["factor"] = column<int32_t>(e.kind), out["table_row"] = column<int32_t>(e.table_row);
  out["jacobian_start"] = column<int64_t>(e.start), out["jacobian_column"] = column<int64_t>(e.column);
  out["jacobian_value"] = column<double>(e.value);
  out["width"] = model->columns();
  out["columns"] = columns, out["cost_by_factor"] = cost;
  return out;
}

py::dict marginals_of(const Model& model, const Covariance& c) {
  const auto n = model.poses(), l = static_cast<int64_t>(c.landmark.size()) / 9;
  const auto with_hull = static_cast<int64_t>(c.landmark_hull.size()) / 18;
  py::dict out;
  out["pose"] = column<double>(c.pose).reshape({n, int64_t{7}, int64_t{7}});
  out["pose_T_g_M"] = column<double>(c.pose_hull).reshape({n, int64_t{7}, int64_t{6}});
  out["landmark"] = column<double>(c.landmark).reshape({l, int64_t{3}, int64_t{3}});
  out["landmark_T_g_M"] = column<double>(c.landmark_hull).reshape({with_hull, int64_t{3}, int64_t{6}});
  out["deviation"] = column<double>(c.deviation);
  out["deviation_T_g_M"] = column<double>(c.deviation_hull).reshape({int64_t{model.nodes()}, int64_t{6}});
  for (const auto& [name, block] : c.global) out[name.c_str()] = block;
  py::dict leverage;
  for (size_t k = 0; k < kKindNames.size(); ++k) leverage[kKindNames[k]] = c.leverage[k];
  out["leverage_by_factor"] = leverage;
  return out;
}

py::dict run_covariance(const py::object& problem, const py::object& settings, bool of_landmarks) {
  const BoundProblem bound(problem, settings);
  std::unique_ptr<Model> model;
  Covariance c;
  {
    py::gil_scoped_release free;
    model = std::make_unique<Model>(bound.tables, bound.options);
    c = covariance(*model, of_landmarks);
  }
  return marginals_of(*model, c);
}

py::list run_covariance_parts(const py::iterable& parts, const py::object& settings, const std::optional<std::string>& folder,
                              bool of_landmarks) {
  const BoundParts bound(parts, settings, folder);
  std::deque<Model> models;
  std::vector<Covariance> all;
  {
    py::gil_scoped_release free;
    all = covariance(bound.models(models), of_landmarks);
  }
  py::list out;
  for (size_t k = 0; k < all.size(); ++k) {
    out.append(marginals_of(models[k], all[k]));
    all[k] = {};
  }
  return out;
}

py::dict run_pair_covariance(const py::object& problem, const py::object& which, const py::object& settings) {
  const BoundProblem bound(problem, settings);
  const auto pairs = read_pairs(which, bound.tables.pose.rows());
  PairCovariance c;
  {
    py::gil_scoped_release free;
    Model model(bound.tables, bound.options);
    c = pair_covariance(model, pairs);
  }
  const auto m = static_cast<int64_t>(pairs.size());
  py::dict out;
  out["pose"] = column<double>(c.pose).reshape({m, int64_t{14}, int64_t{14}});
  out["pose_T_s_ct"] = column<double>(c.pose_mount).reshape({m, int64_t{14}, int64_t{6}});
  out["T_s_ct"] = column<double>(c.mount).reshape({6, 6});
  return out;
}

}  // namespace

PYBIND11_MODULE(_native, m) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres tells its warnings to stderr; what matters comes back as an error
  py::register_exception_translator(translate);
  py::class_<MeshIndex>(m, "MeshIndex")
      .def(py::init(&make_index))
      .def("closest", &closest)
      .def("cast", &cast)
      .def("is_free", &is_free)
      .def("__len__", &MeshIndex::faces);
  bind_matching(m);
  bind_mosaic(m);
  m.def("draw_triangles", &draw_triangles, py::arg("picture").noconvert(), py::arg("points"), py::arg("faces"),
        py::arg("values"));
  m.def("solve", &run_solve);
  m.def("solve_parts", &run_solve_parts);
  m.def("evaluate", &run_evaluate);
  m.def("covariance", &run_covariance);
  m.def("covariance_parts", &run_covariance_parts);
  m.def("pair_covariance", &run_pair_covariance);
}

}  // namespace hullrecon
