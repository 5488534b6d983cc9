// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/solve.h"

#include <ceres/ceres.h>

#include <chrono>
#include <cmath>

#include "common/blas_guard.h"
#include "common/errors.h"
#include "factors/manifolds.h"

namespace hullrecon {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Refreshes closest triangles and hits for every new point; counts and holds nothing else.
class Refresh final : public ceres::EvaluationCallback {
 public:
  explicit Refresh(Model& model) : model_(model) {}
  void PrepareForEvaluation(bool, bool new_point) override {
    if (!new_point) return;
    const auto start = Clock::now();
    model_.refresh(!first_);
    first_ = false;
    seconds += since(start);
  }

  double seconds = 0;

 private:
  Model& model_;
  bool first_ = true;
};

// One row an iteration. After a rejected step the tables are those of the rejected point, so its row repeats the last one.
class Record final : public ceres::IterationCallback {
 public:
  Record(Model& model, std::vector<IterationRow>& rows, const std::function<bool()>& interrupted)
      : model_(model), rows_(rows), interrupted_(interrupted) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    if (interrupted_()) {
      stopped = true;
      return ceres::SOLVER_ABORT;
    }
    const bool accepted = s.step_is_successful || rows_.empty();
    IterationRow row{s.cost,
                     s.cost_change,
                     s.step_norm,
                     s.gradient_max_norm,
                     s.trust_region_radius,
                     s.cumulative_time_in_seconds,
                     accepted,
                     {},
                     0,
                     0,
                     0};
    if (accepted) {
      describe(row);
    } else {
      row.cost_by_kind = rows_.back().cost_by_kind;
      row.on_surface = rows_.back().on_surface;
      row.rays_missed = rows_.back().rays_missed;
    }
    rows_.push_back(row);
    return ceres::SOLVER_CONTINUE;
  }

  bool stopped = false;
  double seconds = 0;

 private:
  void describe(IterationRow& row) {
    const auto start = Clock::now();
    model_.association().accept();
    row.cost_by_kind = model_.costs();
    labels_.describe(model_, row);
    seconds += since(start);
  }

  Model& model_;
  std::vector<IterationRow>& rows_;
  const std::function<bool()>& interrupted_;
  LabelCount labels_;
};

// A factor of the model as Ceres takes it.
class Cost final : public ceres::CostFunction {
 public:
  Cost(const Model& model, int64_t factor, const std::vector<int32_t>& blocks) : model_(model), factor_(factor) {
    set_num_residuals(model.rows_of(factor));
    for (int32_t b : blocks) mutable_parameter_block_sizes()->push_back(model.blocks()[b].size);
  }
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    return model_.evaluate(factor_, parameter_block_sizes(), x, r, J);
  }

 private:
  const Model& model_;
  int64_t factor_;
};

// The loss of labels or of links. Its second derivative is left out.
class Loss final : public ceres::LossFunction {
 public:
  explicit Loss(const Robust& robust) : robust_(robust) {}
  void Evaluate(double s, double rho[3]) const override { robust_(s, rho[0], rho[1]), rho[2] = 0; }

 private:
  Robust robust_;
};

ceres::LossFunction* loss(const Robust& robust) {
  if (std::isfinite(robust.huber)) return new ceres::HuberLoss(robust.huber);
  return robust.mixture || std::isfinite(robust.scaling) ? new Loss(robust) : nullptr;
}

// The model owns the unknowns, the problem costs and losses; manifolds outlive the problem here.
struct Manifolds {
  PoseManifold pose;
  PoseTrayHeldManifold pose_tray_held;
  RigidManifold rigid;
};

void fill(ceres::Problem& problem, Manifolds& manifolds, Model& model, ceres::ParameterBlockOrdering& order) {
  std::vector<char> used(model.blocks().size());
  std::vector<int32_t> blocks;
  std::vector<double*> x;
  for (int64_t i = 0; i < model.factors(); ++i) {
    model.blocks_of(i, blocks);
    x.clear();
    for (int32_t b : blocks) x.push_back(model.blocks()[b].data), used[b] = 1;
    problem.AddResidualBlock(new Cost(model, i, blocks), loss(model.robust(i)), x);
  }
  for (size_t b = 0; b < used.size(); ++b) {
    if (!used[b]) continue;
    const Block& block = model.blocks()[b];
    if (block.size == 8)
      problem.SetManifold(block.data,
                          block.tangent == 7 ? static_cast<ceres::Manifold*>(&manifolds.pose) : &manifolds.pose_tray_held);
    if (block.size == 7) problem.SetManifold(block.data, &manifolds.rigid);
    if (block.tangent == 0) problem.SetParameterBlockConstant(block.data);
    order.AddElementToGroup(block.data, model.is_landmark(static_cast<int32_t>(b)) ? 0 : 1);
  }
}

ceres::Solver::Options settings(const Options& options, std::shared_ptr<ceres::ParameterBlockOrdering> order, bool landmarks) {
  ceres::Solver::Options o;
  o.linear_solver_type = landmarks ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
  o.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  if (landmarks) o.linear_solver_ordering = std::move(order);
  o.num_threads = options.threads;
  o.max_num_iterations = options.max_iterations;
  o.function_tolerance = options.function_tolerance;
  o.gradient_tolerance = options.gradient_tolerance;
  o.parameter_tolerance = options.parameter_tolerance;
  o.initial_trust_region_radius = options.initial_radius;
  o.max_num_consecutive_invalid_steps = 20;  // each refused step (rays lost) halves the radius, then quarters it, and so on
  o.update_state_every_iteration = true;     // the record reads the accepted point
  o.logging_type = ceres::SILENT;
  return o;
}

std::vector<std::pair<const char*, double>> parts(const ceres::Solver::Summary& s, double refresh, double record) {
  return {{"total", s.total_time_in_seconds},
          {"preprocess", s.preprocessor_time_in_seconds},
          {"residuals", s.residual_evaluation_time_in_seconds},
          {"jacobians", s.jacobian_evaluation_time_in_seconds},
          {"linear_solver", s.linear_solver_time_in_seconds},
          {"refresh", refresh},
          {"record", record}};
}

}  // namespace

Solution solve_by_ceres(Model& model, const std::function<bool()>& interrupted) {
  const BlasGuard guard;
  Refresh refresh(model);
  Manifolds manifolds;
  ceres::Problem::Options unowned;
  unowned.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  unowned.evaluation_callback = &refresh;
  ceres::Problem problem(unowned);
  auto order = std::make_shared<ceres::ParameterBlockOrdering>();
  fill(problem, manifolds, model, *order);
  ceres::Solver::Options options = settings(model.options(), order, order->GroupSize(0) > 0);
  Solution solution;
  Record record(model, solution.iterations, interrupted);
  options.callbacks.push_back(&record);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (record.stopped) throw Interrupted();
  if (!summary.IsSolutionUsable()) throw StageError("the solver failed", summary.message, "look at the start values");
  model.refresh(false, true);
  solution.converged = summary.termination_type == ceres::CONVERGENCE;
  solution.message = summary.message;
  solution.seconds = parts(summary, refresh.seconds, record.seconds);
  return solution;
}

}  // namespace hullrecon
