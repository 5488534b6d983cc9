// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Converts Problem and Options to tables, and our errors to those of hullrecon.errors.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "common/errors.h"
#include "model/tables.h"

namespace hullrecon {

namespace py = pybind11;

template <class Number>
Table<Number> table(const py::object& owner, const char* name, std::vector<py::object>& alive) {
  const py::object value = owner.attr(name);
  Table<Number> out{name};
  if (value.is_none()) return out;
  const py::array raw = py::array::ensure(value);
  const char kind = raw ? raw.dtype().kind() : '?';
  const bool integers = kind == 'i' || kind == 'u';
  if (!(integers || (std::is_same_v<Number, double> && kind == 'f'))) {
    throw InputError("the numbers are of the wrong type", name, "");
  }
  py::array_t<Number, py::array::c_style | py::array::forcecast> array(raw);
  out.shape.assign(array.shape(), array.shape() + array.ndim());
  out.data = array.data();
  alive.push_back(std::move(array));
  return out;
}

inline Tables read_tables(const py::object& problem, std::vector<py::object>& alive) {
  Tables t;
#define HULLRECON_READ(name) t.name = table<double>(problem, #name, alive);
  HULLRECON_FLOAT_TABLES(HULLRECON_READ)
#undef HULLRECON_READ
#define HULLRECON_READ(name) t.name = table<int32_t>(problem, #name, alive);
  HULLRECON_INT_TABLES(HULLRECON_READ)
#undef HULLRECON_READ
  t.constant = problem.attr("constant").cast<std::vector<std::string>>();
  t.sigma_px = problem.attr("sigma_px").cast<double>();
  return t;
}

inline Options read_options(const py::object& options) {
  Options o;
  const auto read = [&](const char* name, auto& field) {
    try {
      field = options.attr(name).cast<std::decay_t<decltype(field)>>();
    } catch (const py::cast_error&) {
      throw UsageError("it is of the wrong type", name, "");
    }
  };
  read("method", o.method), read("core", o.core), read("sigma_on", o.sigma_on), read("sigma_off", o.sigma_off);
  read("huber_stereo", o.huber_stereo), read("huber_mono", o.huber_mono), read("huber_range", o.huber_range);
  read("max_iterations", o.max_iterations), read("function_tolerance", o.function_tolerance),
      read("gradient_tolerance", o.gradient_tolerance);
  read("parameter_tolerance", o.parameter_tolerance), read("initial_radius", o.initial_radius), read("threads", o.threads);
  read("labels_in_solve", o.labels_in_solve);
  return o;
}

// Tables and options of a call, validated, with what keeps their arrays alive.
struct BoundProblem {
  std::vector<py::object> alive;
  Tables tables;
  Options options;

  BoundProblem(const py::object& problem, const py::object& settings)
      : tables(read_tables(problem, alive)), options(read_options(settings)) {
    py::gil_scoped_release free;
    validate(tables);
    validate(options);
  }
};

inline void raise(const char* type, const Error& error) {
  const py::object kind = py::module_::import("hullrecon.errors").attr(type);
  const py::object value = kind(error.what(), py::arg("where") = error.where, py::arg("remedy") = error.remedy);
  PyErr_SetObject(kind.ptr(), value.ptr());
}

inline void translate(std::exception_ptr pointer) {
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

}  // namespace hullrecon
