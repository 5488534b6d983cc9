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
                  : rows == 5 ? add_product_of<5>
                  : rows == 6 ? add_product_of<6>
                              : add_product_of<0>;
  of(to, stride, a, a_columns, b, b_columns, rows);
}

}  // namespace

Schur::Schur(Model& model)
    : model_(model),
      layout_(model),
      images_(model),
      surface_(model, images_, layout_),
      small_(model, layout_),
      threads_(model.options().threads),
      pattern_(layout_, images_, surface_, small_, threads_),
      reduced_(pattern_.reduced_system()),
      intrinsics_(images_.intrinsics().width()),
      hull_(layout_.column(kHull)),
      mount_(layout_.column(kCamera)) {
  const int64_t landmarks = model.landmarks(), poses = model.poses();
  x_.resize(pattern_.size());
  own_.resize(poses), with_hull_.resize(poses), eliminated_.resize(6, poses);
  with_intrinsics_.assign(poses, Mat6X(6, intrinsics_));
  inverse_.resize(landmarks), gain_.resize(3, landmarks), intrinsics_cross_.resize(3, landmarks * intrinsics_);
  for (StepVector* s : {&gradient_, &diagonal_}) s->landmark.resize(3 * landmarks), s->reduced.resize(layout_.size());
}

// --- at a new point: cost, gradient, diagonal ---------------------------------------------------------------------------

std::optional<std::array<double, kKindNames.size()>> Schur::cost() {
  std::array<double, kKindNames.size()> sum{};
  if (!small_.cost(sum)) return std::nullopt;
  const auto images = images_.cost();
  sum[static_cast<size_t>(Kind::Stereo)] = images[0], sum[static_cast<size_t>(Kind::Mono)] = images[1];
  sum[static_cast<size_t>(Kind::Surface)] = surface_.cost();
  if (!std::isfinite(std::accumulate(sum.begin(), sum.end(), 0.0))) return std::nullopt;
  return sum;
}

void Schur::linearise() {
  images_.linearise();
  small_.linearise();
  surface_.linearise();
  differentiate_landmarks();
  differentiate_poses();
  differentiate_nodes();
  differentiate_others();
  differentiate_border();
}

void Schur::differentiate_landmarks() {
  for_slabs(model_.landmarks(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t r = begin; r < end; ++r) {
      Vec3 g = Vec3::Zero(), d = Vec3::Zero();
      for (const View& view : images_.views_of_landmark(r)) {
        const auto& h = view.information;
        g += view.gradient, d += Vec3(h[0], h[3], h[5]);
      }
      for (const SurfaceTerm& s : surface_.of_landmark(r)) g += s.n * s.r, d += s.n.cwiseAbs2();
      gradient_.landmark.segment<3>(3 * r) = g, diagonal_.landmark.segment<3>(3 * r) = d;
      if (intrinsics_ == 0) continue;
      Eigen::Matrix3Xd cross = Eigen::Matrix3Xd::Zero(3, intrinsics_);
      for (int32_t v = images_.first_view(r); v < images_.first_view(r + 1); ++v)
        images_.add_intrinsics(v, cross, nullptr, nullptr);
      intrinsics_cross_.middleCols(r * intrinsics_, intrinsics_) = cross;
    }
  });
}

