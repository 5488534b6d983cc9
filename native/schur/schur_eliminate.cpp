// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Schur: landmarks eliminated, the reduced system summed.
#include <algorithm>
#include <utility>

#include "common/parallel.h"
#include "model/visit.h"
#include "schur/adjoint.h"
#include "schur/schur.h"

namespace hullrecon {
namespace {

// to += a' b, columns of kRows numbers (0: of `rows`); to: by columns, `stride` apart. For products too small for a library.
template <int kRows>
void add_product_of(double* to, int64_t stride, const double* a, int a_columns, const double* b, int b_columns, int64_t rows) {
  const int64_t n = kRows > 0 ? kRows : rows;
  for (int c = 0; c < b_columns; ++c) {
    for (int r = 0; r < a_columns; ++r) {
      double sum = 0;
      for (int64_t k = 0; k < n; ++k) sum += a[r * n + k] * b[c * n + k];
      to[c * stride + r] += sum;
    }
  }
}

void add_product(double* to, int64_t stride, const double* a, int a_columns, const double* b, int b_columns, int64_t rows) {
  const auto of = rows == 1   ? add_product_of<1>
                  : rows == 3 ? add_product_of<3>
                  : rows == 6 ? add_product_of<6>
                              : add_product_of<0>;
  of(to, stride, a, a_columns, b, b_columns, rows);
}

}  // namespace

void Schur::eliminate() {
  reduced_->clear();
  const int border = kept_.blocks(), nodes = border - kept_.poses();
  for_slabs(
      kept_.poses(), threads_,
      [&](int64_t begin, int64_t end) {
        std::vector<int64_t> place(border, -1);
        for (int64_t i = begin; i < end; ++i) eliminate_row(static_cast<int>(i), place);
      },
      8);
  rhs_ = gradient_.kept;
  Border sum = chunked(kept_.poses(), kPoses, [&](int64_t i, Border& b) { reduce_row(static_cast<int>(i), b); });
  for_slabs(
      nodes, threads_,
      [&](int64_t begin, int64_t end) {
        std::vector<double> row(nodes, 0.0);
        for (int64_t n = begin; n < end; ++n) reduce_node(static_cast<int>(n), row);
      },
      8);
  const Border of_landmarks = chunked(model_.landmarks(), kLandmarks, [&](int64_t r, Border& b) { border_of_landmark(r, b); });
  const Border of_small = chunked(small_.count(), kFactors, [&](int64_t f, Border& b) { border_of_small(f, b); });
  reduced_->add_own(border, optics_own_ + sum.own + of_landmarks.own + of_small.own);
  rhs_.segment(reduced_->offset(border), kept_.border()) += sum.rhs + of_landmarks.rhs;
}

// Row i of X. place: of each block, -1 everywhere between calls.
void Schur::eliminate_row(int i, std::vector<int64_t>& place) {
  std::fill(&x_[x_start_[upper_start_[i]]], x_.data() + x_start_[upper_start_[i + 1]], 0.0);
  for (int64_t k = upper_start_[i]; k < upper_start_[i + 1]; ++k) place[upper_[k]] = x_start_[k];
  const Vec3 origin = sights_.arms()[i].origin;
  Vec6 eliminated = Vec6::Zero();
  Mat6 with_hull = Mat6::Zero();
  Eigen::Matrix<double, 6, Eigen::Dynamic> with_optics = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, optics_);
  Eigen::Matrix3Xd cross(3, optics_);
  for (int32_t n = views_start_[i]; n < views_start_[i + 1]; ++n) {
    const int32_t v = views_[n];
    const View& view = sights_.view(v);
    const int32_t rank = view.landmark;
    const Vec3 landmark = at(rank), q = landmark - origin;
    const Mat3 h = view.matrix();
    const Mat63 y = lifted(q, Mat3(h * inverse(rank)));
    eliminated += y * gradient_.landmark.segment<3>(3 * rank);
    for (int32_t w = v; w < sights_.first_view(rank + 1); ++w) {
      const View& other = sights_.view(w);
      Eigen::Map<Mat6> x(&x_[place[other.pose]]);
      add_times_lever(x, -1.0, Mat63(y * other.matrix()), landmark - sights_.arms()[other.pose].origin);
    }
    for (const SurfaceRow& s : surfaces(rank)) {
      const Vec6 along = y * s.n;
      if (hull_ >= 0) with_hull -= along * s.by_hull().transpose();
      if (kept_.blocks() == kept_.poses()) continue;
      const auto nodes = model_.surface_nodes(s.row);
      const FieldAt field = model_.surface_field(s.row);
      for (size_t k = 0; k < nodes.size(); ++k) {
        Eigen::Map<Vec6>(&x_[place[kept_.poses() + nodes[k]]]) -= (s.by_field * field.weight[k]) * along;
      }
    }
    if (optics_ == 0) continue;
    cross.setZero();
    sights_.by_optics(v, cross, nullptr, nullptr);
    with_optics.topRows<3>() += cross;
    for (int c = 0; c < optics_; ++c) with_optics.col(c).tail<3>() += q.cross(Vec3(cross.col(c)));
    with_optics -= y * optics_of(rank);
  }
  Eigen::Map<Mat6>(&x_[place[i]]) += own_[i];
  eliminated_.col(i) = eliminated, with_hull_[i] = with_hull, with_optics_[i] = with_optics;
  for (int64_t k = upper_start_[i]; k < upper_start_[i + 1]; ++k) place[upper_[k]] = -1;
}

