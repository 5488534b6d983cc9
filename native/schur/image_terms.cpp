// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/image_terms.h"

#include <algorithm>
#include <numeric>

#include "common/parallel.h"
#include "factors/camera.h"
#include "model/visit.h"

namespace hullrecon {
namespace {

constexpr int64_t kChunk = 1024;  // landmarks whose costs are summed before the chunks are, in order: the same for any threads

// What one sight says: rows (two, or four of a pair; 2 * images), whitened, not robustified.
struct Sight {
  Eigen::Vector4d r;
  Eigen::Matrix<double, 4, 3> by;  // apparent displacement of the landmark, in g
  Vec3 top, bottom;
  int rows;
  bool in_front;
};

// One image's two rows.
template <bool kDerive>
bool image(const double* lens, const Vec3& point, const Mat3& camera_from_global, const double* measured, double inverse_sigma,
           int row, Sight& out) {
  Projection p;
  if (!project(lens, point, kDerive, p)) return false;
  out.r.segment<2>(row) = inverse_sigma * (p.pixel - Eigen::Map<const Eigen::Vector2d>(measured));
  if (kDerive) out.by.middleRows<2>(row).noalias() = inverse_sigma * (p.by_point * camera_from_global);
  return true;
}

}  // namespace

Optics::Optics(const Model& model) {
  const char* const names[] = {"T_ct_cb", "intrinsics_top", "intrinsics_bottom"};
  for (int k = 0; k < 3; ++k) {
    const int tangent = model.blocks()[model.block(names[k])].tangent;
    at_[k] = tangent > 0 ? width_ : -1;
    width_ += tangent;
  }
}

// The eyes at the end of every arm, at the present unknowns.
struct Sights::Eyes {
  const Tables& tables;
  std::array<const double*, 2> lens;
  Motion bottom;
  Mat3 bottom_from_top;
  double inverse_sigma;
  Robust pair, single;

  explicit Eyes(const Model& model)
      : tables(model.tables()),
        lens{model.blocks()[model.block("intrinsics_top")].data, model.blocks()[model.block("intrinsics_bottom")].data},
        bottom(model.blocks()[model.block("T_ct_cb")].data),
        bottom_from_top(bottom.rotation().transpose()),
        inverse_sigma(1 / tables.sigma_px),
        pair{model.options().huber_stereo, nullptr},
        single{model.options().huber_mono, nullptr} {}

  template <bool kDerive>
  void look(const Arm& arm, const Vec3& landmark, int32_t sight, Sight& out) const {
    const auto stereo = static_cast<int32_t>(tables.stereo_node.rows());
    const int32_t mono = sight - stereo;
    const bool both = mono < 0, above = both || tables.mono_camera.data[mono] == 0, below = both || !above;
    const double* measured = both ? tables.stereo_pixel.row(sight) : tables.mono_pixel.row(mono);
    out.top.noalias() = arm.camera_from_global * (landmark - arm.centre);
    out.rows = both ? 4 : 2;
    out.in_front = true;
    if (above) out.in_front = image<kDerive>(lens[0], out.top, arm.camera_from_global, measured, inverse_sigma, 0, out);
    if (below) {
      out.bottom.noalias() = bottom_from_top * (out.top - bottom.t);
      const Mat3 chain = kDerive ? Mat3(bottom_from_top * arm.camera_from_global) : Mat3();
      out.in_front &=
          image<kDerive>(lens[1], out.bottom, chain, both ? measured + 2 : measured, inverse_sigma, out.rows - 2, out);
    }
    if (out.in_front) return;
    out.r.setConstant(kBehindPixels * inverse_sigma);
    out.by.setZero();
  }
  // Huber's cost of a sight and its slope, by the norm of all its rows.
  void robust(const Sight& s, double& rho, double& slope) const {
    if (s.rows == 4) return pair(s.r.squaredNorm(), rho, slope);
    single(s.r.head<2>().squaredNorm(), rho, slope);
  }
};

Sights::Sights(const Model& model) : model_(model), optics_(model), arm_(model.poses()) {
  sort();
}

// Counting sorts: sights by landmark, landmarks by their first pose, the sights of a landmark by pose.
void Sights::sort() {
  const Tables& t = model_.tables();
  const int64_t landmarks = model_.landmarks(), stereo = t.stereo_node.rows(), sights = stereo + t.mono_node.rows();
  const auto node = [&](int64_t s) { return s < stereo ? t.stereo_node.data[s] : t.mono_node.data[s - stereo]; };
  const auto seen = [&](int64_t s) { return s < stereo ? t.stereo_landmark.data[s] : t.mono_landmark.data[s - stereo]; };
  std::vector<int32_t> first(landmarks, static_cast<int32_t>(model_.poses()));
  for (int64_t s = 0; s < sights; ++s) first[seen(s)] = std::min(first[seen(s)], node(s));
  order_.resize(landmarks), rank_.resize(landmarks);
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(), [&](int32_t a, int32_t b) { return first[a] < first[b]; });
  for (int64_t r = 0; r < landmarks; ++r) rank_[order_[r]] = static_cast<int32_t>(r);
  std::vector<int32_t> start(landmarks + 1);
  for (int64_t s = 0; s < sights; ++s) ++start[rank_[seen(s)] + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  sight_.resize(sights);
  std::vector<int32_t> next(start.begin(), start.end());
  for (int64_t s = 0; s < sights; ++s) sight_[next[rank_[seen(s)]]++] = static_cast<int32_t>(s);
  view_.reserve(sights);
  view_start_.assign(1, 0);
  for (int32_t r = 0; r < landmarks; ++r) {
    std::stable_sort(sight_.begin() + start[r], sight_.begin() + start[r + 1],
                     [&](int32_t a, int32_t b) { return node(a) < node(b); });
    for (int32_t k = start[r]; k < start[r + 1]; ++k) {
      if (k == start[r] || node(sight_[k]) != view_.back().pose) view_.push_back({{}, Vec3::Zero(), node(sight_[k]), r, k});
    }
    view_start_.push_back(static_cast<int32_t>(view_.size()));
  }
  view_.push_back({{}, Vec3::Zero(), -1, -1, static_cast<int32_t>(sights)});  // the end of the last one's sights
}

void Sights::place_arms() {
  const Motion mount(model_.blocks()[model_.block("T_s_ct")].data);
  const Vec3 tray(model_.tables().tray_origin.data);
  for_slabs(model_.poses(), model_.options().threads, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) arm_[i] = Arm(model_.blocks()[i].data, mount, tray);
  });
}