void Schur::differentiate_poses() {
  const int width = layout_.width(0);
  for_slabs(layout_.poses(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const CameraChain& chain = images_.chains()[i];
      Mat6& own = own_[i];
      own.setZero();
      Twist twist = Twist::Zero();
      for (int32_t v : images_.views_of_pose(i)) {
        const View& view = images_.view(v);
        const Vec3 q = at(view.landmark) - chain.origin;
        add_times_displacement(own, 1.0, adjoint(q, view.matrix()), q);
        twist += adjoint(q, view.gradient);
      }
      eliminated_.col(i) = twist;
      Eigen::Matrix<double, 7, 1> g = chain.by_pose.transpose() * twist;
      Eigen::Matrix<double, 7, 1> d = (own * chain.by_pose).cwiseProduct(chain.by_pose).colwise().sum().transpose();
      for (int32_t f : small_.of_block(static_cast<int>(i))) {
        const auto rows = small_.rows(f);
        for (const SmallFactors::Part& part : small_.parts(f)) {
          if (part.block != i) continue;
          g.head(width) += rows.middleCols(part.column, width).transpose() * rows.rightCols<1>();
          d.head(width) += rows.middleCols(part.column, width).colwise().squaredNorm().transpose();
        }
      }
      gradient_.reduced.segment(offset(static_cast<int>(i)), width) = g.head(width);
      diagonal_.reduced.segment(offset(static_cast<int>(i)), width) = d.head(width);
    }
  });
}

void Schur::differentiate_nodes() {
  for_slabs(layout_.nodes(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const int block = layout_.node(static_cast<int>(n));
      double g = 0, d = 0;
      for (int32_t k : surface_.of_node(static_cast<int>(n))) {
        const double by = surface_.by_node(surface_[k], static_cast<int32_t>(n));
        g += by * surface_[k].r, d += by * by;
      }
      for (int32_t f : small_.of_block(block)) {
        const auto rows = small_.rows(f);
        for (const SmallFactors::Part& part : small_.parts(f)) {
          if (part.block == block)
            g += rows.col(part.column).dot(rows.rightCols<1>()), d += rows.col(part.column).squaredNorm();
        }
      }
      gradient_.reduced[offset(block)] = g, diagonal_.reduced[offset(block)] = d;
    }
  });
}

void Schur::differentiate_others() {
  for_slabs(layout_.others(), threads_, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const int block = layout_.other(static_cast<int>(k));
      auto g = gradient_.reduced.segment(offset(block), layout_.width(block));
      auto d = diagonal_.reduced.segment(offset(block), layout_.width(block));
      g.setZero(), d.setZero();
      for (int32_t f : small_.of_block(block)) {
        const auto rows = small_.rows(f);
        for (const SmallFactors::Part& part : small_.parts(f)) {
          if (part.block != block) continue;
          g += rows.middleCols(part.column, part.width).transpose() * rows.rightCols<1>();
          d += rows.middleCols(part.column, part.width).colwise().squaredNorm().transpose();
        }
      }
    }
  });
}

void Schur::differentiate_border() {
  const auto diagonal = [](Border& sum, int first, const auto& d) { sum.own.diagonal().segment(first, d.size()) += d; };
  const Border of_poses = chunked(layout_.poses(), kPoses, [&](int64_t i, Border& sum) {
    if (mount_ < 0) return;
    const auto& by = images_.chains()[i].by_mount;
    sum.rhs.segment<6>(mount_) += by.transpose() * eliminated_.col(i);
    diagonal(sum, mount_, (own_[i] * by).cwiseProduct(by).colwise().sum().transpose());
  });
  const Border of_landmarks = chunked(model_.landmarks(), kLandmarks, [&](int64_t r, Border& sum) {
    for (const SurfaceTerm& s : surface_.of_landmark(r)) {
      if (hull_ < 0) break;
      const Twist a = s.by_hull();
      sum.rhs.segment<6>(hull_) += a * s.r;
      diagonal(sum, hull_, a.cwiseAbs2());
    }
    if (intrinsics_ == 0) return;
    Eigen::Matrix3Xd cross = Eigen::Matrix3Xd::Zero(3, intrinsics_);
    Eigen::MatrixXd own = Eigen::MatrixXd::Zero(intrinsics_, intrinsics_);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(intrinsics_);
    for (int32_t v = images_.first_view(r); v < images_.first_view(r + 1); ++v) images_.add_intrinsics(v, cross, &own, &g);
    for (int k = 0; k < intrinsics_; ++k) {
      sum.rhs[intrinsics_in_border(k)] += g[k];
      // The intrinsics' own block stands whole in the lower half; its diagonal is that of J'J, too.
      for (int m = 0; m <= k; ++m) sum.own(intrinsics_in_border(k), intrinsics_in_border(m)) += own(k, m);
    }
  });
  const Border of_small = chunked(small_.count(), kFactors, [&](int64_t f, Border& sum) {
    const auto rows = small_.rows(f);
    for (const SmallFactors::Part& part : small_.parts(f)) {
      if (part.border < 0) continue;
      const auto J = rows.middleCols(part.column, part.width);
      sum.rhs.segment(part.border, part.width) += J.transpose() * rows.rightCols<1>();
      diagonal(sum, part.border, J.colwise().squaredNorm().transpose());
    }
  });
  const int first = offset(layout_.blocks()), width = layout_.border();
  gradient_.reduced.segment(first, width) = of_poses.rhs + of_landmarks.rhs + of_small.rhs;
  diagonal_.reduced.segment(first, width) = (of_poses.own + of_landmarks.own + of_small.own).diagonal();
  intrinsics_own_ = of_landmarks.own;
  if (hull_ >= 0) intrinsics_own_.middleRows(hull_, 6).setZero();
}

