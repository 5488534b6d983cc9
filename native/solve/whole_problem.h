// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solve/least_squares.h"

namespace hullrecon {

// A problem that one model holds, its steps by the Schur core.
class WholeProblem final : public LeastSquares {
 public:
  explicit WholeProblem(Model& model) : model_(model), schur_(model), x_(model.unknowns()) {}

  void refresh(bool trial) override { model_.refresh(trial); }
  std::optional<Costs> cost() override { return schur_.cost(); }
  void linearise() override { schur_.linearise(); }
  void scale() override { scale_ = {scale_of(schur_.diagonal().landmark), scale_of(schur_.diagonal().reduced)}; }
  std::optional<double> step(double radius) override;
  Lengths move() override;
  void accept() override { x_.swap(candidate_); }
  void take_back() override;
  void describe(IterationRow& row) override;
  double gradient_norm() override;
  void end() override;
  Schur::Seconds seconds() const override { return schur_.seconds; }

 private:
  void set(const std::vector<double>& unknowns) { std::copy(unknowns.begin(), unknowns.end(), model_.unknowns().begin()); }

  Model& model_;
  Schur schur_;
  LabelCount labels_;
  std::vector<double> x_, candidate_;
  StepVector scale_, step_;
};

}  // namespace hullrecon
