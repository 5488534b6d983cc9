// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "schur/schur.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <numeric>
#include <utility>

#include "common/parallel.h"
#include "factors/manifolds.h"

namespace hullrecon {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point& start) {
  const auto now = Clock::now();
  return std::chrono::duration<double>(now - std::exchange(start, now)).count();
}

}  // namespace

Schur::Schur(Model& model, const std::optional<std::vector<int>>& interface, std::pmr::memory_resource* pages)
    : model_(model),
      layout_(model),
      images_(model, pages),
      surface_(model, images_, layout_),
      small_(model, layout_),
      threads_(model.options().threads),
      pattern_(layout_, images_, surface_, small_, threads_),
      reduced_(pattern_.reduced_system(interface, pages)),
      is_part_(interface.has_value()),
      intrinsics_(images_.intrinsics().width()),
      hull_(layout_.column(kHull)),
      mount_(layout_.column(kCamera)),
      intrinsics_cross_(pages),
      inverse_(pages),
      x_(pages) {
  const int64_t landmarks = model.landmarks(), poses = static_cast<int64_t>(images_.chains().size());
  x_.resize(pattern_.size());
  own_.resize(poses), with_hull_.resize(poses), eliminated_.resize(6, poses);
  with_intrinsics_.resize(6, poses * intrinsics_);
  inverse_.resize(landmarks), gain_.resize(3, landmarks), intrinsics_cross_.resize(3 * landmarks * intrinsics_);
  for (Global global : FreeIntrinsics::kBlocks) {
    for (int c = 0; c < model.blocks()[layout_.model_global(global)].tangent; ++c)
      intrinsics_in_border_.push_back(layout_.column(global) + c);
  }
  for (StepVector* s : {&gradient_, &diagonal_}) s->landmark.resize(3 * landmarks), s->reduced.resize(layout_.size());
}

void Schur::shelve(Shelf& shelf) {
  images_.shelve(shelf), surface_.shelve(shelf), small_.shelve(shelf), pattern_.shelve(shelf);
  gradient_.shelve(shelf), diagonal_.shelve(shelf);
  shelf.add(own_, gain_, eliminated_, with_hull_, with_intrinsics_);
}

std::optional<std::array<double, kKindNames.size()>> Schur::cost() {
  std::array<double, kKindNames.size()> sum{};
  if (!small_.cost(sum)) return std::nullopt;
  const auto images = images_.cost();
  sum[static_cast<size_t>(Kind::Stereo)] = images[0], sum[static_cast<size_t>(Kind::Mono)] = images[1];
  sum[static_cast<size_t>(Kind::Surface)] = surface_.cost();
  if (!std::isfinite(std::accumulate(sum.begin(), sum.end(), 0.0))) return std::nullopt;
  return sum;
}

bool Schur::condense(const StepVector& damping) {
  auto clock = Clock::now();
  if (!invert(damping)) return false;
  eliminate();
  reduced_->add_diagonal(damping.reduced);
  seconds.eliminate += since(clock);
  const bool definite = reduced_->factor();
  rhs_ = -rhs_;
  if (definite) reduced_->forward(rhs_);
  seconds.factor += since(clock);
  return definite;
}

bool Schur::finish(StepVector& out) {
  auto clock = Clock::now();
  out.reduced.resize(rhs_.size());
  const Eigen::Index found = is_part_ ? interior() : rhs_.size();
  out.reduced.head(found) = rhs_.head(found);
  reduced_->backward(out.reduced);
  seconds.factor += since(clock);
  if (!out.reduced.allFinite()) return false;
  back_substitute(out);
  seconds.back_substitute += since(clock);
  return out.landmark.allFinite();
}