// --- a step: invert, eliminate, factor, back-substitute -----------------------------------------------------------------

bool Schur::step(const StepVector& damping, StepVector& out) {
  auto clock = Clock::now();
  if (!invert(damping)) return false;
  eliminate();
  reduced_->add_diagonal(damping.reduced);
  seconds.eliminate += since(clock);
  const bool definite = reduced_->factor();
  if (definite) out.reduced = -rhs_, reduced_->solve(out.reduced);
  seconds.factor += since(clock);
  if (!definite || !out.reduced.allFinite()) return false;
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

void Schur::eliminate() {
  reduced_->clear();
  const int border = layout_.blocks(), nodes = layout_.nodes();
  for_slabs(
      layout_.poses(), threads_,
      [&](int64_t begin, int64_t end) {
        std::vector<int64_t> place(border, -1);
        for (int64_t i = begin; i < end; ++i) eliminate_row(static_cast<int>(i), place);
      },
      8);
  rhs_ = gradient_.reduced;
  Border sum = chunked(layout_.poses(), kPoses, [&](int64_t i, Border& b) { reduce_row(static_cast<int>(i), b); });
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
  const Border of_small = chunked(small_.count(), kFactors, [&](int64_t f, Border& b) { add_small_border(f, b); });
  reduced_->add_own(border, intrinsics_own_ + sum.own + of_landmarks.own + of_small.own);
  rhs_.segment(offset(border), layout_.border()) += sum.rhs + of_landmarks.rhs;
}

// Row i of X (9), and of what it shares with nodes, hull and intrinsics (11). place: of each block, -1 between calls.
void Schur::eliminate_row(int i, std::vector<int64_t>& place) {
  const auto row = pattern_.row(i);
  const int64_t end = row.back().place + (row.back().block < layout_.poses() ? 36 : 6);
  std::fill(&x_[row.front().place], x_.data() + end, 0.0);
  for (const auto& entry : row) place[entry.block] = entry.place;
  const Vec3 origin = images_.chains()[i].origin;
  Twist eliminated = Twist::Zero();
  Mat6 with_hull = Mat6::Zero();
  Mat6X with_intrinsics = Mat6X::Zero(6, intrinsics_);
  Eigen::Matrix3Xd cross(3, intrinsics_);
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
    if (intrinsics_ == 0) continue;
    cross.setZero();
    images_.add_intrinsics(v, cross, nullptr, nullptr);
    with_intrinsics.topRows<3>() += cross;
    for (int c = 0; c < intrinsics_; ++c) with_intrinsics.col(c).tail<3>() += q.cross(Vec3(cross.col(c)));
    with_intrinsics -= y * intrinsics_of(rank);
  }
  Eigen::Map<Mat6>(&x_[place[i]]) += own_[i];
  eliminated_.col(i) = eliminated, with_hull_[i] = with_hull, with_intrinsics_[i] = with_intrinsics;
  for (const auto& entry : row) place[entry.block] = -1;
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
  const Eigen::MatrixXd intrinsics = (p * with_intrinsics_[i]).topRows(width);
  for (int c = 0; c < intrinsics_; ++c) border.row(intrinsics_in_border(c)) += intrinsics.col(c).transpose();
  if (mount_ >= 0) {
    border.middleRows<6>(mount_) += (p * by_mount).topRows(width).transpose();
    const Mat6 q = chain.by_mount.transpose();
    sum.own.block<6, 6>(mount_, mount_) += q * by_mount;
    sum.rhs.segment<6>(mount_) -= q * eliminated_.col(i);
    if (hull_ >= 0) sum.own.block<6, 6>(mount_, hull_) += q * with_hull_[i];
    const Eigen::MatrixXd of_mount = q * with_intrinsics_[i];
    for (int c = 0; c < intrinsics_; ++c)
      sum.own.row(intrinsics_in_border(c)).segment<6>(mount_) += of_mount.col(c).transpose();
  }
  add_small(i, own, border);
  reduced_->add_own(i, own);
  reduced_->add_border(i, border);
}

