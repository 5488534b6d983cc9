// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Factors a symmetric positive definite matrix of blocks in place, by the multifrontal method [DuffReid1983, Liu1992]: each
// front adds what its children leave to its panel, eliminates its own columns and leaves the rest to its parent. Subtrees go to
// threads; every sum has a fixed order, so the bytes do not depend on their number. A root that is kept is left to others: it
// becomes the Schur complement of all before it, to be joined with those of other parts of a problem. Without
// such a root, in a PageFile, only the panels at work are in memory: of many parts the sum is larger than any of them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <memory>
#include <memory_resource>
#include <vector>

#include "common/page_file.h"
#include "common/task_pool.h"
#include "sparse/front_tree.h"

namespace hullrecon {

class Fronts {
 public:
  // pages: memory for the matrix. It has no values before clear().
  Fronts(FrontTree tree, int threads, bool keeps_root = false,
         std::pmr::memory_resource* pages = std::pmr::get_default_resource());

  const FrontTree& tree() const { return tree_; }
  void clear();
  void rest(int front);  // removes its panel from memory if that is large and stands in a file
  // Index of scalar (row, column) of a front's panel, both counted from the panel's top left.
  double* at(int front, int row, int column) {
    const Front& f = tree_.fronts()[front];
    return value_.get() + f.value + int64_t{column} * f.height + row;
  }
  bool factor();  // the lower half becomes the factor's; false: not positive definite
  // The least pivot of the factor, as a share of the matrix's own diagonal there: one less the squared multiple correlation.
  double least_pivot() const { return *std::min_element(least_pivot_.begin(), least_pivot_.end()); }
  // x := inverse(L) x, then x := inverse(L') x. A kept root has the right side that belongs to it after the first, and must
  // have its solution before the second.
  void forward(Eigen::VectorXd& x);
  void backward(Eigen::VectorXd& x);
  // From the factor to the entries of the inverse on its pattern [Takahashi1973]: with the columns J of a front, the rows R
  // below them and Y = L_RJ L_JJ^-1, Z_RJ = -Z_RR Y and Z_JJ = L_JJ^-T L_JJ^-1 - Y' Z_RJ, parents before children. A kept root
  // has to hold its own entries of the inverse.
  void invert();

 private:
  enum class Order { Up, Down };
  template <class Visit>
  void climb(int front, const Visit& visit);
  template <class Visit>
  void descend(int front, const Visit& visit);
  template <class Visit>
  void visit_all(Order order, const Visit& visit);
  int root() const { return static_cast<int>(tree_.fronts().size()) - 1; }
  bool is_kept(int front) const { return keeps_root_ && front == root(); }
  void factor_front(int front);
  void take_own(int child);
  void take_rest(int child);
  void take_column(int child, size_t run, int k, double* to) const;
  void eliminate(int front);
  void forward(int front, Eigen::VectorXd& x);
  void backward(int front, Eigen::VectorXd& x);
  Eigen::MatrixXd inverse_below(int front);
  void invert_front(int front);

  FrontTree tree_;
  int threads_;
  bool keeps_root_;
  double grain_;  // work of a subtree that one thread does alone
  // In which the panels stand that are removed from memory one by one. null: none are. Those of a part are needed together.
  const PageFile* file_;
  // Bytes. In a file and on the heap alike: OpenBLAS factors in another order of sums where a panel begins elsewhere.
  static constexpr size_t kAlignment = 64;
  struct Return {
    std::pmr::memory_resource* pages;
    size_t bytes;
    void operator()(double* values) const { pages->deallocate(values, bytes, kAlignment); }
  };
  std::unique_ptr<double[], Return> value_;
  std::vector<std::unique_ptr<double[]>> rest_;  // what a front leaves to its parent until that took it: lower half, by columns
  std::vector<double> least_pivot_;              // of each front
  std::vector<int64_t> carried_start_;
  std::vector<double> carried_;  // the same of the right side
  std::atomic<bool> definite_ = true;
  TaskPool pool_;  // last: it uses all of the above
};

}  // namespace hullrecon
