// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Converts Problem and Options to tables, and our errors to those of hullrecon.errors.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/errors.h"
#include "common/free_memory.h"
#include "model/tables.h"
#include "solve/joined_problem.h"

namespace hullrecon {

namespace py = pybind11;

// Reads arrays of a Problem by path ("stereo.pixel"), which is what errors about them name.
class TableReader {
 public:
  TableReader(const py::object& problem, std::vector<py::object>& alive) : problem_(problem), alive_(alive) {}

  // An array left out (None, or a field of a part that is None) stays empty. mask: of True and False.
  template <class Number>
  void read(Table<Number>& table, const char* path, bool mask = false) const {
    table.name = path;
    const py::object value = attribute(path);
    if (value.is_none()) return;
    const py::array raw = py::array::ensure(value);
    const char kind = raw ? raw.dtype().kind() : '?';
    const bool integers = mask ? kind == 'b' : kind == 'i' || kind == 'u';
    if (!(integers || (std::is_same_v<Number, double> && kind == 'f'))) {
      throw InputError("the numbers are of the wrong type", path, "");
    }
    py::array_t<Number, py::array::c_style | py::array::forcecast> array(raw);
    table.shape.assign(array.shape(), array.shape() + array.ndim());
    table.data = array.data();
    alive_.push_back(std::move(array));
  }

 private:
  py::object attribute(const std::string& path) const {
    py::object value = problem_;
    for (size_t begin = 0; begin < path.size() && !value.is_none();) {
      const size_t end = std::min(path.find('.', begin), path.size());
      value = value.attr(path.substr(begin, end - begin).c_str());
      begin = end + 1;
    }
    return value;
  }

