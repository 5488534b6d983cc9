// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/covariance.h"

#include "common/blas_guard.h"
#include "common/errors.h"
#include "common/parallel.h"
#include "solve/scaled_information.h"
#include "sparse/selected_inversion.h"

namespace hullrecon {
namespace {

// Replaces the information by the entries of its inverse.
void invert(const Model& model, Information& information) {
  const ScaledInformation scaled(model, information);
  const std::vector<double>& scale = scaled.scale;
  try {
    const SelectedInverse inverse(scaled.lower);
    information.reduced().each_scalar([&](int r, int c, double& v) { v = inverse(r, c) * scale[r] * scale[c]; });
  } catch (const Singular&) {
    scaled.refuse(model, information);
  }
  BlockMatrix& m = information.reduced();  // each_scalar sees one half of a diagonal block
  for (int p = 0; p < m.blocks(); ++p) m.lower(p, p).triangularView<Eigen::StrictlyUpper>() = m.lower(p, p).transpose();
}

void put(const Eigen::MatrixXd& block, double* out, int stride) {
  for (int r = 0; r < block.rows(); ++r) {
    for (int c = 0; c < block.cols(); ++c) out[r * stride + c] = block(r, c);
  }
}

void poses_and_globals(const Model& model, const Information& information, Covariance& out) {
  const BlockMatrix& z = information.reduced();
  const int hull = information.position(model.block("T_g_M"));
  out.pose.assign(model.poses() * 49, 0.0), out.pose_hull.assign(model.poses() * 42, 0.0);
  for (int64_t i = 0; i < model.poses(); ++i) {
    const int p = information.position(static_cast<int>(i));
    put(z.get(p, p), &out.pose[49 * i], 7);
    if (hull >= 0) put(z.get(p, hull), &out.pose_hull[42 * i], 6);
  }
  for (int b = static_cast<int>(model.poses() + model.landmarks()); b < model.first_node(); ++b) {
    const int p = information.position(b);
    const int width = model.blocks()[b].size == 7 ? 6 : model.blocks()[b].size;
    out.global[model.blocks()[b].name] = p >= 0 ? z.get(p, p) : Eigen::MatrixXd::Zero(width, width);
  }
  const int nodes = model.nodes();
  out.deviation.assign(nodes, 0.0), out.deviation_hull.assign(static_cast<size_t>(nodes) * 6, 0.0);
  for (int k = 0; k < nodes; ++k) {
    const int p = information.position(model.first_node() + k);
    if (p < 0) continue;
    out.deviation[k] = z.get(p, p)(0, 0);
    if (hull >= 0) put(z.get(p, hull), &out.deviation_hull[6 * k], 6);
  }
}

// How many unknowns each kind of factor determines: what its residuals lose to the fit, in units of their variance.
void leverages(const Model& model, const Information& information, Covariance& out) {
  const BlockMatrix& z = information.reduced();
  LinearFactor linear;
  for (int64_t i : information.factors_of_no_landmark()) {
    linear.at(model, i);
    double trace = 0;
    for (size_t a = 0; a < linear.blocks.size(); ++a) {
      const int row = information.position(linear.blocks[a]);
      for (size_t b = 0; row >= 0 && b <= a; ++b) {
        const int column = information.position(linear.blocks[b]);
        if (column >= 0) trace += (a == b ? 1 : 2) * (linear.by[a] * z.get(row, column)).cwiseProduct(linear.by[b]).sum();
      }
    }
    out.leverage[static_cast<size_t>(model.kind_of(i))] += linear.weight * linear.weight * trace;
  }
}

// With H the coupling and K the inverse of its own information: K + K H Z H' K, and -K H Z against T_g_M.
void landmark(const Model& model, const Information& information, int64_t l, LandmarkInformation& own, LinearFactor& linear,
              Covariance& out) {
  const BlockMatrix& z = information.reduced();
  own.gather(model, information.factors_of(l), information.positions(), linear, nullptr);
  const Eigen::Matrix3d k = Information::invert(own, l);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (size_t a = 0; a < own.places.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      const Eigen::Matrix3d half = own.cross[a] * z.get(own.places[a], own.places[b]) * own.cross[b].transpose();
      spread += half + half.transpose();
    }
    spread += own.cross[a] * z.get(own.places[a], own.places[a]) * own.cross[a].transpose();
  }
  put(k + k * spread * k, &out.landmark[9 * l], 3);
  const int hull = information.position(model.block("T_g_M"));
  if (hull < 0) return;
  Eigen::Matrix<double, 3, 6> with_hull = Eigen::Matrix<double, 3, 6>::Zero();
  for (size_t a = 0; a < own.places.size(); ++a) with_hull -= k * own.cross[a] * z.get(own.places[a], hull);
  put(with_hull, &out.landmark_hull[18 * l], 6);
}

}  // namespace

Covariance covariance(Model& model) {
  const BlasGuard guard;
  model.refresh(false, true);
  Information information(model);
  invert(model, information);
  return marginals(model, information);
}

Covariance marginals(const Model& model, const Information& information) {
  Covariance out;
  poses_and_globals(model, information, out);
  leverages(model, information, out);
  out.landmark.resize(model.landmarks() * 9);
  out.landmark_hull.assign(model.landmarks() * 18, 0.0);
  for_slabs(model.landmarks(), model.options().threads, [&](int64_t begin, int64_t end) {
    LandmarkInformation own;
    LinearFactor linear;
    for (int64_t l = begin; l < end; ++l) landmark(model, information, l, own, linear, out);
  });
  return out;
}

}  // namespace hullrecon
