// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/image_terms.h"

#include <algorithm>
#include <numeric>

#include "common/parallel.h"
#include "common/wide.h"
#include "factors/camera.h"

namespace hullrecon {

struct OneCamera {
  const double *intrinsics, *lens, *image_size;  // the last two null: no displacement
};

namespace {

constexpr int64_t kChunk = 1024;  // landmarks whose costs are summed before the chunks are, in order: the same for any threads

// One observation: rows (two, or four of a pair; 2 * images), whitened, not robustified.
struct Observation {
  Eigen::Vector4d r;
  Eigen::Matrix<double, 4, 3> by;  // apparent displacement of the landmark, in g
  Vec3 top, bottom;
  std::array<LensModes, 2> modes;  // of top and bottom, where lenses have a displacement
  int rows;
  bool in_front;
};

// One image's two rows.
template <bool kDerive>
bool image(const OneCamera& camera, const Vec3& point, const Mat3& camera_from_global, const double* measured,
           double inverse_sigma, int row, Observation& out, LensModes& modes) {
  Projection p;
  if (!project(camera.intrinsics, point, kDerive, p)) return false;
  if (camera.lens) modes = lens_modes(camera.image_size, measured), p.pixel -= displacement_px(camera.lens, modes);
  out.r.segment<2>(row) = inverse_sigma * (p.pixel - Eigen::Map<const Eigen::Vector2d>(measured));
  if (kDerive) out.by.middleRows<2>(row).noalias() = inverse_sigma * (p.by_point * camera_from_global);
  return true;
}

// square += left right', column by column.
HULLRECON_WIDE void add_square(const double* left, const double* right, double* __restrict square) {
  for (int column = 0; column < kLensModes; ++column) {
    for (int row = 0; row < kLensModes; ++row) square[column * kLensModes + row] += left[row] * right[column];
  }
}

// Adds the modes of a lens, times each of the three numbers of a row, to three runs that begin `stride` after one another.
HULLRECON_WIDE void add_modes(const double* row, const double* modes, int64_t stride, double* __restrict sum) {
  for (int k = 0; k < 3; ++k) {
    const double factor = row[k];
    double* const run = sum + k * stride;
    for (int mode = 0; mode < kLensModes; ++mode) run[mode] += factor * modes[mode];
  }
}

}  // namespace

FreeIntrinsics::FreeIntrinsics(const Model& model) {
  for (size_t k = 0; k < kBlocks.size(); ++k) {
    if (kBlocks[k] == kTopLens) before_lenses_ = width_;
    const int tangent = model.blocks()[model.poses() + model.landmarks() + kBlocks[k]].tangent;
    at_[k] = tangent > 0 ? width_ : -1;
    width_ += tangent;
  }
}

// The two cameras on the tray, at the present unknowns.
struct ImageTerms::Cameras {
  const Tables& tables;
  std::array<OneCamera, 2> camera;
  Motion bottom;
  Mat3 bottom_from_top;
  Robust pair, single;

  explicit Cameras(const Model& model)
      : tables(model.tables()),
        camera{camera_of(model, 0), camera_of(model, 1)},
        bottom(model.blocks()[model.block("T_ct_cb")].data),
        bottom_from_top(bottom.rotation().transpose()) {
    pair.huber = model.options().huber_stereo, single.huber = model.options().huber_mono;
  }

  static OneCamera camera_of(const Model& model, int k) {
    const auto data = [&](int global) { return model.blocks()[model.poses() + model.landmarks() + global].data; };
    if (!model.tables().has_lens()) return {data(kTopIntrinsics + k), nullptr, nullptr};
    return {data(kTopIntrinsics + k), data(kTopLens + k), model.tables().lens_image_size.row(k)};
  }

  double inverse_sigma(int32_t observation) const {
    const auto stereo = static_cast<int32_t>(tables.stereo_node.rows());
    return 1 / (observation < stereo ? tables.stereo_sigma_px(observation) : tables.mono_sigma_px(observation - stereo));
  }