// Row i of S = [P Q]' X [P Q] and what it adds to the border, with its small factors.
void Schur::reduce_row(int i, Border& sum) {
  const Arm& arm = sights_.arms()[i];
  const int width = kept_.width(i);
  const Eigen::Matrix<double, 7, 6> p = arm.by_pose.transpose();
  Eigen::MatrixXd own, border = Eigen::MatrixXd::Zero(kept_.border(), width);
  Mat6 by_mount = Mat6::Zero();  // X Q: of the twist by the mount
  for (int64_t k = upper_start_[i]; k < upper_start_[i + 1]; ++k) {
    const int j = upper_[k];
    if (j >= kept_.poses()) {
      reduced_->add(i, j, (p * Eigen::Map<const Vec6>(&x_[x_start_[k]])).head(width));
      continue;
    }
    const Mat6 x = Eigen::Map<const Mat6>(&x_[x_start_[k]]);
    const Eigen::Matrix<double, 7, 7> s = p * x * sights_.arms()[j].by_pose;
    if (j == i) own = s.topLeftCorner(width, width);
    if (j != i) reduced_->add(i, j, s.topLeftCorner(width, width));
    if (mount_ >= 0) by_mount += x * sights_.arms()[j].by_mount;
  }
  for (int64_t k = lower_start_[i]; k < lower_start_[i + 1] && mount_ >= 0; ++k) {
    by_mount += Eigen::Map<const Mat6>(&x_[lower_[k].second]).transpose() * sights_.arms()[lower_[k].first].by_mount;
  }
  rhs_.segment(reduced_->offset(i), width) -= (p * eliminated_.col(i)).head(width);
  if (hull_ >= 0) border.middleRows<6>(hull_) += (p * with_hull_[i]).topRows(width).transpose();
  const Eigen::MatrixXd optics = (p * with_optics_[i]).topRows(width);
  for (int c = 0; c < optics_; ++c) border.row(optics_in_border(c)) += optics.col(c).transpose();
  if (mount_ >= 0) {
    border.middleRows<6>(mount_) += (p * by_mount).topRows(width).transpose();
    const Mat6 q = arm.by_mount.transpose();
    sum.own.block<6, 6>(mount_, mount_) += q * by_mount;
    sum.rhs.segment<6>(mount_) -= q * eliminated_.col(i);
    if (hull_ >= 0) sum.own.block<6, 6>(mount_, hull_) += q * with_hull_[i];
    const Eigen::MatrixXd of_optics = q * with_optics_[i];
    for (int c = 0; c < optics_; ++c) sum.own.row(optics_in_border(c)).segment<6>(mount_) += of_optics.col(c).transpose();
  }
  add_small(i, own, border);
  reduced_->add_own(i, own);
  reduced_->add_border(i, border);
}

void Schur::add_small(int block, Eigen::MatrixXd& own, Eigen::MatrixXd& border) {
  for (int32_t f : small_.of_block(block)) {
    const auto rows = small_.rows(f);
    const auto parts = small_.parts(f);
    const auto mine = std::find_if(parts.begin(), parts.end(), [&](const auto& part) { return part.block == block; });
    const int64_t m = rows.rows();
    const double* const J = rows.data() + mine->column * m;
    for (const SmallFactors::Part& part : parts) {
      const double* const other = rows.data() + part.column * m;
      if (part.border >= 0) {
        add_product(border.data() + part.border, border.rows(), other, part.width, J, mine->width, m);
      } else if (part.block == block) {
        add_product(own.data(), own.rows(), J, mine->width, J, mine->width, m);
      } else if (part.block > block) {
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 7> product(mine->width, part.width);
        product.setZero();
        add_product(product.data(), mine->width, J, mine->width, other, part.width, m);
        reduced_->add(block, part.block, product);
      }
    }
  }
}

