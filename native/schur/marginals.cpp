// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Covariances of landmarks from those of the rest (docs/schur.md, 19).
#include <algorithm>

#include "schur/schur.h"

namespace hullrecon {

bool Schur::determines_all() const {
  constexpr double kVanished = 1e-12;  // of a pivot: below it is rounding
  constexpr double kFlat = 1e14;       // product of the traces of a landmark's information and of its inverse
  if (!(reduced_->least_pivot() > kVanished)) return false;
  for (int64_t r = 0; r < model_.landmarks(); ++r) {
    const auto& k = inverse_[r];
    if (!((k[0] + k[3] + k[5]) * diagonal_.landmark.segment<3>(3 * r).sum() < kFlat)) return false;
  }
  return true;
}

// With H between the landmark and the rest, and Z the rest's covariance: K + K H Z H' K, and -K H Z against T_g_M (19).
void Schur::covariance_of_landmark(int64_t rank, LandmarkCovariance& out) const {
  auto& [own, with_hull, block, column, cross, spread] = out;
  const auto views = images_.views_of_landmark(rank);
  const auto terms = surface_.of_landmark(rank);
  const int border = layout_.blocks(), width = layout_.width(0);
  block.clear(), column.clear();
  int columns = 0;
  const auto place = [&](int b, int wide) {
    const auto at = std::find(block.begin(), block.end(), b) - block.begin();
    if (at < static_cast<ptrdiff_t>(block.size())) return column[at];
    block.push_back(b), column.push_back(columns);
    return std::exchange(columns, columns + wide);
  };
  for (const View& view : views) place(view.pose, width);
  for (const SurfaceTerm& s : terms) {
    for (int32_t node : surface_.nodes(s)) layout_.nodes() > 0 ? place(layout_.node(node), 1) : 0;
  }
  const int of_border = place(border, layout_.border());
  cross.setZero(3, columns);
  for (size_t k = 0; k < views.size(); ++k) {
    const CameraChain& chain = images_.chains()[views[k].pose];
    Eigen::Matrix<double, 3, 6> by_twist;
    by_twist << views[k].matrix(), -views[k].matrix() * hat(at(rank) - chain.origin);
    cross.middleCols(column[k], width).noalias() += by_twist * chain.by_pose.leftCols(width);
    if (mount_ >= 0) cross.middleCols<6>(of_border + mount_).noalias() += by_twist * chain.by_mount;
  }
  for (const SurfaceTerm& s : terms) {
    if (hull_ >= 0) cross.middleCols<6>(of_border + hull_) += s.n * s.by_hull().transpose();
    const auto nodes = surface_.nodes(s);
    const auto weights = surface_.weights(s);
    for (size_t k = 0; k < nodes.size() && layout_.nodes() > 0; ++k)
      cross.col(place(layout_.node(nodes[k]), 1)) += (s.by_field * weights[k]) * s.n;
  }
  for (int c = 0; c < intrinsics_; ++c) cross.col(of_border + intrinsics_in_border(c)) += intrinsics_of(rank).col(c);
  spread.setZero(columns, 3);
  for (size_t a = 0; a < block.size(); ++a) {
    const auto z_aa = reduced_->lower(block[a], block[a]);
    const auto by_a = cross.middleCols(column[a], z_aa.cols());
    spread.middleRows(column[a], z_aa.rows()).noalias() += z_aa.selfadjointView<Eigen::Lower>() * by_a.transpose();
    for (size_t b = 0; b < a; ++b) {
      const bool turned = reduced_->is_later(block[b], block[a]);
      const size_t row = turned ? b : a, other = turned ? a : b;
      const auto z = reduced_->lower(block[a], block[b]);
      spread.middleRows(column[row], z.rows()).noalias() += z * cross.middleCols(column[other], z.cols()).transpose();
      spread.middleRows(column[other], z.cols()).noalias() +=
          z.transpose() * cross.middleCols(column[row], z.rows()).transpose();
    }
  }
  const Mat3 k = inverse(rank);
  own = k + k * (cross * spread) * k;
  own = (0.5 * (own + own.transpose())).eval();
  if (hull_ >= 0) with_hull = -k * spread.middleRows<6>(of_border + hull_).transpose();
}

}  // namespace hullrecon
