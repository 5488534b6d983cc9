// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/blas_guard.h"
#include "common/errors.h"
#include "common/parallel.h"
#include "solve/information.h"
#include "sparse/selected_inversion.h"

namespace hullrecon {
namespace {

const char* coordinate(const Block& block, int k) {
  static constexpr std::array<const char*, 7> motion{"x", "y", "z", "rotation x", "rotation y", "rotation z", "tray angle"};
  static constexpr std::array<const char*, 6> navigation{"DVL scale",  "heading drift", "roll bias",
                                                         "pitch bias", "depth bias",    "tray backlash"};
  static constexpr std::array<const char*, 9> intrinsics{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  if (block.name == "navigation") return navigation[k];
  return block.size == 9 ? intrinsics[k] : block.size == 1 ? "offset" : motion[k];
}

std::string name_of(const Model& model, const Information& information, int scalar) {
  const BlockMatrix& m = information.reduced();
  int p = 0;
  while (m.offset(p + 1) <= scalar) ++p;
  const Block& block = model.blocks()[information.block_at(p)];
  return block.name + " " + coordinate(block, scalar - m.offset(p));
}

// The three largest entries of the direction that the information leaves free, in words.
[[noreturn]] void refuse(const Model& model, const Information& information, const std::vector<double>& scaled) {
  std::vector<int> order(scaled.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto larger = [&](int a, int b) { return std::abs(scaled[a]) > std::abs(scaled[b]); };
  const size_t shown = std::min<size_t>(3, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<long>(shown), order.end(), larger);
  std::string where;
  for (size_t k = 0; k < shown; ++k) where += (k ? ", " : "") + name_of(model, information, order[k]);
  throw StageError("the factors leave a direction undetermined, foremost in it", where, "add a prior or hold a block");
}

// The reduced information scaled to a unit diagonal, so that a pivot says what share of an unknown is determined.
Lower scaled_lower(const Model& model, Information& information, std::vector<double>& scale) {
  BlockMatrix& m = information.reduced();
  scale.assign(m.size(), 0.0);
  m.each_scalar([&](int r, int c, double& v) {
    if (r == c) scale[r] = v > 0 ? 1 / std::sqrt(v) : 0;
  });
  for (int i = 0; i < m.size(); ++i) {
    if (scale[i] > 0) continue;
    throw StageError("no factor determines it", name_of(model, information, i), "add a prior or hold the block");
  }
  Lower a;
  a.size = m.size();
  int column = -1;
  m.each_scalar([&](int r, int c, double& v) {
    for (; column < c; ++column) a.start.push_back(static_cast<int>(a.row.size()));
    a.row.push_back(r);
    a.value.push_back(r == c ? 1.0 : v * scale[r] * scale[c]);
  });
  a.start.push_back(static_cast<int>(a.row.size()));
  return a;
}

// Replaces the information by the entries of its inverse.
void invert(const Model& model, Information& information) {
  std::vector<double> scale;
  const Lower a = scaled_lower(model, information, scale);
  try {
    const SelectedInverse inverse(a);
    information.reduced().each_scalar([&](int r, int c, double& v) { v = inverse(r, c) * scale[r] * scale[c]; });
  } catch (const Singular&) {
    refuse(model, information, weakest_direction(a));
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
  const auto nodes = static_cast<int>(model.blocks().size()) - model.first_node();
  out.deviation.assign(nodes, 0.0), out.deviation_hull.assign(static_cast<size_t>(nodes) * 6, 0.0);
  for (int k = 0; k < nodes; ++k) {
    const int p = information.position(model.first_node() + k);
    if (p < 0) continue;
    out.deviation[k] = z.get(p, p)(0, 0);
    if (hull >= 0) put(z.get(p, hull), &out.deviation_hull[6 * k], 6);
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
  Covariance out;
  poses_and_globals(model, information, out);
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