  const py::object& problem_;
  std::vector<py::object>& alive_;
};

inline void read_unknowns(const TableReader& from, Tables& t) {
  from.read(t.pose, "unknowns.pose"), from.read(t.landmark, "unknowns.landmark");
  from.read(t.T_g_M, "unknowns.T_g_M"), from.read(t.T_s_ct, "unknowns.T_s_ct");
  from.read(t.T_ct_cb, "unknowns.T_ct_cb"), from.read(t.T_s_d, "unknowns.T_s_d");
  from.read(t.navigation, "unknowns.navigation"), from.read(t.deviation, "unknowns.deviation");
  from.read(t.intrinsics_top, "unknowns.intrinsics_top"), from.read(t.intrinsics_bottom, "unknowns.intrinsics_bottom");
}

inline void read_priors(const TableReader& from, Tables& t) {
  from.read(t.prior_pose_node, "priors.pose.node"), from.read(t.prior_pose, "priors.pose.value");
  from.read(t.prior_pose_sqrt, "priors.pose.sqrt_information");
  from.read(t.prior_T_g_M, "priors.T_g_M.value"), from.read(t.prior_T_g_M_sqrt, "priors.T_g_M.sqrt_information");
  from.read(t.prior_T_s_ct, "priors.T_s_ct.value"), from.read(t.prior_T_s_ct_sqrt, "priors.T_s_ct.sqrt_information");
  from.read(t.prior_T_ct_cb, "priors.T_ct_cb.value"), from.read(t.prior_T_ct_cb_sqrt, "priors.T_ct_cb.sqrt_information");
  from.read(t.prior_T_s_d, "priors.T_s_d.value"), from.read(t.prior_T_s_d_sqrt, "priors.T_s_d.sqrt_information");
  from.read(t.prior_navigation_sigma, "priors.navigation_sigma");
  from.read(t.prior_intrinsics_sigma, "priors.intrinsics_sigma");
  from.read(t.field_prior_start, "priors.deviation.start"), from.read(t.field_prior_index, "priors.deviation.index");
  from.read(t.field_prior_value, "priors.deviation.value");
}

inline void read_navigation(const TableReader& from, Tables& t) {
  from.read(t.attitude_node, "attitude.node"), from.read(t.attitude_measured, "attitude.measured");
  from.read(t.attitude_sigma, "attitude.sigma");
  from.read(t.tray_node, "tray.node"), from.read(t.tray_measured, "tray.measured");
  from.read(t.tray_direction, "tray.direction"), from.read(t.tray_sigma, "tray.sigma");
  from.read(t.odometry_first, "odometry.first"), from.read(t.odometry_second, "odometry.second");
  from.read(t.odometry_measured, "odometry.measured"), from.read(t.odometry_sqrt, "odometry.sqrt_information");
  from.read(t.odometry_by_navigation, "odometry.by_navigation"), from.read(t.odometry_by_mount, "odometry.by_mount");
  from.read(t.odometry_by_tray, "odometry.by_tray"), from.read(t.odometry_tray, "odometry.tray");
  from.read(t.odometry_mount, "odometry.mount");
}

inline void read_images(const TableReader& from, Tables& t) {
  from.read(t.stereo_node, "stereo.node"), from.read(t.stereo_landmark, "stereo.landmark");
  from.read(t.stereo_pixel, "stereo.pixel"), from.read(t.stereo_sigma_ratio, "stereo.sigma_ratio");
  from.read(t.mono_node, "mono.node"), from.read(t.mono_landmark, "mono.landmark");
  from.read(t.mono_camera, "mono.camera"), from.read(t.mono_pixel, "mono.pixel");
  from.read(t.mono_sigma_ratio, "mono.sigma_ratio");
}

inline void read_links(const TableReader& from, Tables& t) {
  from.read(t.link_switch, "unknowns.link_switch");
  from.read(t.link_first, "links.first"), from.read(t.link_second, "links.second");
  from.read(t.link_camera_first, "links.camera_first"), from.read(t.link_camera_second, "links.camera_second");
  from.read(t.link_measured, "links.measured"), from.read(t.link_sqrt, "links.sqrt_information");
  from.read(t.link_scaled, "links.scaled", true), from.read(t.link_kernel, "links.kernel");
}

inline void read_planes(const TableReader& from, Tables& t) {
  from.read(t.plane, "unknowns.plane"), from.read(t.plane_anchor, "planes.anchor");
  from.read(t.sighting_node, "plane_sightings.node"), from.read(t.sighting_plane, "plane_sightings.plane");
  from.read(t.sighting_measured, "plane_sightings.measured"), from.read(t.sighting_sqrt, "plane_sightings.sqrt_information");
  from.read(t.pair_first, "plane_pairs.first"), from.read(t.pair_second, "plane_pairs.second");
  from.read(t.pair_measured, "plane_pairs.measured"), from.read(t.pair_sqrt, "plane_pairs.sqrt_information");
  from.read(t.pair_point, "plane_pairs.point"), from.read(t.pair_place, "plane_pairs.place");
  from.read(t.pair_by_place, "plane_pairs.by_place");
  from.read(t.plane_range_node, "plane_ranges.node"), from.read(t.plane_range_plane, "plane_ranges.plane");
  from.read(t.plane_range_offset, "plane_ranges.offset"), from.read(t.plane_range_tray_offset, "plane_ranges.tray_offset");
  from.read(t.plane_range_beam, "plane_ranges.beam"), from.read(t.plane_range_measured, "plane_ranges.measured");
  from.read(t.plane_range_sigma, "plane_ranges.sigma");
}

inline void read_velocities(const TableReader& from, Tables& t) {
  from.read(t.velocity_first, "velocities.first"), from.read(t.velocity_second, "velocities.second");
  from.read(t.velocity_third, "velocities.third"), from.read(t.velocity_before, "velocities.before");
  from.read(t.velocity_after, "velocities.after"), from.read(t.velocity_sigma, "velocities.sigma");
}

inline void read_positions(const TableReader& from, Tables& t) {
  from.read(t.world, "unknowns.world"), from.read(t.prior_world_sigma, "priors.world_sigma");
  from.read(t.position_node, "positions.node"), from.read(t.position_antenna, "positions.antenna");
  from.read(t.position_measured, "positions.measured"), from.read(t.position_sigma, "positions.sigma");
}

inline void read_lenses(const TableReader& from, Tables& t) {
  from.read(t.lens_top, "unknowns.lens_top"), from.read(t.lens_bottom, "unknowns.lens_bottom");
  from.read(t.lens_image_size, "lenses.image_size"), from.read(t.lens_sigma, "lenses.sigma_px");
  from.read(t.lens_expected, "lenses.expected_px");
}

inline void read_hull(const TableReader& from, Tables& t) {
  from.read(t.vertices, "cad_mesh.vertices"), from.read(t.faces, "cad_mesh.faces");
  from.read(t.tray_origin, "lever_arms.tray"), from.read(t.pressure_origin, "lever_arms.pressure");
  from.read(t.range_node, "ranges.node"), from.read(t.range_offset, "ranges.offset");
  from.read(t.range_tray_offset, "ranges.tray_offset"), from.read(t.range_beam, "ranges.beam");
  from.read(t.range_measured, "ranges.measured"), from.read(t.range_sigma, "ranges.sigma");
  from.read(t.range_field_index, "ranges.field.index"), from.read(t.range_field_weight, "ranges.field.weight");
  from.read(t.surface_landmark, "surface.landmark"), from.read(t.surface_weight, "surface.weight");
  from.read(t.surface_field_index, "surface.field.index"), from.read(t.surface_field_weight, "surface.field.weight");
}

inline Tables read_tables(const py::object& problem, std::vector<py::object>& alive) {
  Tables t;
  const TableReader from(problem, alive);
  read_unknowns(from, t);
  read_priors(from, t);
  read_navigation(from, t);
  read_images(from, t);
  read_hull(from, t);
  read_links(from, t);
  read_planes(from, t);
  read_velocities(from, t);
  read_positions(from, t);
  read_lenses(from, t);
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
  read("huber_position", o.huber_position);
  read("link_phi", o.link_phi);
  read("max_iterations", o.max_iterations), read("function_tolerance", o.function_tolerance),
      read("gradient_tolerance", o.gradient_tolerance);
  read("parameter_tolerance", o.parameter_tolerance), read("initial_radius", o.initial_radius), read("threads", o.threads);
  read("labels_in_solve", o.labels_in_solve);
  return o;
}

// A checked problem, and what keeps its arrays alive.
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

// Checked parts of a problem (hullrecon/native/parts.py), with what each shares. With a folder their tables are copied to files
// in it, and the arrays are left: parts may be made one after the other.
class BoundParts {
 public:
  BoundParts(const py::iterable& parts, const py::object& settings, const std::optional<std::string>& folder) {
    for (const py::handle part : parts) {
      BoundProblem& bound = problems_.emplace_back(part.attr("problem"), settings);
      if (folder) pages_.push_back(std::make_unique<PageFile>(*folder)), move(bound, *pages_.back());
      shared_.push_back(
          {rows(part, "shared_poses"), rows(part, "shared_nodes"), rows(part, "shared_planes"), rows(part, "shared_switches")});
    }
  }

