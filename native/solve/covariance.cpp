// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/covariance.h"

#include <numeric>

#include "common/blas_guard.h"
#include "common/parallel.h"
#include "model/linear_factor.h"
#include "solve/scaled_information.h"

namespace hullrecon {
namespace {

// Names what the factors do not determine.
[[noreturn]] void refuse(const Model& model) {
  Information information(model);
  const ScaledInformation scaled(model, information);
  scaled.refuse(model, information);
}

void put(const Eigen::MatrixXd& block, double* out, int stride) {
  for (int r = 0; r < block.rows(); ++r) {
    for (int c = 0; c < block.cols(); ++c) out[r * stride + c] = block(r, c);
  }
}

// Entries of the inverse by blocks of the model.
class Inverse {
 public:
  explicit Inverse(const Schur& schur)
      : schur_(schur),
        layout_(schur.layout()),
        hull_(layout_.column(kHull)),
        border_(schur.covariance(layout_.blocks(), layout_.blocks())) {}

  bool has_hull() const { return hull_ >= 0; }
  Eigen::MatrixXd own(int block) const { return schur_.covariance(block, block); }  // of the layout
  Eigen::MatrixXd with_hull(int block) const {
    return schur_.covariance(layout_.blocks(), block).middleRows<6>(hull_).transpose();
  }
  bool has(const Model& model, int32_t b) const { return model.blocks()[b].tangent > 0 && layout_.block_of(b) >= 0; }
  Eigen::MatrixXd get(const Model& model, int32_t a, int32_t b) const {
    const int rows = model.blocks()[a].tangent, columns = model.blocks()[b].tangent;
    const int of_a = layout_.block_of(a), of_b = layout_.block_of(b), border = layout_.blocks();
    if (of_a == border && of_b == border) return border_.block(column(a), column(b), rows, columns);
    if (of_b == border) return schur_.covariance(of_a, border).middleCols(column(b), columns);
    if (of_a == border) return get(model, b, a).transpose();
    return schur_.covariance(of_a, of_b);
  }

 private:
  int column(int32_t global) const { return layout_.column(layout_.global_of(global)); }

  const Schur& schur_;
  const ReducedLayout& layout_;
  const int hull_;
  const Eigen::MatrixXd border_;
};

void poses_and_globals(const Model& model, const Schur& schur, const Inverse& z, Covariance& out) {
  const ReducedLayout& layout = schur.layout();
  out.pose.assign(model.poses() * 49, 0.0), out.pose_hull.assign(model.poses() * 42, 0.0);
  for (int i = 0; i < layout.poses(); ++i) {
    put(z.own(i), &out.pose[49 * static_cast<int64_t>(i)], 7);
    if (z.has_hull()) put(z.with_hull(i), &out.pose_hull[42 * static_cast<int64_t>(i)], 6);
  }
  for (int g = 0; g < kGlobals; ++g) {
    const int b = layout.model_global(g);
    const int width = model.blocks()[b].size == 7 ? 6 : model.blocks()[b].size;
    out.global[model.name_of(b)] = z.has(model, b) ? z.get(model, b, b) : Eigen::MatrixXd::Zero(width, width);
  }
  out.deviation.assign(model.nodes(), 0.0), out.deviation_hull.assign(static_cast<size_t>(model.nodes()) * 6, 0.0);
  for (int k = 0; k < layout.nodes(); ++k) {
    out.deviation[k] = z.own(layout.node(k))(0, 0);
    if (z.has_hull()) put(z.with_hull(layout.node(k)), &out.deviation_hull[6 * k], 6);
  }
}

// How many unknowns each kind of factor determines: what its residuals lose to the fit, in units of their variance.
void leverages(const Model& model, const Inverse& z, Covariance& out) {
  std::vector<double> trace(model.factors(), 0.0);
  for_slabs(model.factors(), model.options().threads, [&](int64_t begin, int64_t end) {
    LinearFactor linear;
    for (int64_t i = begin; i < end; ++i) {
      const Kind kind = model.kind_of(i);
      if (kind == Kind::Stereo || kind == Kind::Mono || kind == Kind::Surface) continue;
      linear.at(model, i);
      for (size_t a = 0; a < linear.blocks.size(); ++a) {
        for (size_t b = 0; z.has(model, linear.blocks[a]) && b <= a; ++b) {
          if (!z.has(model, linear.blocks[b])) continue;
          const Eigen::MatrixXd both = z.get(model, linear.blocks[a], linear.blocks[b]);
          trace[i] += (a == b ? 1 : 2) * (linear.by[a] * both).cwiseProduct(linear.by[b]).sum();
        }
      }
      trace[i] *= linear.weight * linear.weight;
    }
  });
  for (int64_t i = 0; i < model.factors(); ++i) out.leverage[static_cast<size_t>(model.kind_of(i))] += trace[i];
}

}  // namespace

Covariance covariance(Model& model, bool of_landmarks) {
  const BlasGuard guard;
  model.refresh(false, true);
  Schur schur(model);
  schur.linearise();
  if (!schur.condense(schur.no_damping()) || !schur.determines_all()) refuse(model);
  schur.invert();
  return marginals(model, schur, of_landmarks);
}

Covariance marginals(const Model& model, const Schur& schur, bool of_landmarks) {
  Covariance out;
  const Inverse z(schur);
  poses_and_globals(model, schur, z, out);
  leverages(model, z, out);
  if (!of_landmarks) return out;
  out.landmark.resize(model.landmarks() * 9);
  out.landmark_hull.resize(z.has_hull() ? model.landmarks() * 18 : 0);
  for_slabs(model.landmarks(), model.options().threads, [&](int64_t begin, int64_t end) {
    Schur::LandmarkCovariance found;
    for (int64_t r = begin; r < end; ++r) {
      schur.covariance_of_landmark(r, found);
      const int64_t l = schur.landmark(r);
      put(found.own, &out.landmark[9 * l], 3);
      if (z.has_hull()) put(found.with_hull, &out.landmark_hull[18 * l], 6);
    }
  });
  return out;
}

}  // namespace hullrecon
