// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// The damped system without landmarks: rows of X, of S and its border (docs/schur.md, equations (9) to (13)).
#include <algorithm>
#include <utility>

#include "common/parallel.h"
#include "common/wide.h"
#include "schur/schur.h"

extern "C" {
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
}

namespace hullrecon {
namespace {

// Adds E'(own - H K C) of a view, 6 by width, to a pose's row: own and C are what the view and all views say of the landmark's
// displacement with the intrinsics, 3 by width, both row by row as the sum is. Four columns at a time on processors with AVX2.
HULLRECON_WIDE void add_with_intrinsics(const double* own, const double* of_landmark, const Mat3& hk, const Vec3& q, int width,
                                        double* __restrict sum) {
  const double *c0 = of_landmark, *c1 = c0 + width, *c2 = c1 + width, *o0 = own, *o1 = o0 + width, *o2 = o1 + width;
  const Mat3 m = hk;
  const double x = q[0], y = q[1], z = q[2];
  double *top0 = sum, *top1 = top0 + width, *top2 = top1 + width, *low0 = top2 + width, *low1 = low0 + width,
         *low2 = low1 + width;
  for (int k = 0; k < width; ++k) {
    const double a = o0[k] - (m(0, 0) * c0[k] + (m(0, 1) * c1[k] + m(0, 2) * c2[k]));
    const double b = o1[k] - (m(1, 0) * c0[k] + (m(1, 1) * c1[k] + m(1, 2) * c2[k]));
    const double c = o2[k] - (m(2, 0) * c0[k] + (m(2, 1) * c1[k] + m(2, 2) * c2[k]));
    top0[k] += a, top1[k] += b, top2[k] += c;
    low0[k] += y * c - z * b, low1[k] += z * a - x * c, low2[k] += x * b - y * a;
  }
}

}  // namespace

void Schur::eliminate() {
  reduced_->clear();
  const int border = layout_.blocks(), nodes = layout_.nodes();
  for_slabs(
      layout_.poses(), threads_,
      [&](int64_t begin, int64_t end) {
        std::vector<int64_t> place(border, -1);
        for (int64_t i = begin; i < end; ++i) {
          if (images_.sees(i)) eliminate_row(static_cast<int>(i), place);
        }
      },
      8);
  if (intrinsics_ > 0) {
    for_slabs(
        images_.stretches(), threads_,
        [&](int64_t begin, int64_t end) {
          for (int64_t k = begin; k < end; ++k) eliminate_intrinsics(k);
        },
        1);
  }
  rhs_ = gradient_.reduced;
  Border sum = chunked(layout_.poses(), kPoses, [&](int64_t i, Border& b) {
    images_.sees(i) ? reduce_row(static_cast<int>(i), b) : reduce_other(static_cast<int>(i));
  });
  for_slabs(
      nodes, threads_,
      [&](int64_t begin, int64_t end) {
        std::vector<double> row(nodes, 0.0);
        for (int64_t n = begin; n < end; ++n) reduce_node(static_cast<int>(n), row);
      },
      8);
  for_slabs(layout_.others(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) reduce_other(layout_.other(static_cast<int>(k)));
  });
  const Border of_landmarks =
      chunked(model_.landmarks(), kLandmarks, [&](int64_t r, Border& b) { reduce_landmark_border(r, b); });
  const Border of_intrinsics = reduce_intrinsics();
  reduced_->add_own(border,
                    intrinsics_own_ + sum.own + of_landmarks.own + of_intrinsics.own + small_.information().at(border, border));
  rhs_.segment(offset(border), layout_.border()) += sum.rhs + of_landmarks.rhs + of_intrinsics.rhs;
}

// Row i of X (9), and of what it shares with nodes and hull (11). place: of each block, -1 between calls.
void Schur::eliminate_row(int i, std::vector<int64_t>& place) {
  const auto row = pattern_.row(i);
  const int64_t end = row.back().place + (row.back().block < layout_.poses() ? 36 : 6);
  std::fill(&x_[row.front().place], x_.data() + end, 0.0);
  for (const auto& entry : row) place[entry.block] = entry.place;
  const Vec3 origin = images_.chains()[i].origin;
  Twist eliminated = Twist::Zero();
  Mat6 with_hull = Mat6::Zero();
  for (int32_t v : images_.views_of_pose(i)) {
    const View& view = images_.view(v);
    const int32_t rank = view.landmark;
    const Vec3 landmark = at(rank), q = landmark - origin;
    const Mat3 h = view.matrix();
    const Mat63 y = adjoint(q, Mat3(h * inverse(rank)));  // E'H K
    eliminated += y * gradient_.landmark.segment<3>(3 * rank);
    for (int32_t w = v; w < images_.first_view(rank + 1); ++w) {
      const View& other = images_.view(w);
      Eigen::Map<Mat6> x(&x_[place[other.pose]]);
      add_times_displacement(x, -1.0, Mat63(y * other.matrix()), landmark - images_.chains()[other.pose].origin);
    }
    for (const SurfaceTerm& s : surface_.of_landmark(rank)) {
      const Twist along = y * s.n;
      if (hull_ >= 0) with_hull -= along * s.by_hull().transpose();
      if (layout_.nodes() == 0) continue;
      const auto nodes = surface_.nodes(s);
      const auto weights = surface_.weights(s);
      for (size_t k = 0; k < nodes.size(); ++k) {
        Eigen::Map<Twist>(&x_[place[layout_.node(nodes[k])]]) -= (s.by_field * weights[k]) * along;
      }
    }
  }
  Eigen::Map<Mat6>(&x_[place[i]]) += own_[i];
  eliminated_.col(i) = eliminated, with_hull_[i] = with_hull;
  for (const auto& entry : row) place[entry.block] = -1;
}