// K of every landmark (6), by Cholesky: a landmark that hardly any direction determines needs the digits.
bool Schur::invert(const StepVector& damping) {
  std::atomic<bool> definite = true;
  for_slabs(model_.landmarks(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t r = begin; r < end; ++r) {
      Mat3 v = damping.landmark.segment<3>(3 * r).asDiagonal();
      for (const View& view : images_.views_of_landmark(r)) v += view.matrix();
      for (const SurfaceTerm& s : surface_.of_landmark(r)) v += s.n * s.n.transpose();
      const double a = std::sqrt(v(0, 0)), b = v(1, 0) / a, c = v(2, 0) / a, d = std::sqrt(v(1, 1) - b * b);
      const double e = (v(2, 1) - b * c) / d, f = std::sqrt(v(2, 2) - c * c - e * e);
      if (!(a > 0 && d > 0 && f > 0)) definite = false;
      const double ia = 1 / a, id = 1 / d, ig = 1 / f, ib = -b * ia * id, ie = -e * id * ig, ic = -(c * ia + e * ib) * ig;
      inverse_[r] = {ia * ia + ib * ib + ic * ic, ib * id + ic * ie, ic * ig, id * id + ie * ie, ie * ig, ig * ig};
      gain_.col(r) = inverse(r) * gradient_.landmark.segment<3>(3 * r);
    }
  });
  return definite;
}

// The landmarks' steps from those of the rest (14).
void Schur::back_substitute(StepVector& step) const {
  step.landmark.resize(3 * model_.landmarks());
  if (model_.landmarks() == 0) return;
  const int border = offset(layout_.blocks()), width = layout_.width(0);
  const Twist hull = hull_ >= 0 ? Twist(step.reduced.segment<6>(border + hull_)) : Twist(Twist::Zero());
  const Twist mount = mount_ >= 0 ? Twist(step.reduced.segment<6>(border + mount_)) : Twist(Twist::Zero());
  Eigen::VectorXd intrinsics(intrinsics_);
  for (int c = 0; c < intrinsics_; ++c) intrinsics[c] = step.reduced[border + intrinsics_in_border(c)];
  Mat6X twist(6, layout_.poses());
  for (int i = 0; i < layout_.poses(); ++i) {
    const CameraChain& chain = images_.chains()[i];
    twist.col(i) = chain.by_mount * mount + chain.by_pose.leftCols(width) * step.reduced.segment(offset(i), width);
  }
  for_slabs(model_.landmarks(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t r = begin; r < end; ++r) {
      const Vec3 landmark = at(r);
      Vec3 b = Vec3::Zero();
      for (const View& view : images_.views_of_landmark(r)) {
        b += view.matrix() * displacement(landmark - images_.chains()[view.pose].origin, twist.col(view.pose));
      }
      for (const SurfaceTerm& s : surface_.of_landmark(r)) {
        double moved = hull_ >= 0 ? s.by_hull().dot(hull) : 0.0;
        const auto nodes = surface_.nodes(s);
        const auto weights = surface_.weights(s);
        for (size_t k = 0; k < nodes.size() && layout_.nodes() > 0; ++k) {
          moved += s.by_field * weights[k] * step.reduced[offset(layout_.node(nodes[k]))];
        }
        b += s.n * moved;
      }
      if (intrinsics_ > 0) b += intrinsics_of(r) * intrinsics;
      step.landmark.segment<3>(3 * r) = -(gain_.col(r) + inverse(r) * b);
    }
  });
}

void Schur::plus(const std::vector<double>& from, const StepVector& step, std::vector<double>& to) const {
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
  for (int b = 0; b < layout_.blocks(); ++b) put(layout_.model_block(b), &step.reduced[offset(b)]);
  for (int g = 0; g < kGlobals; ++g) {
    if (layout_.column(g) >= 0) put(layout_.model_global(g), &step.reduced[offset(layout_.blocks()) + layout_.column(g)]);
  }
  for (int64_t r = 0; r < model_.landmarks(); ++r)
    put(static_cast<int>(model_.poses()) + images_.landmark(r), &step.landmark[3 * r]);
}

// Sums over fixed chunks, then the chunks in order: the same bytes for any number of threads.
Schur::Border Schur::chunked(int64_t count, int64_t chunk, const std::function<void(int64_t, Border&)>& work) const {
  const int width = layout_.border();
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

}  // namespace hullrecon