  template <bool kDerive>
  void look(const CameraChain& chain, const Vec3& landmark, int32_t observation, Observation& out) const {
    const auto stereo = static_cast<int32_t>(tables.stereo_node.rows());
    const int32_t mono = observation - stereo;
    const bool both = mono < 0, above = both || tables.mono_camera.data[mono] == 0, below = both || !above;
    const double scale = inverse_sigma(observation);
    const double* measured = both ? tables.stereo_pixel.row(observation) : tables.mono_pixel.row(mono);
    out.top.noalias() = chain.camera_from_global * (landmark - chain.centre);
    out.rows = both ? 4 : 2;
    out.in_front = true;
    if (above)
      out.in_front = image<kDerive>(camera[0], out.top, chain.camera_from_global, measured, scale, 0, out, out.modes[0]);
    if (below) {
      out.bottom.noalias() = bottom_from_top * (out.top - bottom.t);
      const Mat3 bottom_from_global = kDerive ? Mat3(bottom_from_top * chain.camera_from_global) : Mat3();
      out.in_front &= image<kDerive>(camera[1], out.bottom, bottom_from_global, both ? measured + 2 : measured, scale,
                                     out.rows - 2, out, out.modes[1]);
    }
    if (out.in_front) return;
    out.r.setConstant(kBehindPixels * scale);
    out.by.setZero();
  }
  // Derivative of the rows, in px, by what is free of T_ct_cb and the intrinsics.
  void derive(const FreeIntrinsics& free, const Observation& s, bool above, bool below,
              Eigen::Matrix<double, 4, Eigen::Dynamic>& J) const {
    const int row = s.rows - 2;
    J.setZero();
    if (above && free.of_top() >= 0) J.block<2, 9>(0, free.of_top()) = by_intrinsics(camera[0].intrinsics, s.top);
    if (below && free.of_bottom() >= 0) J.block<2, 9>(row, free.of_bottom()) = by_intrinsics(camera[1].intrinsics, s.bottom);
    if (!below || free.mount() < 0) return;
    Projection p;
    project(camera[1].intrinsics, s.bottom, true, p);
    J.block<2, 6>(row, free.mount()) << -p.by_point * bottom_from_top, p.by_point * hat(s.bottom);
  }
  // Huber's cost of an observation and its slope, by the norm of all its rows.
  void robust(const Observation& s, double& rho, double& slope) const {
    if (s.rows == 4) return pair(s.r.squaredNorm(), rho, slope);
    single(s.r.head<2>().squaredNorm(), rho, slope);
  }
};

ImageTerms::ImageTerms(const Model& model, std::pmr::memory_resource* pages)
    : model_(model),
      intrinsics_(model),
      order_(pages),
      rank_(pages),
      view_start_(pages),
      observation_(pages),
      view_(pages),
      of_pose_(pages),
      of_stretch_(pages),
      chain_(model.landmarks() > 0 ? model.poses() : 0) {
  observation_.resize(model.tables().stereo_node.rows() + model.tables().mono_node.rows());
  sort_landmarks();
  sort_views();
}

int32_t ImageTerms::pose_of(int32_t observation) const {
  const Tables& t = model_.tables();
  const auto stereo = static_cast<int32_t>(t.stereo_node.rows());
  return observation < stereo ? t.stereo_node.data[observation] : t.mono_node.data[observation - stereo];
}

int32_t ImageTerms::landmark_of(int32_t observation) const {
  const Tables& t = model_.tables();
  const auto stereo = static_cast<int32_t>(t.stereo_node.rows());
  return observation < stereo ? t.stereo_landmark.data[observation] : t.mono_landmark.data[observation - stereo];
}

// Landmarks by the first pose that sees them.
void ImageTerms::sort_landmarks() {
  const int64_t landmarks = model_.landmarks();
  std::vector<int32_t> first(landmarks, static_cast<int32_t>(model_.poses()));
  for (int32_t s = 0; s < static_cast<int32_t>(observation_.size()); ++s) {
    first[landmark_of(s)] = std::min(first[landmark_of(s)], pose_of(s));
  }
  order_.resize(landmarks), rank_.resize(landmarks);
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(), [&](int32_t a, int32_t b) { return first[a] < first[b]; });
  for (int64_t r = 0; r < landmarks; ++r) rank_[order_[r]] = static_cast<int32_t>(r);
}