// What the poses of a stretch share with the intrinsics (11). They mostly see the same landmarks, so C of a landmark is fetched
// from memory once for all of them.
void Schur::eliminate_intrinsics(int64_t stretch) {
  const int64_t first = stretch * ImageTerms::kStretch;
  using Rows = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<Rows> sums(ImageTerms::kStretch, Rows::Zero(6, intrinsics_));
  WithIntrinsics cross(3, intrinsics_);
  for (int32_t v : images_.views_of_stretch(stretch)) {
    const View& view = images_.view(v);
    const int64_t rank = view.landmark;
    cross.setZero();
    images_.add_intrinsics(v, cross);
    add_with_intrinsics(cross.data(), intrinsics_of(rank).data(), view.matrix() * inverse(rank),
                        at(rank) - images_.chains()[view.pose].origin, intrinsics_, sums[view.pose - first].data());
  }
  for (int64_t i = first; i < std::min(first + ImageTerms::kStretch, model_.poses()); ++i) {
    if (images_.sees(i)) with_intrinsics(static_cast<int>(i)) = sums[i - first];
  }
}

// Row i of S = [P Q]' X [P Q] (10) and what it adds to the border, with its small factors.
void Schur::reduce_row(int i, Border& sum) {
  const CameraChain& chain = images_.chains()[i];
  const int width = layout_.width(i);
  const Eigen::Matrix<double, 7, 6> p = chain.by_pose.transpose();
  Eigen::MatrixXd own, border = Eigen::MatrixXd::Zero(layout_.border(), width);
  Mat6 by_mount = Mat6::Zero();  // X Q: of the twist by the mount
  for (const auto& [j, place] : pattern_.row(i)) {
    if (j >= layout_.poses()) {
      reduced_->add(i, j, (p * Eigen::Map<const Twist>(&x_[place])).head(width));
      continue;
    }
    const Mat6 x = Eigen::Map<const Mat6>(&x_[place]);
    const Eigen::Matrix<double, 7, 7> s = p * x * images_.chains()[j].by_pose;
    if (j == i) own = s.topLeftCorner(width, width);
    if (j != i) reduced_->add(i, j, s.topLeftCorner(width, width));
    if (mount_ >= 0) by_mount += x * images_.chains()[j].by_mount;
  }
  for (const auto& [j, place] : pattern_.below(i)) {
    if (mount_ >= 0) by_mount += Eigen::Map<const Mat6>(&x_[place]).transpose() * images_.chains()[j].by_mount;
  }
  rhs_.segment(offset(i), width) -= (p * eliminated_.col(i)).head(width);
  if (hull_ >= 0) border.middleRows<6>(hull_) += (p * with_hull_[i]).topRows(width).transpose();
  const Eigen::MatrixXd intrinsics = (p * with_intrinsics(i)).topRows(width);
  for (int c = 0; c < intrinsics_; ++c) border.row(intrinsics_in_border(c)) += intrinsics.col(c).transpose();
  if (mount_ >= 0) {
    border.middleRows<6>(mount_) += (p * by_mount).topRows(width).transpose();
    const Mat6 q = chain.by_mount.transpose();
    sum.own.block<6, 6>(mount_, mount_) += q * by_mount;
    sum.rhs.segment<6>(mount_) -= q * eliminated_.col(i);
    if (hull_ >= 0) sum.own.block<6, 6>(mount_, hull_) += q * with_hull_[i];
    const Eigen::MatrixXd of_mount = q * with_intrinsics(i);
    for (int c = 0; c < intrinsics_; ++c)
      sum.own.row(intrinsics_in_border(c)).segment<6>(mount_) += of_mount.col(c).transpose();
  }
  add_small(i, own, border);
  reduced_->add_own(i, own);
  reduced_->add_border(i, border);
}

// What small factors say of a block: its own square, the blocks after it, the border.
void Schur::add_small(int block, Eigen::MatrixXd& own, Eigen::MatrixXd& border) {
  small_.information().visit_column(block, [&](int row, const auto& m) {
    if (row == block) {
      own += m;
    } else if (row == layout_.blocks()) {
      border += m;
    } else {
      reduced_->add(row, block, m);
    }
  });
}