// Chunks of landmarks in turn: work(first rank, last rank, sums of the chunk).
template <class Work>
static std::array<double, 2> summed(int64_t landmarks, int threads, const Work& work) {
  const int64_t chunks = (landmarks + kChunk - 1) / kChunk;
  std::vector<std::array<double, 2>> sums(chunks, {0, 0});
  const auto slab = [&](int64_t begin, int64_t end) {
    for (int64_t c = begin; c < end; ++c) work(c * kChunk, std::min(landmarks, (c + 1) * kChunk), sums[c]);
  };
  for_slabs(chunks, threads, slab, 1);
  std::array<double, 2> total{0, 0};
  for (const auto& chunk : sums) total[0] += chunk[0], total[1] += chunk[1];
  return total;
}

std::array<double, 2> Sights::cost() {
  place_arms();
  const Eyes eyes(model_);
  return summed(model_.landmarks(), model_.options().threads, [&](int64_t first, int64_t last, std::array<double, 2>& sum) {
    Sight s;
    double rho, slope;
    for (int64_t r = first; r < last; ++r) {
      const Vec3 landmark = model_.landmark(order_[r]);
      for (int32_t v = view_start_[r]; v < view_start_[r + 1]; ++v) {
        for (int32_t k = view_[v].first_sight; k < view_[v + 1].first_sight; ++k) {
          eyes.look<false>(arm_[view_[v].pose], landmark, sight_[k], s);
          eyes.robust(s, rho, slope);
          sum[s.rows == 2] += 0.5 * rho;
        }
      }
    }
  });
}

void Sights::linearise() {
  place_arms();
  const Eyes eyes(model_);
  const auto work = [&](int64_t begin, int64_t end) {
    Sight s;
    double rho, slope;
    for (int64_t v = begin; v < end; ++v) {
      View& view = view_[v];
      const Vec3 landmark = model_.landmark(order_[view.landmark]);
      view.information.fill(0), view.gradient.setZero();
      for (int32_t k = view.first_sight; k < view_[v + 1].first_sight; ++k) {
        eyes.look<true>(arm_[view.pose], landmark, sight_[k], s);
        eyes.robust(s, rho, slope);
        for (int row = 0; row < s.rows; ++row) {
          const double x = s.by(row, 0), y = s.by(row, 1), z = s.by(row, 2), wx = slope * x, wy = slope * y, wz = slope * z;
          view.information[0] += wx * x, view.information[1] += wx * y, view.information[2] += wx * z;
          view.information[3] += wy * y, view.information[4] += wy * z, view.information[5] += wz * z;
          view.gradient += s.r[row] * Vec3(wx, wy, wz);
        }
      }
    }
  };
  for_slabs(views(), model_.options().threads, work);
}

void Sights::by_optics(int64_t v, Eigen::Matrix3Xd& cross, Eigen::MatrixXd* own, Eigen::VectorXd* gradient) const {
  const Eyes eyes(model_);
  const View& view = view_[v];
  const Vec3 landmark = model_.landmark(order_[view.landmark]);
  Sight s;
  double rho, slope;
  Eigen::Matrix<double, 4, Eigen::Dynamic> J(4, optics_.width());
  for (int32_t k = view.first_sight; k < view_[v + 1].first_sight; ++k) {
    eyes.look<true>(arm_[view.pose], landmark, sight_[k], s);
    if (!s.in_front) continue;
    eyes.robust(s, rho, slope);
    J.setZero();
    const bool below = s.rows == 4 || model_.tables().mono_camera.data[sight_[k] - model_.tables().stereo_node.rows()] == 1;
    const bool above = s.rows == 4 || !below;
    const int row = s.rows - 2;
    if (above && optics_.lens(false) >= 0) J.block<2, 9>(0, optics_.lens(false)) = by_intrinsics(eyes.lens[0], s.top);
    if (below && optics_.lens(true) >= 0) J.block<2, 9>(row, optics_.lens(true)) = by_intrinsics(eyes.lens[1], s.bottom);
    if (below && optics_.bottom() >= 0) {
      Projection p;
      project(eyes.lens[1], s.bottom, true, p);
      J.block<2, 6>(row, optics_.bottom()) << -p.by_point * eyes.bottom_from_top, p.by_point * hat(s.bottom);
    }
    J *= eyes.inverse_sigma;
    const auto rows = J.topRows(s.rows);
    cross.noalias() += slope * s.by.topRows(s.rows).transpose() * rows;
    if (own) own->noalias() += slope * rows.transpose() * rows;
    if (gradient) gradient->noalias() += slope * rows.transpose() * s.r.head(s.rows);
  }
}

}  // namespace hullrecon