// Counting sorts: observations by landmark, those of a landmark by pose, and views by pose.
void ImageTerms::sort_views() {
  const int64_t landmarks = model_.landmarks();
  const auto count = static_cast<int32_t>(observation_.size());
  std::vector<int32_t> start(landmarks + 1);
  for (int32_t s = 0; s < count; ++s) ++start[rank_[landmark_of(s)] + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int32_t> next(start.begin(), start.end());
  for (int32_t s = 0; s < count; ++s) observation_[next[rank_[landmark_of(s)]]++] = s;
  view_.reserve(count + 1);
  view_start_.reserve(landmarks + 1);
  view_start_.assign(1, 0);
  for (int32_t r = 0; r < landmarks; ++r) {
    std::stable_sort(observation_.begin() + start[r], observation_.begin() + start[r + 1],
                     [&](int32_t a, int32_t b) { return pose_of(a) < pose_of(b); });
    for (int32_t k = start[r]; k < start[r + 1]; ++k) {
      const int32_t pose = pose_of(observation_[k]);
      if (k == start[r] || pose != view_.back().pose) view_.push_back({{}, Vec3::Zero(), pose, r, k});
    }
    view_start_.push_back(static_cast<int32_t>(view_.size()));
  }
  view_.push_back({{}, Vec3::Zero(), -1, -1, count});
  group_views(1, of_pose_start_, of_pose_);
  if (intrinsics_.width() > 0) group_views(kStretch, of_stretch_start_, of_stretch_);
}

void ImageTerms::group_views(int64_t poses, std::vector<int32_t>& start, std::pmr::vector<int32_t>& grouped) const {
  start.assign((model_.poses() + poses - 1) / poses + 1, 0), grouped.resize(views());
  for (int64_t v = 0; v < views(); ++v) ++start[view_[v].pose / poses + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int32_t> next(start);
  for (int64_t v = 0; v < views(); ++v) grouped[next[view_[v].pose / poses]++] = static_cast<int32_t>(v);
}

void ImageTerms::place_cameras() {
  const Motion mount(model_.blocks()[model_.block("T_s_ct")].data);
  const Vec3 tray(model_.tables().tray_origin.data);
  for_slabs(static_cast<int64_t>(chain_.size()), model_.options().threads, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) chain_[i] = CameraChain(model_.blocks()[i].data, mount, tray);
  });
  cameras_ = std::make_shared<const Cameras>(model_);
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

std::array<double, 2> ImageTerms::cost() {
  place_cameras();
  const Cameras& cameras = *cameras_;
  return summed(model_.landmarks(), model_.options().threads, [&](int64_t first, int64_t last, std::array<double, 2>& sum) {
    Observation s;
    double rho, slope;
    for (int64_t r = first; r < last; ++r) {
      const Vec3 landmark = model_.landmark(order_[r]);
      for (int32_t v = view_start_[r]; v < view_start_[r + 1]; ++v) {
        for (int32_t k = view_[v].first_observation; k < view_[v + 1].first_observation; ++k) {
          cameras.look<false>(chain_[view_[v].pose], landmark, observation_[k], s);
          cameras.robust(s, rho, slope);
          sum[s.rows == 2] += 0.5 * rho;
        }
      }
    }
  });
}

// Adds an observation's information on the landmark's displacement, robustified.
static void add(View& view, const Observation& s, double slope) {
  for (int row = 0; row < s.rows; ++row) {
    const double x = s.by(row, 0), y = s.by(row, 1), z = s.by(row, 2), wx = slope * x, wy = slope * y, wz = slope * z;
    view.information[0] += wx * x, view.information[1] += wx * y, view.information[2] += wx * z;
    view.information[3] += wy * y, view.information[4] += wy * z, view.information[5] += wz * z;
    view.gradient += s.r[row] * Vec3(wx, wy, wz);
  }
}

void ImageTerms::linearise() {
  place_cameras();
  if (intrinsics_.width() > 0) return;  // with each view's intrinsics
  const Cameras& cameras = *cameras_;
  const auto work = [&](int64_t begin, int64_t end) {
    Observation s;
    double rho, slope;
    for (int64_t v = begin; v < end; ++v) {
      View& view = view_[v];
      const Vec3 landmark = model_.landmark(order_[view.landmark]);
      view.information.fill(0), view.gradient.setZero();
      for (int32_t k = view.first_observation; k < view_[v + 1].first_observation; ++k) {
        cameras.look<true>(chain_[view.pose], landmark, observation_[k], s);
        cameras.robust(s, rho, slope);
        add(view, s, slope);
      }
    }
  };
  for_slabs(views(), model_.options().threads, work);
}

HULLRECON_WIDE_ALL void ImageTerms::linearise_with_intrinsics(int64_t v, WithIntrinsics& cross, OfIntrinsics& alone) {
  View& view = view_[v];
  view.information.fill(0), view.gradient.setZero();
  add_intrinsics(v, cross, &alone, [&](const Observation& s, double slope) { add(view, s, slope); });
}

HULLRECON_WIDE_ALL void ImageTerms::add_intrinsics(int64_t v, WithIntrinsics& cross) const {
  add_intrinsics(v, cross, nullptr, [](const Observation&, double) {});
}

// Calls each(observation, slope of its cost) of those that are in front.
template <class Each>
void ImageTerms::add_intrinsics(int64_t v, WithIntrinsics& cross, OfIntrinsics* alone, const Each& each) const {
  const Cameras& cameras = *cameras_;
  const View& view = view_[v];
  const Vec3 landmark = model_.landmark(order_[view.landmark]);
  Observation s;
  double rho, slope;
  const int width = intrinsics_.before_lenses();
  Eigen::Matrix<double, 4, Eigen::Dynamic> J(4, width);
  for (int32_t k = view.first_observation; k < view_[v + 1].first_observation; ++k) {
    cameras.look<true>(chain_[view.pose], landmark, observation_[k], s);
    if (!s.in_front) continue;
    cameras.robust(s, rho, slope);
    each(s, slope);
    const bool below =
        s.rows == 4 || model_.tables().mono_camera.data[observation_[k] - model_.tables().stereo_node.rows()] == 1;
    const bool above = s.rows == 4 || !below;
    const double inverse_sigma = cameras.inverse_sigma(observation_[k]);
    if (width > 0) cameras.derive(intrinsics_, s, above, below, J);
    J *= inverse_sigma;
    const auto rows = J.topRows(s.rows);
    cross.leftCols(width).noalias() += slope * s.by.topRows(s.rows).transpose() * rows;
    if (alone) alone->own.topLeftCorner(width, width).noalias() += slope * rows.transpose() * rows;
    if (alone) alone->gradient.head(width).noalias() += slope * rows.transpose() * s.r.head(s.rows);
    for (int camera = 0; camera < 2; ++camera) {
      const int first = intrinsics_.lens(camera), row = camera == 0 ? 0 : s.rows - 2;
      if (first < 0 || !(camera == 0 ? above : below)) continue;
      // Either row of an image meets the modes of its own axis alone, and both by the same numbers.
      const LensModes by = -inverse_sigma * s.modes[camera], weighted = slope * by;
      if (alone) add_square(weighted.data(), by.data(), alone->modes[camera].data());
      for (int axis = 0; axis < 2; ++axis) {
        const int at = first + axis * kLensModes;
        const Vec3 by_displacement = s.by.row(row + axis);
        add_modes(by_displacement.data(), weighted.data(), cross.cols(), cross.data() + at);
        if (!alone) continue;
        alone->own.block(at, 0, kLensModes, width).noalias() += weighted * J.row(row + axis);
        alone->gradient.segment<kLensModes>(at) += s.r[row + axis] * weighted;
      }
    }
  }
}

void ImageTerms::put_lenses(OfIntrinsics& alone) const {
  for (int camera = 0; camera < 2; ++camera) {
    const int first = intrinsics_.lens(camera);
    for (int at = first; first >= 0 && at < first + 2 * kLensModes; at += kLensModes) {
      alone.own.block<kLensModes, kLensModes>(at, at) = alone.modes[camera];
    }
  }
}

}  // namespace hullrecon
