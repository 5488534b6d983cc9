// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/schur.h"

#include <algorithm>
#include <numeric>

#include "common/parallel.h"
#include "factors/manifolds.h"
#include "model/visit.h"

namespace hullrecon {

Schur::Schur(Model& model)
    : model_(model),
      kept_(model),
      sights_(model),
      small_(model, kept_),
      threads_(model.options().threads),
      optics_(sights_.optics().width()),
      hull_(kept_.at(kHull)),
      mount_(kept_.at(kCamera)) {
  sort_surface();
  find_pattern();
  const int64_t landmarks = model.landmarks(), poses = model.poses();
  own_.resize(poses), with_hull_.resize(poses);
  with_optics_.assign(poses, Eigen::Matrix<double, 6, Eigen::Dynamic>(6, optics_));
  eliminated_.resize(6, poses);
  inverse_.resize(landmarks), gain_.resize(3, landmarks), optics_cross_.resize(3, landmarks * optics_);
  for (Split* s : {&gradient_, &diagonal_}) s->landmark.resize(3 * landmarks), s->kept.resize(kept_.size());
}

void Schur::sort_surface() {
  const auto [first, end] = model_.factors_of(Kind::Surface);
  surface_start_.assign(model_.landmarks() + 1, 0);
  const auto rank_of = [&](int64_t row) { return sights_.rank(model_.tables().surface_landmark.data[row]); };
  for (int64_t f = first; f < end; ++f) ++surface_start_[rank_of(model_.row_of(f)) + 1];
  std::partial_sum(surface_start_.begin(), surface_start_.end(), surface_start_.begin());
  surface_.resize(end - first);
  std::vector<int32_t> next(surface_start_);
  for (int64_t f = first; f < end; ++f) {
    const auto row = static_cast<int32_t>(model_.row_of(f));
    const auto rank = static_cast<int32_t>(rank_of(row));
    surface_[next[rank]++] = {Vec3::Zero(), Vec3::Zero(), 0, 0, row, rank};
  }
  const int nodes = kept_.blocks() - kept_.poses();
  of_node_start_.assign(nodes + 1, 0);
  if (nodes == 0) return;
  for (const SurfaceRow& s : surface_) {
    for (int32_t node : model_.surface_nodes(s.row)) ++of_node_start_[node + 1];
  }
  std::partial_sum(of_node_start_.begin(), of_node_start_.end(), of_node_start_.begin());
  of_node_.resize(of_node_start_.back());
  std::vector<int32_t> at(of_node_start_);
  for (size_t k = 0; k < surface_.size(); ++k) {
    for (int32_t node : model_.surface_nodes(surface_[k].row)) of_node_[at[node]++] = static_cast<int32_t>(k);
  }
}

// The blocks that a landmark of this block, or a small factor, joins it to; itself left out, ascending.
std::vector<int32_t> Schur::neighbours_of(int block, std::vector<char>& met) const {
  std::vector<int32_t> out;
  const auto meet = [&](int32_t other) {
    if (met[other]) return;
    met[other] = 1;
    out.push_back(other);
  };
  const auto meet_nodes = [&](int64_t rank) {
    if (kept_.blocks() == kept_.poses()) return;
    for (const SurfaceRow& s : surfaces(rank)) {
      for (int32_t node : model_.surface_nodes(s.row)) meet(kept_.poses() + node);
    }
  };
  const auto meet_landmark = [&](int64_t rank) {
    for (int32_t w = sights_.first_view(rank); w < sights_.first_view(rank + 1); ++w) meet(sights_.view(w).pose);
    meet_nodes(rank);
  };
  met[block] = 1;
  if (block < kept_.poses()) {
    for (int32_t k = views_start_[block]; k < views_start_[block + 1]; ++k) meet_landmark(sights_.view(views_[k]).landmark);
  } else {
    const int node = block - kept_.poses();
    for (int32_t k = of_node_start_[node]; k < of_node_start_[node + 1]; ++k) meet_landmark(surface_[of_node_[k]].rank);
  }
  const auto by_landmarks = static_cast<int64_t>(out.size());
  for (int32_t f : small_.of_block(block)) {
    for (const SmallFactors::Part& part : small_.parts(f)) {
      if (part.border < 0) meet(part.block);
    }
  }
  met[block] = 0;
  for (int32_t other : out) met[other] = 0;
  std::sort(out.begin(), out.begin() + by_landmarks);
  out.insert(out.begin(), static_cast<int32_t>(by_landmarks));  // the first so many are of landmarks
  return out;
}

void Schur::find_pattern() {
  const int poses = kept_.poses(), blocks = kept_.blocks();
  views_start_.assign(poses + 1, 0), views_.resize(sights_.views());
  for (int64_t v = 0; v < sights_.views(); ++v) ++views_start_[sights_.view(v).pose + 1];
  std::partial_sum(views_start_.begin(), views_start_.end(), views_start_.begin());
  std::vector<int32_t> next(views_start_);
  for (int64_t v = 0; v < sights_.views(); ++v) views_[next[sights_.view(v).pose]++] = static_cast<int32_t>(v);
  std::vector<std::vector<int32_t>> neighbours(blocks);
  for_slabs(blocks, threads_, [&](int64_t begin, int64_t end) {
    std::vector<char> met(blocks, 0);
    for (int64_t b = begin; b < end; ++b) neighbours[b] = neighbours_of(static_cast<int>(b), met);
  });
  std::vector<int64_t> start{0};
  std::vector<int32_t> all;
  upper_start_.assign(1, 0), x_start_.assign(1, 0), lower_start_.assign(blocks + 1, 0);
  for (int b = 0; b < blocks; ++b) {
    const std::vector<int32_t>& met = neighbours[b];
    if (b < poses) upper_.push_back(b), x_start_.push_back(x_start_.back() + 36);
    for (int32_t k = 1; k <= met[0] && b < poses; ++k) {
      if (met[k] < b) continue;
      upper_.push_back(met[k]);
      x_start_.push_back(x_start_.back() + (met[k] < poses ? 36 : 6));
      ++lower_start_[met[k] + 1];
    }
    if (b < poses) upper_start_.push_back(static_cast<int64_t>(upper_.size()));
    all.insert(all.end(), met.begin() + 1, met.end());
    start.push_back(static_cast<int64_t>(all.size()));
    std::vector<int32_t>().swap(neighbours[b]);
  }
  x_.resize(x_start_.back());
  std::partial_sum(lower_start_.begin(), lower_start_.end(), lower_start_.begin());
  lower_.resize(lower_start_.back());
  std::vector<int64_t> at(lower_start_);
  for (int b = 0; b < poses; ++b) {
    for (int64_t k = upper_start_[b] + 1; k < upper_start_[b + 1]; ++k) lower_[at[upper_[k]]++] = {b, x_start_[k]};
  }
  std::vector<int> width(blocks);
  for (int b = 0; b < blocks; ++b) width[b] = kept_.width(b);
  reduced_ = std::make_unique<Reduced>(std::move(width), kept_.border(), start, all, threads_);
}

int Schur::optics_in_border(int column) const {
  const Optics& o = sights_.optics();
  for (const auto& [first, global] : {std::pair(o.lens(true), kBottomLens), {o.lens(false), kTopLens}, {o.bottom(), kBottom}}) {
    if (first >= 0 && column >= first) return kept_.at(global) + column - first;
  }
  return -1;
}

// Sums over fixed chunks, then the chunks in order: the same bytes for any number of threads.
Schur::Border Schur::chunked(int64_t count, int64_t chunk, const std::function<void(int64_t, Border&)>& work) const {
  const int width = kept_.border();
  const int64_t n = (count + chunk - 1) / chunk;
  std::vector<Border> sums(n);
  const auto slab = [&](int64_t begin, int64_t end) {
    for (int64_t c = begin; c < end; ++c) {
      sums[c] = {Eigen::MatrixXd::Zero(width, width), Eigen::VectorXd::Zero(width)};
      for (int64_t i = c * chunk; i < std::min(count, (c + 1) * chunk); ++i) work(i, sums[c]);
    }
  };
  for_slabs(n, threads_, slab, 1);
  Border total{Eigen::MatrixXd::Zero(width, width), Eigen::VectorXd::Zero(width)};
  for (const Border& sum : sums) total.own += sum.own, total.rhs += sum.rhs;
  return total;
}

double Schur::surface_residual(int64_t k, const Mat3& global_from_hull, const Vec3& origin, Vec3& n_global) const {
  const SurfaceRow& s = surface_[k];
  const Facet& facet = *model_.association().surface(s.row);
  const auto nodes = model_.surface_nodes(s.row);
  const FieldAt field = model_.surface_field(s.row);
  n_global.noalias() = global_from_hull * facet.normal;
  double r = n_global.dot(at(s.rank) - origin) + facet.offset;
  for (size_t m = 0; m < nodes.size(); ++m) r -= field.weight[m] * *model_.blocks()[model_.first_node() + nodes[m]].data;
  return r / model_.options().sigma_on;
}

double Schur::cost_of_surface() const {
  constexpr int64_t kChunk = 1024;
  const Motion hull(model_.blocks()[model_.block("T_g_M")].data);
  const Mat3 global_from_hull = hull.rotation();
  const auto count = static_cast<int64_t>(surface_.size()), chunks = (count + kChunk - 1) / kChunk;
  std::vector<double> sums(chunks, 0.0);
  const auto work = [&](int64_t begin, int64_t end) {
    double rho, slope;
    Vec3 normal;
    for (int64_t k = begin * kChunk; k < std::min(count, end * kChunk); ++k) {
      const double r = surface_residual(k, global_from_hull, hull.t, normal);
      const MixtureLoss loss = model_.surface_loss(surface_[k].row);
      Robust{Robust{}.huber, &loss}(r * r, rho, slope);
      sums[k / kChunk] += 0.5 * rho;
    }
  };
  for_slabs(chunks, threads_, work, 1);
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

std::optional<std::array<double, kKindNames.size()>> Schur::cost() {
  std::array<double, kKindNames.size()> sum{};
  if (!small_.cost(sum)) return std::nullopt;
  const auto sights = sights_.cost();
  sum[static_cast<size_t>(Kind::Stereo)] = sights[0], sum[static_cast<size_t>(Kind::Mono)] = sights[1];
  sum[static_cast<size_t>(Kind::Surface)] = cost_of_surface();
  if (!std::isfinite(std::accumulate(sum.begin(), sum.end(), 0.0))) return std::nullopt;
  return sum;
}

void Schur::plus(const std::vector<double>& from, const Split& step, std::vector<double>& to) const {
  to = from;
  const double* const base = model_.unknowns().data();
  const auto put = [&](int block, const double* delta) {
    const Block& b = model_.blocks()[block];
    const double* const x = from.data() + (b.data - base);
    double* const moved = to.data() + (b.data - base);
    if (b.size == 8 && b.tangent == 7) return void(PoseManifold().Plus(x, delta, moved));
    if (b.size == 8) return void(PoseTrayHeldManifold().Plus(x, delta, moved));
    if (b.size == 7) return void(RigidManifold().Plus(x, delta, moved));
    for (int k = 0; k < b.size; ++k) moved[k] = x[k] + delta[k];
  };
  for (int b = 0; b < kept_.blocks(); ++b) put(kept_.model_block(b), &step.kept[reduced_->offset(b)]);
  for (int g = 0; g < 7; ++g) {
    if (kept_.at(g) >= 0) put(model_.first_node() - 7 + g, &step.kept[reduced_->offset(kept_.blocks()) + kept_.at(g)]);
  }
  for (int64_t r = 0; r < model_.landmarks(); ++r)
    put(static_cast<int>(model_.poses()) + sights_.landmark(r), &step.landmark[3 * r]);
}

}  // namespace hullrecon
