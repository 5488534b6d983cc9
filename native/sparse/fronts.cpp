// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/fronts.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include "common/parallel.h"

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
            const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
void dsymm_(const char* side, const char* uplo, const int* m, const int* n, const double* alpha, const double* a,
            const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
void dpotri_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
}

namespace hullrecon {
namespace {

constexpr int kTile = 128;           // columns that one call of the library takes, one task of the pool
constexpr int64_t kRests = 1 << 17;  // values of a panel that leaves the memory when its work is done: 1 MB
constexpr double kGrains = 64;       // pieces of work for each thread, at least; during one others may run ahead, and wait

// to := keep * to - rows rows', the first `width` columns of its lower half. rows: (height, depth).
void subtract_product(double keep, double* to, int to_stride, const double* rows, int stride, int height, int width,
                      int depth) {
  const double minus = -1;
  const int below = height - width;
  dsyrk_("L", "N", &width, &depth, &minus, rows, &stride, &keep, to, &to_stride);
  if (below > 0)
    dgemm_("N", "T", &below, &width, &depth, &minus, rows + width, &stride, rows, &stride, &keep, to + width, &to_stride);
}

// rows := rows inverse(lower)', lower: (size, size)
void divide(double* rows, int count, const double* lower, int size, int stride) {
  const double one = 1;
  dtrsm_("R", "L", "T", "N", &count, &size, &one, lower, &stride, rows, &stride);
}

// work(first, count) over [0, total) by tiles, each a task of the pool.
template <class Work>
void by_tiles(TaskPool& pool, int total, const Work& work) {
  if (total <= kTile) {
    if (total > 0) work(0, total);
    return;
  }
  TaskPool::Group tiles;
  for (int first = 0; first < total; first += kTile) {
    pool.add(tiles, [&work, first, count = std::min(kTile, total - first)] { work(first, count); });
  }
  pool.finish(tiles);
}

using Matrix = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

}  // namespace

Fronts::Fronts(FrontTree tree, int threads, bool keeps_root, std::pmr::memory_resource* pages)
    : tree_(std::move(tree)),
      threads_(thread_count(threads)),
      keeps_root_(keeps_root),
      file_(keeps_root ? nullptr : dynamic_cast<const PageFile*>(pages)),
      value_(static_cast<double*>(pages->allocate(sizeof(double) * tree_.values(), kAlignment)),
             Return{pages, sizeof(double) * tree_.values()}),
      rest_(tree_.fronts().size()),
      least_pivot_(tree_.fronts().size(), 1.0),
      pool_(threads_) {
  grain_ = tree_.fronts().back().work / (kGrains * threads_);
  carried_start_.assign(1, 0);
  for (const Front& f : tree_.fronts()) carried_start_.push_back(carried_start_.back() + f.below());
  carried_.resize(carried_start_.back());
}

void Fronts::clear() {
  const auto fill = [&](int64_t begin, int64_t end) {
    for (auto front = static_cast<int>(begin); front < end; ++front) {
      const Front& f = tree_.fronts()[front];
      std::fill_n(at(front, 0, 0), int64_t{f.height} * f.size, 0.0);
      rest(front);
    }
  };
  for_slabs(static_cast<int64_t>(tree_.fronts().size()), threads_, fill, 64);
}

void Fronts::rest(int front) {
  const Front& f = tree_.fronts()[front];
  if (file_ && int64_t{f.height} * f.size >= kRests) file_->rest(at(front, 0, 0), at(front, 0, f.size));
}

// Children before parents.
template <class Visit>
void Fronts::climb(int front, const Visit& visit) {
  const Front& f = tree_.fronts()[front];
  if (f.work < grain_) {
    for (int below : tree_.order().subspan(f.turn - f.descendants, f.descendants)) visit(below);
  } else {
    TaskPool::Group subtrees;
    for (int child : tree_.children(front)) pool_.add(subtrees, [&, child] { climb(child, visit); });
    pool_.finish(subtrees);
  }
  visit(front);
}

// Parents before children.
template <class Visit>
void Fronts::descend(int front, const Visit& visit) {
  const Front& f = tree_.fronts()[front];
  visit(front);
  if (f.work < grain_) {
    for (int turn = f.turn - 1; turn >= f.turn - f.descendants; --turn) visit(tree_.order()[turn]);
    return;
  }
  TaskPool::Group subtrees;
  for (int child : tree_.children(front)) pool_.add(subtrees, [&, child] { descend(child, visit); });
  pool_.finish(subtrees);
}

// visit(front) of all; after a failure no more.
template <class Visit>
void Fronts::visit_all(Order order, const Visit& visit) {
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
  const auto guarded = [&](int front) {
    if (failed) return;
    try {
      visit(front);
      rest(front);
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  };
  order == Order::Up ? climb(root(), guarded) : descend(root(), guarded);
  if (failure) std::rethrow_exception(failure);
}

bool Fronts::factor() {
  definite_ = true;
  visit_all(Order::Up, [&](int front) {
    if (definite_) factor_front(front);
  });
  return definite_;
}

void Fronts::factor_front(int front) {
  const Front& f = tree_.fronts()[front];
  rest_[front] = std::make_unique_for_overwrite<double[]>(int64_t{f.below()} * f.below());
  std::vector<double> own(f.size);
  for (int c = 0; c < f.size; ++c) own[c] = *at(front, c, c);
  for (int child : tree_.children(front)) take_own(child);
  if (!is_kept(front)) {
    eliminate(front);
    double least = 1;
    for (int c = 0; c < f.size; ++c) {
      const double pivot = *at(front, c, c) * *at(front, c, c) / own[c];
      least = std::isnan(pivot) ? 0 : std::min(least, pivot);
    }
    least_pivot_[front] = least;
  }
  for (int child : tree_.children(front)) take_rest(child), rest_[child].reset();
}

void Fronts::take_own(int child) {
  const int parent = tree_.fronts()[child].parent, size = tree_.fronts()[parent].size;
  const auto runs = tree_.runs(child);
  for (size_t a = 0; a < runs.size() && runs[a].to < size; ++a) {
    for (int k = 0; k < runs[a].length; ++k) take_column(child, a, k, at(parent, 0, runs[a].to + k));
  }
}

void Fronts::take_rest(int child) {
  const int parent = tree_.fronts()[child].parent, size = tree_.fronts()[parent].size;
  const int64_t stride = tree_.fronts()[parent].below();
  const auto runs = tree_.runs(child);
  for (size_t a = 0; a < runs.size(); ++a) {
    for (int k = 0; k < runs[a].length && runs[a].to >= size; ++k)
      take_column(child, a, k, rest_[parent].get() + (runs[a].to - size + k) * stride - size);
  }
}

// Column k of run a of what a child leaves, from its diagonal on. to: of its parent, row 0 at the parent's top.
void Fronts::take_column(int child, size_t a, int k, double* to) const {
  const auto runs = tree_.runs(child);
  const double* from = rest_[child].get() + int64_t{runs[a].from + k} * tree_.fronts()[child].below();
  for (int r = k; r < runs[a].length; ++r) to[runs[a].to + r] += from[runs[a].from + r];
  for (size_t b = a + 1; b < runs.size(); ++b) {
    for (int r = 0; r < runs[b].length; ++r) to[runs[b].to + r] += from[runs[b].from + r];
  }
}

// The rest is written, not added to: its first tile keeps nothing of what stood there.
void Fronts::eliminate(int front) {
  const Front& f = tree_.fronts()[front];
  if (f.height == 0) return;  // no border; the library refuses a panel without rows
  int first = 0;
  do {
    const int depth = std::min(kTile, f.size - first), next = first + depth;
    double* const corner = at(front, first, first);
    int info = 0;
    dpotrf_("L", &depth, corner, &f.height, &info);
    if (info != 0) return void(definite_ = false);
    by_tiles(pool_, f.height - next, [&](int row, int count) { divide(corner + depth + row, count, corner, depth, f.height); });
    by_tiles(pool_, f.size - next, [&](int column, int count) {
      const int c = next + column;
      subtract_product(1, at(front, c, c), f.height, at(front, c, first), f.height, f.height - c, count, depth);
    });
    by_tiles(pool_, f.below(), [&](int column, int count) {
      double* const to = rest_[front].get() + int64_t{column} * f.below() + column;
      const double* const rows = at(front, f.size + column, first);
      subtract_product(first > 0 ? 1 : 0, to, f.below(), rows, f.height, f.below() - column, count, depth);
    });
    first = next;
  } while (first < f.size);
}

void Fronts::forward(Eigen::VectorXd& x) {
  visit_all(Order::Up, [&](int front) { forward(front, x); });
}

void Fronts::backward(Eigen::VectorXd& x) {
  visit_all(Order::Down, [&](int front) { backward(front, x); });
}

void Fronts::forward(int front, Eigen::VectorXd& x) {
  const Front& f = tree_.fronts()[front];
  const int below = f.below();
  auto own = x.segment(tree_.offset(f.first), f.size);
  Eigen::Map<Eigen::VectorXd> carried(carried_.data() + carried_start_[front], below);
  carried.setZero();
  for (int child : tree_.children(front)) {
    const double* from = carried_.data() + carried_start_[child];
    for (const Run& run : tree_.runs(child)) {
      for (int r = 0; r < run.length; ++r) {
        const int to = run.to + r;
        (to < f.size ? own[to] : carried[to - f.size]) += from[run.from + r];
      }
    }
  }
  if (is_kept(front)) return;
  const Matrix panel(at(front, 0, 0), f.height, f.size, Eigen::OuterStride<>(f.height));
  panel.topRows(f.size).triangularView<Eigen::Lower>().solveInPlace(own);
  carried.noalias() -= panel.bottomRows(below) * own;
}

void Fronts::backward(int front, Eigen::VectorXd& x) {
  if (is_kept(front)) return;
  const Front& f = tree_.fronts()[front];
  const int below = f.below();
  auto own = x.segment(tree_.offset(f.first), f.size);
  Eigen::Map<Eigen::VectorXd> carried(carried_.data() + carried_start_[front], below);
  for (const FrontRow& row : tree_.rows(front)) {
    const int width = tree_.offset(row.block + 1) - tree_.offset(row.block);
    carried.segment(row.place - f.size, width) = x.segment(tree_.offset(row.block), width);
  }
  const Matrix panel(at(front, 0, 0), f.height, f.size, Eigen::OuterStride<>(f.height));
  own.noalias() -= panel.bottomRows(below).transpose() * carried;
  panel.topRows(f.size).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
}

void Fronts::invert() {
  visit_all(Order::Down, [&](int front) {
    if (!is_kept(front)) invert_front(front);
  });
}

// Z_RR of a front, its lower half, from the fronts above it: R is a clique of the filled graph.
Eigen::MatrixXd Fronts::inverse_below(int front) {
  const int size = tree_.fronts()[front].size, below = tree_.fronts()[front].below();
  const auto rows = tree_.rows(front);
  Eigen::MatrixXd out(below, below);
  for (size_t b = 0; b < rows.size(); ++b) {
    const int columns = tree_.width(rows[b].block);
    for (size_t a = b; a < rows.size(); ++a) {
      const auto at = tree_.position(rows[a].block, rows[b].block);
      const Front& above = tree_.fronts()[at.front];
      const double* const first = value_.get() + above.value + int64_t{at.column} * above.height + at.row;
      const int count = tree_.width(rows[a].block);
      out.block(rows[a].place - size, rows[b].place - size, count, columns) =
          Matrix(first, count, columns, Eigen::OuterStride<>(above.height));
    }
  }
  for (int above = tree_.fronts()[front].parent; above >= 0; above = tree_.fronts()[above].parent) rest(above);
  return out;
}

// Lower halves alone are read and written.
void Fronts::invert_front(int front) {
  const Front& f = tree_.fronts()[front];
  if (f.size == 0) return;
  const double one = 1, minus = -1, zero = 0;
  const int below = f.below();
  double *const own = at(front, 0, 0), *const y = own + f.size;
  if (below > 0) dtrsm_("R", "L", "N", "N", &below, &f.size, &one, own, &f.height, y, &f.height);
  int info = 0;
  dpotri_("L", &f.size, own, &f.height, &info);
  if (below == 0) return;
  const Eigen::MatrixXd z_rr = inverse_below(front);
  Eigen::MatrixXd z_rj(below, f.size);
  by_tiles(pool_, f.size, [&](int column, int count) {
    double* const to = z_rj.col(column).data();
    dsymm_("L", "L", &below, &count, &minus, z_rr.data(), &below, y + int64_t{column} * f.height, &f.height, &zero, to, &below);
  });
  by_tiles(pool_, f.size, [&](int column, int count) {
    const int rows = f.size - column;
    dgemm_("T", "N", &rows, &count, &below, &minus, y + int64_t{column} * f.height, &f.height, z_rj.col(column).data(), &below,
           &one, at(front, column, column), &f.height);
  });
  for (int c = 0; c < f.size; ++c) std::copy_n(z_rj.col(c).data(), below, at(front, f.size, c));
}

}  // namespace hullrecon
