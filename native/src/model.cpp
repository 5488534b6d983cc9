// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "hullrecon/model.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "hullrecon/cost.h"
#include "hullrecon/errors.h"

namespace hullrecon {
namespace {

enum Global { kHull, kCamera, kBottom, kDvl, kNavigation, kTopLens, kBottomLens };
constexpr std::array<const char*, 7> kGlobals{"T_g_M",      "T_s_ct",         "T_ct_cb",          "T_s_d",
                                              "navigation", "intrinsics_top", "intrinsics_bottom"};

std::unique_ptr<MeshIndex> mesh(const Tables& t) {
  if (t.faces.rows() == 0 || t.surface_landmark.rows() + t.range_node.rows() == 0) return nullptr;
  std::vector<Vec3> vertices(t.vertices.rows());
  std::vector<std::array<int32_t, 3>> faces(t.faces.rows());
  for (size_t i = 0; i < vertices.size(); ++i) vertices[i] = Vec3(t.vertices.row(i));
  for (size_t i = 0; i < faces.size(); ++i) std::copy_n(t.faces.row(i), 3, faces[i].begin());
  return std::make_unique<MeshIndex>(std::move(vertices), std::move(faces));
}

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> matrix(const double* data) {
  return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>>(data);
}

template <int N>
Diagonal<N> diagonal(const double* sigma) {
  return {matrix<N, 1>(sigma).cwiseInverse()};
}

}  // namespace

Model::Model(const Tables& tables, const Options& options)
    : tables_(tables),
      options_(options),
      mixture_{options.sigma_on, options.sigma_off},
      association_(mesh(tables), tables.surface_landmark.rows(), tables.range_node.rows(), options.threads) {
  add_blocks();
  add_priors();
  add_navigation();
  add_images();
  add_ranges();
  add_surface();
  add_field_prior();
}

void Model::add_block(double* data, int size, int tangent, std::string name) {
  blocks_.push_back({data, size, tangent, tangent > 0 ? columns_ : -1, std::move(name)});
  columns_ += tangent;
}

void Model::add_blocks() {
  const Tables& t = tables_;
  std::vector<size_t> start;
  for (const Table<double>* table : {&t.pose, &t.landmark, &t.T_g_M, &t.T_s_ct, &t.T_ct_cb, &t.T_s_d, &t.navigation,
                                     &t.intrinsics_top, &t.intrinsics_bottom, &t.deviation}) {
    start.push_back(unknowns_.size());
    unknowns_.insert(unknowns_.end(), table->data, table->data + table->rows() * table->width());
  }
  double* const all = unknowns_.data();
  double *const pose = all, *const motion = all + start[2], *const deviation = all + start[9];
  landmark_ = all + start[1], intrinsics_ = all + start[7];
  for (int64_t i = 0; i < poses(); ++i) add_block(&pose[8 * i], 8, t.held("tray") ? 6 : 7, "pose " + std::to_string(i));
  for (int64_t i = 0; i < landmarks(); ++i) add_block(&landmark_[3 * i], 3, 3, "landmark " + std::to_string(i));
  const auto tangent = [&](const char* name, int width) { return t.held(name) ? 0 : width; };
  for (int k = 0; k < 4; ++k) add_block(&motion[7 * k], 7, tangent(kGlobals[k], 6), kGlobals[k]);
  add_block(all + start[6], 6, tangent("navigation", 6), "navigation");
  for (int k = 0; k < 2; ++k) add_block(&intrinsics_[9 * k], 9, tangent(kGlobals[kTopLens + k], 9), kGlobals[kTopLens + k]);
  for (size_t k = 0; k < unknowns_.size() - start[9]; ++k)
    add_block(&deviation[k], 1, tangent("deviation", 1), "deviation " + std::to_string(k));
}

int Model::block(const char* name) const {
  for (int k = 0; k < 7; ++k) {
    if (std::string(kGlobals[k]) == name) return static_cast<int>(poses() + landmarks()) + k;
  }
  return -1;
}

template <class Residual, class Whitening>
void Model::add(Kind kind, int64_t row, Residual residual, Whitening whitening, const ceres::LossFunction* loss,
                std::vector<int32_t> blocks) {
  using Made = Cost<Residual, Whitening>;
  factors_.push_back({std::make_unique<Made>(std::move(residual), std::move(whitening)), loss, kind, row, std::move(blocks)});
}

void Model::add_priors() {
  const Tables& t = tables_;
  const auto global = [&](int k) { return static_cast<int32_t>(poses() + landmarks() + k); };
  for (int64_t i = 0; i < t.prior_pose_node.rows(); ++i) {
    add(Kind::Prior, i, MotionPrior<8>{Motion(t.prior_pose.row(i))}, Full<6>{matrix<6, 6>(t.prior_pose_sqrt.row(i))}, nullptr,
        {t.prior_pose_node.data[i]});
  }
  const std::array<std::pair<const Table<double>*, const Table<double>*>, 4> motions{{{&t.prior_T_g_M, &t.prior_T_g_M_sqrt},
                                                                                      {&t.prior_T_s_ct, &t.prior_T_s_ct_sqrt},
                                                                                      {&t.prior_T_ct_cb, &t.prior_T_ct_cb_sqrt},
                                                                                      {&t.prior_T_s_d, &t.prior_T_s_d_sqrt}}};
  for (int k = 0; k < 4; ++k) {
    if (motions[k].first->rows() == 0 || t.held(kGlobals[k])) continue;
    add(Kind::Prior, 0, MotionPrior<7>{Motion(motions[k].first->data)}, Full<6>{matrix<6, 6>(motions[k].second->data)}, nullptr,
        {global(k)});
  }
  if (!t.held("navigation")) {
    add(Kind::Prior, 0, VectorPrior<6>{{}}, diagonal<6>(t.prior_navigation_sigma.data), nullptr, {global(kNavigation)});
  }
  for (int k : {kTopLens, kBottomLens}) {
    if (t.held(kGlobals[k])) continue;
    std::array<double, 9> start;
    std::copy_n(&intrinsics_[9 * (k - kTopLens)], 9, start.begin());
    add(Kind::Prior, 0, VectorPrior<9>{start}, diagonal<9>(t.prior_intrinsics_sigma.data), nullptr, {global(k)});
  }
}

void Model::add_navigation() {
  const Tables& t = tables_;
  const int32_t navigation = block("navigation"), dvl = block("T_s_d");
  const Vec3 pressure(t.pressure_origin.data);
  for (int64_t i = 0; i < t.attitude_node.rows(); ++i) {
    add(Kind::Attitude, i, Attitude{pressure, Vec3(t.attitude_measured.row(i))}, diagonal<3>(t.attitude_sigma.row(i)), nullptr,
        {t.attitude_node.data[i], navigation});
  }
  for (int64_t i = 0; i < t.tray_node.rows(); ++i) {
    add(Kind::Tray, i, Tray{t.tray_measured.data[i], t.tray_direction.data[i]}, Scalar{1 / t.tray_sigma.data[i]}, nullptr,
        {t.tray_node.data[i], navigation});
  }
  for (int64_t i = 0; i < t.odometry_first.rows(); ++i) {
    Odometry o{Motion(t.odometry_measured.row(i)),
               matrix<6, 2>(t.odometry_by_navigation.row(i)),
               matrix<6, 3>(t.odometry_by_mount.row(i)),
               matrix<6, 1>(t.odometry_by_tray.row(i)),
               t.odometry_tray.data[i],
               Motion(t.odometry_mount.data).q};
    add(Kind::Odometry, i, o, Full<6>{matrix<6, 6>(t.odometry_sqrt.row(i))}, nullptr,
        {t.odometry_first.data[i], t.odometry_second.data[i], navigation, dvl});
  }
}

void Model::add_images() {
  const Tables& t = tables_;
  const auto landmark = static_cast<int32_t>(poses()), camera = block("T_s_ct"), bottom = block("T_ct_cb");
  const int32_t top_lens = block("intrinsics_top"), bottom_lens = block("intrinsics_bottom");
  const Vec3 tray(t.tray_origin.data);
  const Scalar white{1 / t.sigma_px};
  const ceres::LossFunction* huber = nullptr;
  if (std::isfinite(options_.huber_pixel)) huber = losses_.emplace_back(new ceres::HuberLoss(options_.huber_pixel)).get();
  for (int64_t i = 0; i < t.stereo_node.rows(); ++i) {
    add(Kind::Stereo, i, Stereo{tray, matrix<4, 1>(t.stereo_pixel.row(i))}, white, huber,
        {landmark + t.stereo_landmark.data[i], t.stereo_node.data[i], camera, bottom, top_lens, bottom_lens});
  }
  for (int64_t i = 0; i < t.mono_node.rows(); ++i) {
    const bool below = t.mono_camera.data[i] == 1;
    std::vector<int32_t> at{landmark + t.mono_landmark.data[i], t.mono_node.data[i], camera, below ? bottom_lens : top_lens};
    if (below) at.push_back(bottom);
    add(Kind::Mono, i, Mono{tray, matrix<2, 1>(t.mono_pixel.row(i)), below}, white, huber, std::move(at));
  }
}

// Nodes at equal index are one, in ascending order, and nodes without weight are left out: a factor names a block once.
FieldAt Model::field_at(const int32_t* index, const double* weight, int64_t count, std::vector<int32_t>& blocks) const {
  std::map<int32_t, double> nodes;
  for (int64_t k = 0; k < count; ++k) nodes[index[k]] += weight[k];
  FieldAt field;
  for (const auto& [node, share] : nodes) {
    if (share == 0) continue;
    blocks.push_back(first_node() + node);
    field.weight.push_back(share);
  }
  return field;
}

void Model::add_ranges() {
  const Tables& t = tables_;
  const ceres::LossFunction* huber = nullptr;
  if (std::isfinite(options_.huber_range)) huber = losses_.emplace_back(new ceres::HuberLoss(options_.huber_range)).get();
  for (int64_t i = 0; i < t.range_node.rows(); ++i) {
    std::vector<int32_t> at{t.range_node.data[i], block("T_g_M"), block("T_s_d")};
    const bool field = t.range_field_index.rows() > 0;
    FieldAt nodes = field ? field_at(t.range_field_index.row(i), t.range_field_weight.row(i), 4, at) : FieldAt{};
    rays_.push_back({Motion(t.range_offset.row(i)), t.range_tray_offset.data[i], Vec3(t.range_beam.row(i)).normalized(),
                     Vec3(t.tray_origin.data), t.range_measured.data[i], std::move(nodes), association_.range(i),
                     association_.refused()});
    ray_blocks_.push_back({blocks_[at[0]].data, blocks_[at[1]].data, blocks_[at[2]].data});
    add(Kind::Range, i, rays_.back(), Scalar{1 / t.range_sigma.data[i]}, huber, std::move(at));
  }
}

const ceres::LossFunction* Model::mixture_loss(Label label, double weight) {
  const std::pair key(label, weight);
  if (!mixture_losses_.empty() && mixture_losses_.back().first == key) return mixture_losses_.back().second;
  const auto* made = losses_.emplace_back(new MixtureLoss(mixture_, label, weight)).get();
  mixture_losses_.assign(1, {key, made});
  return made;
}

void Model::add_surface() {
  const Tables& t = tables_;
  const int64_t rows = t.surface_landmark.rows();
  for (int64_t i = 0; i < rows; ++i) {
    auto& nodes = surface_nodes_.emplace_back();
    const bool field = t.surface_field_index.rows() > 0;
    surface_field_.push_back(field ? field_at(t.surface_field_index.row(i), t.surface_field_weight.row(i), 4, nodes)
                                   : FieldAt{});
  }
  if (options_.method == "naive") held_labels_.assign(rows, 0);
  if (options_.method == "geva") held_labels_.assign(rows, 1);
  if (options_.method == "maxmix" && !options_.labels_in_solve && rows > 0) {
    refresh(false, true);
    held_labels_ = labels();
  }
  if (options_.method == "naive") return;
  for (int64_t i = 0; i < rows; ++i) {
    const double weight = t.surface_weight.data[i];
    if (weight == 0) continue;
    const Label label = held_labels_.empty() ? Label::Free : held_labels_[i] ? Label::On : Label::Off;
    std::vector<int32_t> at{static_cast<int32_t>(poses()) + t.surface_landmark.data[i], block("T_g_M")};
    at.insert(at.end(), surface_nodes_[i].begin(), surface_nodes_[i].end());
    add(Kind::Surface, i, Surface{surface_field_[i], association_.surface(i)}, Scalar{1 / options_.sigma_on},
        mixture_loss(label, weight), std::move(at));
  }
}

void Model::add_field_prior() {
  const Tables& t = tables_;
  if (t.held("deviation")) return;
  for (int64_t i = 0; i + 1 < t.field_prior_start.rows(); ++i) {
    const int32_t first = t.field_prior_start.data[i], count = t.field_prior_start.data[i + 1] - first;
    std::vector<int32_t> at;
    FieldAt row = field_at(t.field_prior_index.data + first, t.field_prior_value.data + first, count, at);
    if (!at.empty()) add(Kind::Deviation, i, FieldPrior{std::move(row)}, Scalar{1.0}, nullptr, std::move(at));
  }
}

void Model::refresh(bool trial, bool surface_too) {
  const Motion hull(blocks_[block("T_g_M")].data);
  if (surface_too || options_.method != "naive") {
    association_.refresh_surface(
        [&](int64_t i) { return hull.to_child(Vec3(&landmark_[3 * tables_.surface_landmark.data[i]])); });
  }
  const auto ray = [&](int64_t i) {
    const Beam beam = rays_[i].at(ray_blocks_[i].data(), 0);
    return std::pair(beam.end_hull, beam.along_hull);
  };
  association_.refresh_range(ray, trial);
}

std::vector<int32_t> Model::labels() const {
  if (!held_labels_.empty()) return held_labels_;
  std::vector<int32_t> out(surface_field_.size());
  for (size_t i = 0; i < out.size(); ++i) {
    double field = 0;
    for (size_t k = 0; k < surface_nodes_[i].size(); ++k)
      field += surface_field_[i].weight[k] * *blocks_[surface_nodes_[i][k]].data;
    out[i] = mixture_.on(association_.distance()[i] - field);
  }
  return out;
}

std::array<double, kKindNames.size()> Model::costs() const {
  constexpr int64_t kChunk = 4096;  // sums are formed over fixed chunks, then in order: the same for any threads
  const auto count = static_cast<int64_t>(factors_.size()), chunks = (count + kChunk - 1) / kChunk;
  std::vector<std::array<double, kKindNames.size()>> sums(chunks, {0.0});
  const auto one = [&](const Factor& f) {
    std::vector<const double*> x;
    for (int32_t b : f.blocks) x.push_back(blocks_[b].data);
    double r[9], rho[3];
    if (!f.cost->Evaluate(x.data(), r, nullptr)) return 0.0;
    const double s = Eigen::Map<Eigen::VectorXd>(r, f.cost->num_residuals()).squaredNorm();
    if (!f.loss) return 0.5 * s;
    f.loss->Evaluate(s, rho);
    return 0.5 * rho[0];
  };
  const auto work = [&](int64_t begin, int64_t end) {
    for (int64_t c = begin; c < end; ++c) {
      for (int64_t i = c * kChunk; i < std::min(count, (c + 1) * kChunk); ++i) {
        sums[c][static_cast<int>(factors_[i].kind)] += one(factors_[i]);
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