// Row of a node (12): with later nodes and the border. row: of all nodes, zero between calls.
void Schur::reduce_node(int node, std::vector<double>& row) {
  const int block = layout_.node(node);
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(1, 1), border = Eigen::MatrixXd::Zero(layout_.border(), 1);
  std::vector<int32_t> touched;
  for (int32_t k : surface_.of_node(node)) {
    const SurfaceTerm& s = surface_[k];
    const double by = surface_.by_node(s, node);
    const Vec3 y = by * (inverse(s.rank) * s.n);
    rhs_[offset(block)] -= by * s.n.dot(gain_.col(s.rank));
    for (const SurfaceTerm& other : surface_.of_landmark(s.rank)) {
      const double factor = (&other == &s ? by : 0.0) - y.dot(other.n);
      if (hull_ >= 0) border.middleRows<6>(hull_) += factor * other.by_hull();
      const auto nodes = surface_.nodes(other);
      const auto weights = surface_.weights(other);
      for (size_t m = 0; m < nodes.size(); ++m) {
        if (nodes[m] < node) continue;
        if (row[nodes[m]] == 0) touched.push_back(nodes[m]);
        row[nodes[m]] += factor * other.by_field * weights[m];
      }
    }
    for (int c = 0; c < intrinsics_; ++c) border(intrinsics_in_border(c), 0) -= y.dot(intrinsics_of(s.rank).col(c));
  }
  own(0, 0) = row[node], row[node] = 0;
  for (int32_t other : touched) {
    if (row[other] != 0) reduced_->add(block, layout_.node(other), Eigen::Matrix<double, 1, 1>(std::exchange(row[other], 0.0)));
  }
  for (const auto& [j, place] : pattern_.below(block)) {
    if (mount_ >= 0)
      border.middleRows<6>(mount_) += images_.chains()[j].by_mount.transpose() * Eigen::Map<const Twist>(&x_[place]);
  }
  add_small(block, own, border);
  reduced_->add_own(block, own);
  reduced_->add_border(block, border);
}

// Row of a block that small factors alone meet.
void Schur::reduce_other(int block) {
  const int width = layout_.width(block);
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(width, width), border = Eigen::MatrixXd::Zero(layout_.border(), width);
  add_small(block, own, border);
  reduced_->add_own(block, own);
  reduced_->add_border(block, border);
}

// What a landmark leaves of the hull, and between hull and intrinsics (13).
void Schur::reduce_landmark_border(int64_t rank, Border& sum) const {
  if (hull_ < 0) return;
  const Mat3 k = inverse(rank);
  for (const SurfaceTerm& s : surface_.of_landmark(rank)) {
    const Vec3 kn = k * s.n;
    Twist others = s.by_hull();  // a - sum of the a of all surface factors of this landmark, by n'K n
    for (const SurfaceTerm& other : surface_.of_landmark(rank)) others -= kn.dot(other.n) * other.by_hull();
    sum.own.block<6, 6>(hull_, hull_).noalias() += s.by_hull() * others.transpose();
    sum.rhs.segment<6>(hull_) -= s.n.dot(gain_.col(rank)) * s.by_hull();
  }
  for (const SurfaceTerm& s : surface_.of_landmark(rank)) {
    if (intrinsics_ == 0) break;
    const Eigen::VectorXd with_normal = intrinsics_of(rank).transpose() * (k * s.n);
    for (int c = 0; c < intrinsics_; ++c)
      sum.own.row(intrinsics_in_border(c)).segment<6>(hull_) -= with_normal[c] * s.by_hull().transpose();
  }
}

// What landmarks leave of the intrinsics alone (13), as one product of a group of them. Rows of C stand in a run, so a group's
// are C' to BLAS, which is told so.
Schur::Border Schur::reduce_intrinsics() const {
  return chunked(intrinsics_ > 0 ? groups() : 0, 1, [&](int64_t group, Border& sum) {
    const int64_t first = group * kGroup, count = std::min(kGroup, model_.landmarks() - first);
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Map<const Rows> c(intrinsics_of(first).data(), 3 * count, intrinsics_);
    Rows kc(3 * count, intrinsics_);
    for (int64_t i = 0; i < count; ++i) kc.middleRows<3>(3 * i).noalias() = inverse(first + i) * c.middleRows<3>(3 * i);
    Eigen::MatrixXd own(intrinsics_, intrinsics_);
    const int rows = static_cast<int>(3 * count);
    const double minus = -1, nothing = 0;
    dgemm_("N", "T", &intrinsics_, &intrinsics_, &rows, &minus, c.data(), &intrinsics_, kc.data(), &intrinsics_, &nothing,
           own.data(), &intrinsics_);
    const Eigen::Map<const Eigen::VectorXd> gain(gain_.col(first).data(), 3 * count);
    add_intrinsics_to_border(own, -c.transpose() * gain, sum);
  });
}

}  // namespace hullrecon
