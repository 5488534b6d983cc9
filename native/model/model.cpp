// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "model/model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/errors.h"
#include "common/parallel.h"

namespace hullrecon {
namespace {

constexpr std::array<const char*, kGlobals> kGlobalNames{"T_g_M",      "T_s_ct",         "T_ct_cb",           "T_s_d",
                                                         "navigation", "intrinsics_top", "intrinsics_bottom", "world",
                                                         "lens_top",   "lens_bottom"};

}  // namespace

std::shared_ptr<const MeshIndex> index_mesh(const Tables& t) {
  if (t.faces.rows() == 0 || t.surface_landmark.rows() + t.range_node.rows() == 0) return nullptr;
  std::vector<Vec3> vertices(t.vertices.rows());
  std::vector<std::array<int32_t, 3>> faces(t.faces.rows());
  for (size_t i = 0; i < vertices.size(); ++i) vertices[i] = Vec3(t.vertices.row(i));
  for (size_t i = 0; i < faces.size(); ++i) std::copy_n(t.faces.row(i), 3, faces[i].begin());
  return std::make_shared<const MeshIndex>(std::move(vertices), std::move(faces));
}

Model::Model(const Tables& tables, const Options& options, std::shared_ptr<const MeshIndex> mesh,
             std::pmr::memory_resource* pages)
    : tables_(tables),
      options_(options),
      mixture_(options.sigma_on, options.sigma_off),
      association_(mesh ? std::move(mesh) : index_mesh(tables), tables.surface_landmark.rows(), tables.range_node.rows(),
                   options.threads),
      shelf_(pages) {
  add_blocks();
  std::copy_n(intrinsics_, 18, intrinsics_start_.begin());
  number_factors();
  shelf_.add(blocks_, surface_rows_, field_rows_, held_labels_);
  association_.shelve(shelf_);
  for (NodeTable* nodes : {&range_nodes_, &surface_nodes_, &prior_nodes_}) nodes->shelve(shelf_);
}

void Model::add_block(double* data, int size, int tangent) {
  blocks_.push_back({data, size, tangent, tangent > 0 ? columns_ : -1});
  columns_ += tangent;
}

std::string Model::name_of(int block) const {
  const int landmark = static_cast<int>(poses()), global = landmark + static_cast<int>(landmarks());
  if (block < landmark) return "pose " + std::to_string(block);
  if (block < global) return "landmark " + std::to_string(block - landmark);
  if (block < first_node()) return kGlobalNames[block - global];
  if (block < first_plane()) return "deviation " + std::to_string(block - first_node());
  if (block < first_switch()) return "plane " + std::to_string(block - first_plane());
  return "link_switch " + std::to_string(block - first_switch());
}

void Model::add_blocks() {
  const Tables& t = tables_;
  std::vector<size_t> start;
  std::vector<const Table<double>*> tables{
      &t.pose,           &t.landmark,          &t.T_g_M,     &t.T_s_ct, &t.T_ct_cb,    &t.T_s_d, &t.navigation,
      &t.intrinsics_top, &t.intrinsics_bottom, &t.deviation, &t.plane,  &t.link_switch};
  if (t.places_world()) tables.push_back(&t.world);
  if (t.has_lens()) tables.insert(tables.end(), {&t.lens_top, &t.lens_bottom});
  for (const Table<double>* table : tables) {
    start.push_back(unknowns_.size());
    unknowns_.insert(unknowns_.end(), table->data, table->data + table->rows() * table->width());
  }
  double* const all = unknowns_.data();
  double *const pose = all, *const motion = all + start[2], *const deviation = all + start[9], *const plane = all + start[10],
                *const switches = all + start[11];
  landmark_ = all + start[1], intrinsics_ = all + start[7];
  blocks_.reserve(first_switch() + t.link_switch.rows());
  for (int64_t i = 0; i < poses(); ++i) add_block(&pose[8 * i], 8, t.held("tray") ? 6 : 7);
  for (int64_t i = 0; i < landmarks(); ++i) add_block(&landmark_[3 * i], 3, 3);
  const auto tangent = [&](const char* name, int width) { return t.held(name) ? 0 : width; };
  for (int k = 0; k < 4; ++k) add_block(&motion[7 * k], 7, tangent(kGlobalNames[k], 6));
  add_block(all + start[6], 6, tangent("navigation", 6));
  for (int k = 0; k < 2; ++k) add_block(&intrinsics_[9 * k], 9, tangent(kGlobalNames[kTopIntrinsics + k], 9));
  // A world that is held, and lenses without displacement, stay where they were given and are never written: norms of all
  // unknowns are sums over the array, and more numbers would change their last digits in problems that have none.
  double* const world = t.places_world() ? all + start[12] : const_cast<double*>(t.world.data);
  add_block(world, 3, t.places_world() ? 3 : 0);
  for (int k = 0; k < 2; ++k) {
    const char* const name = kGlobalNames[kTopLens + k];
    double* const given = const_cast<double*>((k == 0 ? t.lens_top : t.lens_bottom).data);
    double* const lens = t.has_lens() ? all + unknowns_.size() - (2 - k) * kLensNumbers : given;
    add_block(lens, kLensNumbers, t.has_lens() ? tangent(name, kLensNumbers) : 0);
  }
  for (int k = 0; k < nodes(); ++k) add_block(&deviation[k], 1, tangent("deviation", 1));
  for (int k = 0; k < planes(); ++k) add_block(&plane[3 * k], 3, 3);
  for (int64_t k = 0; k < t.link_switch.rows(); ++k) add_block(&switches[k], 1, 1);
}

int Model::block(const char* name) const {
  for (int k = 0; k < kGlobals; ++k) {
    if (std::string(kGlobalNames[k]) == name) return static_cast<int>(poses() + landmarks()) + k;
  }
  return -1;
}

void Model::number_factors() {
  const Tables& t = tables_;
  const std::array<const Table<double>*, 4> motions{&t.prior_T_g_M, &t.prior_T_s_ct, &t.prior_T_ct_cb, &t.prior_T_s_d};
  for (int k = 0; k < kWorld; ++k) {
    if (!t.held(kGlobalNames[k]) && (k >= 4 || motions[k]->rows() > 0)) global_priors_.push_back(k);
  }
  if (t.places_world()) global_priors_.push_back(kWorld);
  for (int k : {kTopLens, kBottomLens}) {
    if (t.has_lens() && !t.held(kGlobalNames[k])) global_priors_.push_back(k);
  }
  for (int64_t i = 0; i < t.range_field_index.rows(); ++i) {
    range_nodes_.add(t.range_field_index.row(i), t.range_field_weight.row(i), 4);
  }
  for (int64_t i = 0; i < t.surface_field_index.rows(); ++i) {
    surface_nodes_.add(t.surface_field_index.row(i), t.surface_field_weight.row(i), 4);
  }
  for (int32_t i = 0; !t.held("deviation") && i + 1 < t.field_prior_start.rows(); ++i) {
    const int32_t first = t.field_prior_start.data[i], count = t.field_prior_start.data[i + 1] - first;
    prior_nodes_.add(t.field_prior_index.data + first, t.field_prior_value.data + first, count);
    if (!prior_nodes_.nodes(i).empty()) field_rows_.push_back(i);
  }
  for (int32_t i = 0, next = 0; i < t.link_kernel.rows(); ++i) {
    switch_of_link_.push_back(t.link_kernel.data[i] == kSwitch ? next++ : -1);
  }
  hold_labels();
  for (int32_t i = 0; options_.method != "naive" && i < t.surface_landmark.rows(); ++i) {
    if (t.surface_weight.data[i] > 0) surface_rows_.push_back(i);
  }
  const std::array<int64_t, kKindNames.size()> counts{t.prior_pose_node.rows() + static_cast<int64_t>(global_priors_.size()),
                                                      t.attitude_node.rows(),
                                                      t.tray_node.rows(),
                                                      t.odometry_first.rows(),
                                                      t.stereo_node.rows(),
                                                      t.mono_node.rows(),
                                                      t.range_node.rows(),
                                                      static_cast<int64_t>(surface_rows_.size()),
                                                      static_cast<int64_t>(field_rows_.size()),
                                                      t.link_first.rows(),
                                                      t.sighting_node.rows(),
                                                      t.pair_first.rows(),
                                                      t.plane_range_node.rows(),
                                                      t.velocity_first.rows(),
                                                      t.position_node.rows()};
  for (size_t k = 0; k < counts.size(); ++k) first_[k + 1] = first_[k] + counts[k];
}

void Model::hold_labels() {
  const int64_t rows = tables_.surface_landmark.rows();
  if (options_.method == "naive") held_labels_.assign(rows, 0);
  if (options_.method == "geva") held_labels_.assign(rows, 1);
  if (options_.method == "maxmix" && !options_.labels_in_solve && rows > 0) {
    refresh(false, true);
    held_labels_ = labels();
  }
}

std::pair<int64_t, int64_t> Model::factors_of(Kind kind) const {
  return {first_[static_cast<size_t>(kind)], first_[static_cast<size_t>(kind) + 1]};
}

Kind Model::kind_of(int64_t factor) const {
  return static_cast<Kind>(std::upper_bound(first_.begin(), first_.end(), factor) - first_.begin() - 1);
}

int64_t Model::row_of(int64_t factor) const {
  const Kind kind = kind_of(factor);
  const int64_t i = number_of(factor);
  if (kind == Kind::Prior) return i < tables_.prior_pose_node.rows() ? i : 0;
  return kind == Kind::Surface ? surface_rows_[i] : kind == Kind::Deviation ? field_rows_[i] : i;
}

void Model::blocks_of(int64_t factor, std::vector<int32_t>& out) const {
  const Tables& t = tables_;
  const auto landmark = static_cast<int32_t>(poses()), global = static_cast<int32_t>(landmark + landmarks());
  const Kind kind = kind_of(factor);
  const int64_t i = row_of(factor), number = number_of(factor);
  const auto anchor = [&](int32_t plane) { return t.plane_anchor.data[plane]; };
  const auto also = [&](std::span<const int32_t> nodes) {
    for (int32_t node : nodes) out.push_back(first_node() + node);
  };
  switch (kind) {
    case Kind::Prior:
      out.assign(1, number < t.prior_pose_node.rows() ? t.prior_pose_node.data[number]
                                                      : global + global_priors_[number - t.prior_pose_node.rows()]);
      break;
    case Kind::Attitude:
      out = {t.attitude_node.data[i], global + kNavigation};
      break;
    case Kind::Tray:
      out = {t.tray_node.data[i], global + kNavigation};
      break;
    case Kind::Odometry:
      out = {t.odometry_first.data[i], t.odometry_second.data[i], global + kNavigation, global + kDvl};
      break;
    case Kind::Stereo:
      out = {landmark + t.stereo_landmark.data[i],
             t.stereo_node.data[i],
             global + kCamera,
             global + kBottom,
             global + kTopIntrinsics,
             global + kBottomIntrinsics};
      if (t.has_lens()) out.insert(out.end(), {global + kTopLens, global + kBottomLens});
      break;
    case Kind::Mono:
      out = {landmark + t.mono_landmark.data[i], t.mono_node.data[i], global + kCamera, global + kTopIntrinsics};
      if (t.mono_camera.data[i] == 1) out[3] = global + kBottomIntrinsics, out.push_back(global + kBottom);
      if (t.has_lens()) out.push_back(global + (t.mono_camera.data[i] == 1 ? kBottomLens : kTopLens));
      break;
    case Kind::Range:
      out = {t.range_node.data[i], global + kHull, global + kDvl};
      also(range_nodes_.nodes(i));
      break;
    case Kind::Surface:
      out = {landmark + t.surface_landmark.data[i], global + kHull};
      also(surface_nodes_.nodes(i));
      break;
    case Kind::Deviation:
      out.clear();
      also(prior_nodes_.nodes(i));
      break;
    case Kind::Link:
      out = {t.link_first.data[i], t.link_second.data[i], global + kCamera};
      if (t.link_camera_first.data[i] == 1 || t.link_camera_second.data[i] == 1) out.push_back(global + kBottom);
      if (switch_of_link_[i] >= 0) out.push_back(first_switch() + switch_of_link_[i]);
      break;
    case Kind::Plane:
      out = {first_plane() + t.sighting_plane.data[i]};
      if (t.sighting_node.data[i] != anchor(t.sighting_plane.data[i]))
        out.insert(out.end(), {t.sighting_node.data[i], anchor(t.sighting_plane.data[i])});
      break;
    case Kind::PlanePair: {
      const int32_t first = t.pair_first.data[i], second = t.pair_second.data[i];
      out = {first_plane() + first, first_plane() + second};
      if (anchor(first) != anchor(second)) out.insert(out.end(), {anchor(first), anchor(second)});
      break;
    }
    case Kind::PlaneRange: {
      const int32_t node = t.plane_range_node.data[i], plane = t.plane_range_plane.data[i];
      out = {first_plane() + plane, node, global + kDvl};
      if (node != anchor(plane)) out.push_back(anchor(plane));
      break;
    }
    case Kind::Velocity:
      out = {t.velocity_first.data[i], t.velocity_second.data[i], t.velocity_third.data[i]};
      break;
    case Kind::Position:
      out = {t.position_node.data[i], global + kWorld};
      break;
  }
}

Robust Model::robust(int64_t factor) const {
  Robust out;
  switch (kind_of(factor)) {
    case Kind::Stereo:
      out.huber = options_.huber_stereo;
      break;
    case Kind::Mono:
      out.huber = options_.huber_mono;
      break;
    case Kind::Range:
    case Kind::PlaneRange:
      out.huber = options_.huber_range;
      break;
    case Kind::Position:
      out.huber = options_.huber_position;
      break;
    case Kind::Surface:
      out.mixture = surface_loss(row_of(factor));
      break;
    case Kind::Link:
      if (tables_.link_kernel.data[row_of(factor)] == kScaling) out.scaling = options_.link_phi;
      break;
    default:
      break;
  }
  return out;
}

MixtureLoss Model::surface_loss(int64_t row) const {
  const Label label = held_labels_.empty() ? Label::Free : held_labels_[row] ? Label::On : Label::Off;
  return MixtureLoss(mixture_, label, tables_.surface_weight.data[row]);
}

// --- at the present point: associations, labels, costs ---

void Model::refresh(bool trial, bool surface_too) {
  const double *const hull_data = blocks_[block("T_g_M")].data, *const mount = blocks_[block("T_s_d")].data;
  const Motion hull(hull_data);
  const Mat3 hull_from_global = hull.rotation().transpose();
  if (surface_too || options_.method != "naive") {
    association_.refresh_surface(
        [&](int64_t i) { return Vec3(hull_from_global * (landmark(tables_.surface_landmark.data[i]) - hull.t)); });
  }
  const auto cast = [&](int64_t i) {
    const double* const x[] = {blocks_[tables_.range_node.data[i]].data, hull_data, mount};
    return ray(i, x);
  };
  association_.refresh_range(cast, trial);
}

std::vector<int32_t> Model::labels() const {
  if (!held_labels_.empty()) return held_labels_;
  std::vector<int32_t> out(tables_.surface_landmark.rows());
  for (int64_t i = 0; i < tables_.surface_landmark.rows(); ++i) {
    const auto nodes = surface_nodes_.nodes(i);
    const FieldAt at = surface_nodes_.at(i);
    double field = 0;
    for (size_t k = 0; k < nodes.size(); ++k) field += at.weight[k] * *blocks_[first_node() + nodes[k]].data;
    out[i] = mixture_.on(association_.distance()[i] - field);
  }
  return out;
}

std::array<double, kKindNames.size()> Model::costs() const {
  constexpr int64_t kChunk = 4096;  // sums are formed over fixed chunks, then in order: the same for any threads
  const int64_t count = factors(), chunks = (count + kChunk - 1) / kChunk;
  std::vector<std::array<double, kKindNames.size()>> sums(chunks, {0.0});
  const auto one = [&](int64_t i, std::vector<int32_t>& blocks, std::vector<const double*>& x) {
    blocks_of(i, blocks);
    x.clear();
    for (int32_t b : blocks) x.push_back(blocks_[b].data);
    double rho = 0, slope;
    double r[kMostRows];
    if (evaluate(i, {}, x.data(), r, nullptr)) robust(i)(std::inner_product(r, r + rows_of(i), r, 0.0), rho, slope);
    return 0.5 * rho;
  };
  const auto work = [&](int64_t begin, int64_t end) {
    std::vector<int32_t> blocks;
    std::vector<const double*> x;
    for (int64_t c = begin; c < end; ++c) {
      for (int64_t i = c * kChunk; i < std::min(count, (c + 1) * kChunk); ++i) {
        sums[c][static_cast<int>(kind_of(i))] += one(i, blocks, x);
      }
    }
  };
  for_slabs(chunks, options_.threads, work, 1);
  std::array<double, kKindNames.size()> total{};
  for (const auto& chunk : sums) {
    for (size_t k = 0; k < total.size(); ++k) total[k] += chunk[k];
  }
  return total;
}

}  // namespace hullrecon