// Row of a node: with later nodes and the border. row: of all nodes, zero between calls.
void Schur::reduce_node(int node, std::vector<double>& row) {
  const int block = kept_.poses() + node;
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(1, 1), border = Eigen::MatrixXd::Zero(kept_.border(), 1);
  std::vector<int32_t> touched;
  for (int32_t k = of_node_start_[node]; k < of_node_start_[node + 1]; ++k) {
    const SurfaceRow& s = surface_[of_node_[k]];
    const double by = s.by_field * weight_of(s.row, node);
    const Vec3 y = by * (inverse(s.rank) * s.n);
    rhs_[reduced_->offset(block)] -= by * s.n.dot(gain_.col(s.rank));
    for (const SurfaceRow& other : surfaces(s.rank)) {
      const double factor = (&other == &s ? by : 0.0) - y.dot(other.n);
      if (hull_ >= 0) border.middleRows<6>(hull_) += factor * other.by_hull();
      const auto nodes = model_.surface_nodes(other.row);
      const FieldAt field = model_.surface_field(other.row);
      for (size_t m = 0; m < nodes.size(); ++m) {
        if (nodes[m] < node) continue;
        if (row[nodes[m]] == 0) touched.push_back(nodes[m]);
        row[nodes[m]] += factor * other.by_field * field.weight[m];
      }
    }
    for (int c = 0; c < optics_; ++c) border(optics_in_border(c), 0) -= y.dot(optics_of(s.rank).col(c));
  }
  own(0, 0) = row[node], row[node] = 0;
  for (int32_t other : touched) {
    if (row[other] != 0)
      reduced_->add(block, kept_.poses() + other, Eigen::Matrix<double, 1, 1>(std::exchange(row[other], 0.0)));
  }
  for (int64_t k = lower_start_[block]; k < lower_start_[block + 1] && mount_ >= 0; ++k) {
    border.middleRows<6>(mount_) +=
        sights_.arms()[lower_[k].first].by_mount.transpose() * Eigen::Map<const Vec6>(&x_[lower_[k].second]);
  }
  add_small(block, own, border);
  reduced_->add_own(block, own);
  reduced_->add_border(block, border);
}

void Schur::border_of_landmark(int64_t rank, Border& sum) const {
  if (hull_ < 0 && optics_ == 0) return;
  const Mat3 k = inverse(rank);
  for (const SurfaceRow& s : surfaces(rank)) {
    if (hull_ < 0) break;
    const Vec3 kn = k * s.n;
    Vec6 others = s.by_hull();  // a - sum of the a of all surface factors of this landmark, by n'K n
    for (const SurfaceRow& other : surfaces(rank)) others -= kn.dot(other.n) * other.by_hull();
    sum.own.block<6, 6>(hull_, hull_).noalias() += s.by_hull() * others.transpose();
    sum.rhs.segment<6>(hull_) -= s.n.dot(gain_.col(rank)) * s.by_hull();
  }
  for (int c = 0; c < optics_; ++c) {
    const int at = optics_in_border(c);
    const Vec3 kc = k * optics_of(rank).col(c);
    for (const SurfaceRow& s : surfaces(rank)) {
      if (hull_ >= 0) sum.own.row(at).segment<6>(hull_) -= kc.dot(s.n) * s.by_hull().transpose();
    }
    for (int d = 0; d <= c; ++d) sum.own(at, optics_in_border(d)) -= kc.dot(optics_of(rank).col(d));
    sum.rhs[at] -= gain_.col(rank).dot(optics_of(rank).col(c));
  }
}

void Schur::border_of_small(int64_t f, Border& sum) const {
  const auto rows = small_.rows(f);
  const int64_t m = rows.rows();
  for (const SmallFactors::Part& a : small_.parts(f)) {
    for (const SmallFactors::Part& b : small_.parts(f)) {
      if (a.border < b.border || b.border < 0) continue;
      add_product(&sum.own(a.border, b.border), sum.own.rows(), rows.data() + a.column * m, a.width, rows.data() + b.column * m,
                  b.width, m);
    }
  }
}

}  // namespace hullrecon