// The small factors of a block: its own square, the blocks after it, the border.
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

// What a landmark leaves between hull and intrinsics (13).
void Schur::reduce_landmark_border(int64_t rank, Border& sum) const {
  if (hull_ < 0 && intrinsics_ == 0) return;
  const Mat3 k = inverse(rank);
  for (const SurfaceTerm& s : surface_.of_landmark(rank)) {
    if (hull_ < 0) break;
    const Vec3 kn = k * s.n;
    Twist others = s.by_hull();  // a - sum of the a of all surface factors of this landmark, by n'K n
    for (const SurfaceTerm& other : surface_.of_landmark(rank)) others -= kn.dot(other.n) * other.by_hull();
    sum.own.block<6, 6>(hull_, hull_).noalias() += s.by_hull() * others.transpose();
    sum.rhs.segment<6>(hull_) -= s.n.dot(gain_.col(rank)) * s.by_hull();
  }
  for (int c = 0; c < intrinsics_; ++c) {
    const int at = intrinsics_in_border(c);
    const Vec3 kc = k * intrinsics_of(rank).col(c);
    for (const SurfaceTerm& s : surface_.of_landmark(rank)) {
      if (hull_ >= 0) sum.own.row(at).segment<6>(hull_) -= kc.dot(s.n) * s.by_hull().transpose();
    }
    for (int d = 0; d <= c; ++d) sum.own(at, intrinsics_in_border(d)) -= kc.dot(intrinsics_of(rank).col(d));
    sum.rhs[at] -= gain_.col(rank).dot(intrinsics_of(rank).col(c));
  }
}

void Schur::add_small_border(int64_t f, Border& sum) const {
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

// The landmarks' steps from those of the rest (14).
void Schur::back_substitute(StepVector& step) const {
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
  step.landmark.resize(3 * model_.landmarks());
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

// --- the rest ------------------------------------------------------------------------------------------------------------

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
  for (int g = 0; g < 7; ++g) {
    if (layout_.column(g) >= 0) put(layout_.model_global(g), &step.reduced[offset(layout_.blocks()) + layout_.column(g)]);
  }
  for (int64_t r = 0; r < model_.landmarks(); ++r)
    put(static_cast<int>(model_.poses()) + images_.landmark(r), &step.landmark[3 * r]);
}

int Schur::intrinsics_in_border(int column) const {
  const FreeIntrinsics& free = images_.intrinsics();
  const std::array<std::pair<int, int>, 3> parts{
      {{free.of_bottom(), kBottomIntrinsics}, {free.of_top(), kTopIntrinsics}, {free.mount(), kBottom}}};
  for (const auto& [first, global] : parts) {
    if (first >= 0 && column >= first) return layout_.column(global) + column - first;
  }
  return -1;
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
