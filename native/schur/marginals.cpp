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
  auto& [own, with_hull, block, column, cross, turned] = out;
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
  turned = cross.transpose();
  with_hull.setZero();
  Mat3 squares = Mat3::Zero(), products = Mat3::Zero();  // of H Z H'
  const auto of = [&](size_t k, const auto& z) { return turned.middleRows(column[k], z); };
  const auto add_hull = [&](const auto& by_border, size_t k) {
    if (hull_ >= 0) with_hull += (by_border.template middleRows<6>(hull_).lazyProduct(of(k, by_border.cols()))).transpose();
  };
  for (size_t a = 0; a < block.size(); ++a) {
    const auto z = reduced_->lower(block[a], block[a]);
    const Eigen::MatrixX3d by = of(a, z.cols());
    Eigen::MatrixX3d moved(z.rows(), 3);
    for (int c = 0; c < 3; ++c) moved.col(c).noalias() = z.selfadjointView<Eigen::Lower>() * by.col(c);
    squares += by.transpose().lazyProduct(moved);
    if (block[a] == border && hull_ >= 0) with_hull += moved.middleRows<6>(hull_).transpose();
    for (size_t b = 0; b < a; ++b) {
      const bool is_later = reduced_->is_later(block[a], block[b]);
      const size_t row = is_later ? a : b, other = is_later ? b : a;
      const auto below = reduced_->lower(block[a], block[b]);
      const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, 7, 3> half =
          below.transpose().lazyProduct(of(row, below.rows()));
      products += half.transpose().lazyProduct(of(other, below.cols()));
      if (block[row] == border) add_hull(below, other);
    }
  }
  const Mat3 k = inverse(rank);
  own = k + k * (squares + products + products.transpose()) * k;
  own = (0.5 * (own + own.transpose())).eval();
  with_hull = (-k * with_hull).eval();
}

}  // namespace hullrecon