  // Makes the models of the parts, which refer to them.
  std::vector<ProblemPart> models(std::deque<Model>& models) const {
    std::vector<ProblemPart> out;
    std::shared_ptr<const MeshIndex> mesh;  // the CAD model is one for all
    for (size_t k = 0; k < problems_.size(); ++k) {
      if (!mesh) mesh = index_mesh(problems_[k].tables);
      PageFile* const pages = pages_.empty() ? nullptr : pages_[k].get();
      Model& model = models.emplace_back(problems_[k].tables, problems_[k].options, mesh, pages);
      const std::array<std::pair<int, int64_t>, 4> kinds{{{0, model.poses()},
                                                          {model.first_node(), model.nodes()},
                                                          {model.first_plane(), model.planes()},
                                                          {model.first_switch(), model.tables().link_switch.rows()}}};
      model.rest();
      if (pages) pages->rest(), return_free_memory();
      out.push_back({&model, {}, pages});
      for (size_t kind = 0; kind < kinds.size(); ++kind) {
        for (const auto& [row, number] : shared_[k][kind]) {
          if (row < 0 || row >= kinds[kind].second)
            throw InputError("row " + std::to_string(row) + " of part " + std::to_string(k) + " is not there", "parts", "");
          out.back().shared.push_back({kinds[kind].first + row, number});
        }
      }
    }
    return out;
  }

 private:
  using Shared = std::vector<std::array<int32_t, 2>>;
  static Shared rows(const py::handle part, const char* name) {
    const py::array_t<int32_t, py::array::c_style | py::array::forcecast> array(part.attr(name));
    if (array.ndim() != 2 || array.shape(1) != 2) throw InputError("the array must be (m, 2)", name, "");
    Shared out(array.shape(0));
    for (size_t k = 0; k < out.size(); ++k) out[k] = {array.at(k, 0), array.at(k, 1)};
    return out;
  }

  template <class Number>
  static void move(Table<Number>& table, PageFile& to) {
    const auto count = static_cast<size_t>(table.rows() * table.width());
    if (count == 0) return;
    auto* const at = static_cast<Number*>(to.allocate(count * sizeof(Number), alignof(Number)));
    std::copy_n(table.data, count, at);
    table.data = at;
  }
  static void move(BoundProblem& bound, PageFile& to) {
    Tables& t = bound.tables;
#define HULLRECON_MOVE(name) move(t.name, to);
    HULLRECON_FLOAT_TABLES(HULLRECON_MOVE)
    HULLRECON_INT_TABLES(HULLRECON_MOVE)
#undef HULLRECON_MOVE
    bound.alive.clear();
    to.rest();
  }

  std::deque<BoundProblem> problems_;
  std::vector<std::unique_ptr<PageFile>> pages_;  // of each; none: all in memory
  std::vector<std::array<Shared, 4>> shared_;     // poses, nodes, planes, switches: rows and numbers
};

// Pairs of poses, (m, 2).
inline std::vector<std::array<int32_t, 2>> read_pairs(const py::object& value, int64_t poses) {
  const py::array raw = py::array::ensure(value);
  const char kind = raw ? raw.dtype().kind() : '?';
  if (kind != 'i' && kind != 'u') throw InputError("the numbers are of the wrong type", "pairs", "");
  if (raw.ndim() != 2 || raw.shape(1) != 2) throw InputError("the array must be (m, 2)", "pairs", "");
  const py::array_t<int64_t, py::array::c_style | py::array::forcecast> array(raw);
  std::vector<std::array<int32_t, 2>> out(array.shape(0));
  for (size_t k = 0; k < out.size(); ++k) {
    for (int e = 0; e < 2; ++e) {
      const int64_t i = array.at(k, e);
      if (i < 0 || i >= poses)
        throw InputError(
            "pose " + std::to_string(i) + " of row " + std::to_string(k) + " is not below " + std::to_string(poses), "pairs",
            "");
      out[k][e] = static_cast<int32_t>(i);
    }
  }
  return out;
}

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
  } catch (const DiskError& error) {
    errno = error.number;
    PyErr_SetFromErrnoWithFilename(PyExc_OSError, error.where.c_str());
  }
}

}  // namespace hullrecon
