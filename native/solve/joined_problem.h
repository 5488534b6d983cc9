// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// A problem in parts that share blocks: poses, nodes of the field, planes, switches, and all globals. Each part eliminates what
// is its own, landmarks included. What they leave on shared blocks and globals is summed and solved, so a step is that of the
// whole problem, whatever the parts are (docs/schur.md, *Parts*). Every factor and prior belongs to one part alone.
//
// Sums over parts have the order of the parts: the bytes depend on the parts and not on who computes them.
#pragma once

#include <memory>
#include <vector>

#include "common/page_file.h"
#include "solve/least_squares.h"

namespace hullrecon {

struct Covariance;  // solve/covariance.h

// A block that several parts hold.
struct SharedBlock {
  int block;   // of a part's model, a free one that is neither a landmark nor a global
  int number;  // among the blocks that are shared, the same in every part
};

struct ProblemPart {
  Model* model;
  std::vector<SharedBlock> shared;
  PageFile* pages = nullptr;  // memory for its tables and what is large, removed while other parts work; null: ordinary memory

  std::pmr::memory_resource* memory() const { return pages ? pages : std::pmr::get_default_resource(); }
};

class JoinedProblem final : public LeastSquares {
 public:
  // Throws InputError where parts do not fit together.
  explicit JoinedProblem(const std::vector<ProblemPart>& parts);
  ~JoinedProblem() override;

  void refresh(bool trial) override;
  std::optional<Costs> cost() override;
  void linearise() override;
  void scale() override;
  std::optional<double> step(double radius) override;
  Lengths move() override;
  void accept() override;
  void take_back() override;
  void describe(IterationRow& row) override;
  double gradient_norm() override;
  void end() override;
  Schur::Seconds seconds() const override;
  // Marginals at the model's unknowns, of each part what it holds, of landmarks if asked for. Throws StageError where something
  // is not determined.
  std::vector<Covariance> marginals(bool of_landmarks);

 private:
  struct Part;
  template <class Work>
  void each(const Work& work);  // work(part) for one part after the other; only this one's tables are in memory meanwhile,
                                // and of the top only what it touches
  void number_shared(const std::vector<ProblemPart>& parts);
  void place(Part& part);
  void count_once();
  void join(Part& part);
  void take_inverse(Part& part);
  double model_change();
  Eigen::VectorXd of_part(const Part& part, const Eigen::VectorXd& of_top) const;

  std::vector<std::unique_ptr<Part>> parts_;
  std::array<int, kGlobals> column_;    // first of a global in the border; -1: held in every part
  std::unique_ptr<PageFile> pages_;     // of the top; null: in memory
  std::unique_ptr<ReducedSystem> top_;  // of shared blocks and border
  int shared_ = 0, border_ = 0;
  Eigen::VectorXd gradient_, diagonal_, scale_, damping_, step_;  // of these, as top_ orders them
};

}  // namespace hullrecon
