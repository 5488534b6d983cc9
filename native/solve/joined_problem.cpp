// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/joined_problem.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "common/blas_guard.h"
#include "common/errors.h"
#include "common/free_memory.h"
#include "solve/covariance.h"
#include "solve/information.h"

namespace hullrecon {
namespace {

std::vector<int> interface_of(const ProblemPart& part) {
  const ReducedLayout layout(*part.model);
  std::vector<int> out;
  for (const SharedBlock& shared : part.shared) {
    const bool known = shared.block >= 0 && shared.block < static_cast<int>(part.model->blocks().size());
    const int block = known ? layout.block_of(shared.block) : -1;
    if (block < 0 || block >= layout.blocks() || shared.number < 0 || std::count(out.begin(), out.end(), block))
      throw InputError("block " + std::to_string(shared.block) + " of a part cannot be shared", "parts", "");
    out.push_back(block);
  }
  return out;
}

}  // namespace

struct JoinedProblem::Part {
  explicit Part(const ProblemPart& given)
      : model(woken(*given.model)),
        given(given),
        interface(interface_of(given)),
        schur(model, interface, given.memory()),
        x(model.unknowns()),
        shelf(given.pages) {
    for (const SharedBlock& shared : given.shared) number.push_back(shared.number);
    schur.shelve(shelf), labels.shelve(shelf);
    for (StepVector* of_step : {&scale, &damping, &step}) of_step->shelve(shelf);
    shelf.add(x, candidate, counted);
    rest();
  }
  static Model& woken(Model& model) { return model.wake(), model; }
  void wake() { model.wake(), shelf.take(); }
  void rest() {
    shelf.put(), model.rest();
    if (given.pages) given.pages->rest(), return_free_memory();
  }
  int offset(int block) const { return schur.offset(block) - schur.interior(); }  // among interface and border
  void set(const std::vector<double>& unknowns) { std::copy(unknowns.begin(), unknowns.end(), model.unknowns().begin()); }

  Model& model;
  const ProblemPart given;
  const std::vector<int> interface;  // blocks of the layout
  std::vector<int> number;           // of each, among all that are shared
  Schur schur;
  LabelCount labels;
  std::vector<int> to_top, border;  // rows of the top of the scalars of interface and border, and of the border
  struct Run {
    ptrdiff_t first;
    int count;
  };
  std::vector<Run> counted;  // unknowns whose lengths this part counts
  std::vector<double> x, candidate;
  StepVector scale, damping, step;
  Shelf shelf;
};

JoinedProblem::JoinedProblem(const std::vector<ProblemPart>& parts) {
  if (parts.empty()) throw InputError("there is none", "parts", "");
  for (const ProblemPart& part : parts) parts_.push_back(std::make_unique<Part>(part));
  number_shared(parts);
  each([&](Part& part) { place(part); });
  count_once();
  const int size = top_->size();
  for (Eigen::VectorXd* v : {&gradient_, &diagonal_, &scale_, &damping_, &step_}) v->setZero(size);
}

JoinedProblem::~JoinedProblem() = default;

template <class Work>
void JoinedProblem::each(const Work& work) {
  for (auto& part : parts_) {
    part->wake();
    work(*part);
    part->rest();
    if (pages_) pages_->rest();
  }
}

// The top system: two shared blocks have an entry where a part has both.
void JoinedProblem::number_shared(const std::vector<ProblemPart>& parts) {
  column_.fill(-1);
  std::array<int, kGlobals> of_global{};
  each([&](Part& part) {
    for (int g = 0; g < kGlobals; ++g)
      of_global[g] = std::max(of_global[g], part.model.blocks()[part.schur.layout().model_global(g)].tangent);
  });
  for (int g = 0; g < kGlobals; ++g) {
    if (of_global[g] > 0) column_[g] = border_;
    border_ += of_global[g];
  }
  for (const auto& part : parts_) {
    for (int n : part->number) shared_ = std::max(shared_, n + 1);
  }
  std::vector<int> width(shared_, 0);
  std::vector<std::set<int>> meets(shared_);
  for (const auto& part : parts_) {
    for (size_t k = 0; k < part->number.size(); ++k) {
      const int n = part->number[k], own = part->schur.layout().width(part->interface[k]);
      if (width[n] != 0 && width[n] != own)
        throw InputError("shared block " + std::to_string(n) + " differs between parts", "parts", "");
      width[n] = own;
      meets[n].insert(part->number.begin(), part->number.end());
    }
  }
  std::vector<int64_t> start{0};
  std::vector<int32_t> neighbours;
  for (int n = 0; n < shared_; ++n) {
    if (width[n] == 0) throw InputError("no part has shared block " + std::to_string(n), "parts", "");
    std::copy_if(meets[n].begin(), meets[n].end(), std::back_inserter(neighbours), [&](int m) { return m != n; });
    start.push_back(static_cast<int64_t>(neighbours.size()));
  }
  // Of many parts the top is larger than any of them.
  if (parts[0].pages) pages_ = std::make_unique<PageFile>(parts[0].pages->folder());
  top_ = std::make_unique<ReducedSystem>(std::move(width), border_, start, neighbours, parts[0].model->options().threads,
                                         std::nullopt, pages_ ? pages_.get() : std::pmr::get_default_resource());
}

void JoinedProblem::place(Part& part) {
  const ReducedLayout& layout = part.schur.layout();
  for (size_t k = 0; k < part.interface.size(); ++k) {
    for (int i = 0; i < layout.width(part.interface[k]); ++i) part.to_top.push_back(top_->offset(part.number[k]) + i);
  }
  for (int g = 0; g < kGlobals; ++g) {
    const int width = part.model.blocks()[layout.model_global(g)].tangent;
    for (int i = 0; i < width; ++i) part.border.push_back(column_[g] + i);
  }
  for (int column : part.border) part.to_top.push_back(top_->offset(shared_) + column);
}

// A block that several parts hold counts in lengths once, in the first of them. Held unknowns count, as in a problem held
// whole.
void JoinedProblem::count_once() {
  std::vector<char> shared(shared_, 0), global(kGlobals, 0);
  each([&](Part& part) {
    std::vector<int> number(part.schur.layout().blocks(), -1);
    for (size_t k = 0; k < part.interface.size(); ++k) number[part.interface[k]] = part.number[k];
    const auto& blocks = part.model.blocks();
    const auto size = static_cast<ptrdiff_t>(part.x.size());
    for (int b = 0; b < static_cast<int>(blocks.size()); ++b) {
      const ptrdiff_t first = blocks[b].data - part.model.unknowns().data();
      if (first < 0 || first >= size) continue;  // of a lens or a world that nothing meets
      const int at = part.schur.layout().block_of(b), g = part.schur.layout().global_of(b);
      char* const seen = g >= 0 && g < kGlobals ? &global[g] : at >= 0 && number[at] >= 0 ? &shared[number[at]] : nullptr;
      if (seen && std::exchange(*seen, 1)) continue;
      part.counted.push_back({first, blocks[b].size});
    }
  });
}

void JoinedProblem::refresh(bool trial) {
  Association::Beams all;
  each([&](Part& part) {
    part.model.refresh(trial);
    const auto beams = part.model.association().beams();
    all.missed += beams.missed, all.accepted_misses += beams.accepted_misses, all.count += beams.count;
  });
  for (auto& part : parts_) part->model.association().refuse(trial && all.loses_too_many());
}

std::optional<Costs> JoinedProblem::cost() {
  Costs sum{};
  bool evaluated = true;
  each([&](Part& part) {
    const auto costs = evaluated ? part.schur.cost() : std::nullopt;
    evaluated = costs.has_value();
    for (size_t k = 0; evaluated && k < sum.size(); ++k) sum[k] += (*costs)[k];
  });
  return evaluated ? std::optional(sum) : std::nullopt;
}

void JoinedProblem::linearise() {
  gradient_.setZero(), diagonal_.setZero();
  each([&](Part& part) {
    part.schur.linearise();
    for (size_t k = 0; k < part.to_top.size(); ++k) {
      gradient_[part.to_top[k]] += part.schur.gradient().reduced[part.schur.interior() + static_cast<int>(k)];
      diagonal_[part.to_top[k]] += part.schur.diagonal().reduced[part.schur.interior() + static_cast<int>(k)];
    }
  });
}

void JoinedProblem::scale() {
  scale_ = scale_of(diagonal_);
  each([](Part& part) { part.scale = {scale_of(part.schur.diagonal().landmark), scale_of(part.schur.diagonal().reduced)}; });
}

std::optional<double> JoinedProblem::step(double radius) {
  top_->clear();
  damping_ = damping(diagonal_, scale_, radius);
  step_.setZero();
  bool solved = true;
  each([&](Part& part) {
    const StepVector& diagonal = part.schur.diagonal();
    part.damping = {damping(diagonal.landmark, part.scale.landmark, radius),
                    damping(diagonal.reduced, part.scale.reduced, radius)};
    part.damping.reduced.tail(static_cast<Eigen::Index>(part.to_top.size())).setZero();  // the top has it
    solved = solved && part.schur.condense(part.damping);
    if (solved) join(part);
  });
  if (!solved) return std::nullopt;
  top_->add_diagonal(damping_);
  if (!top_->factor()) return std::nullopt;
  top_->solve(step_);
  each([&](Part& part) {
    part.step.reduced.resize(part.schur.gradient().reduced.size());
    part.step.reduced.tail(static_cast<Eigen::Index>(part.to_top.size())) = of_part(part, step_);
    solved = solved && part.schur.finish(part.step);
  });
  return solved ? std::optional(model_change()) : std::nullopt;
}

// Adds a part's Schur complement on shared blocks and border to the top's.
void JoinedProblem::join(Part& part) {
  const auto left = part.schur.condensed();
  const ReducedLayout& layout = part.schur.layout();
  const int first = part.offset(layout.blocks()), width = layout.border();
  const auto on_border = [&](const auto& m) {  // of the part, by rows of the top's border
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(border_, m.cols());
    for (int r = 0; r < width; ++r) out.row(part.border[r]) = m.row(r);
    return out;
  };
  for (size_t i = 0; i < part.interface.size(); ++i) {
    const int column = part.offset(part.interface[i]), columns = layout.width(part.interface[i]);
    top_->add_own(part.number[i], left.block(column, column, columns, columns));
    for (size_t j = i + 1; j < part.interface.size(); ++j) {
      const int row = part.offset(part.interface[j]), rows = layout.width(part.interface[j]);
      top_->add(part.number[j], part.number[i], left.block(row, column, rows, columns));
    }
    top_->add_border(part.number[i], on_border(left.block(first, column, width, columns)));
  }
  const Eigen::MatrixXd own = on_border(left.block(first, first, width, width));
  top_->add_own(shared_, on_border(own.transpose().eval()).transpose().eval());
  const auto gradient = part.schur.condensed_gradient();
  for (size_t k = 0; k < part.to_top.size(); ++k) step_[part.to_top[k]] -= gradient[static_cast<Eigen::Index>(k)];
}

Eigen::VectorXd JoinedProblem::of_part(const Part& part, const Eigen::VectorXd& of_top) const {
  return of_top(part.to_top);
}

// By how much the step lowers the cost of the linear problem.
double JoinedProblem::model_change() {
  double change = -0.5 * gradient_.dot(step_) + 0.5 * damping_.dot(step_.cwiseAbs2());
  each([&](Part& part) {
    const int interior = part.schur.interior();
    const StepVector &gradient = part.schur.gradient(), &damping = part.damping, &step = part.step;
    change += -0.5 * (gradient.landmark.dot(step.landmark) + gradient.reduced.head(interior).dot(step.reduced.head(interior)));
    change += 0.5 * (damping.landmark.dot(step.landmark.cwiseAbs2()) +
                     damping.reduced.head(interior).dot(step.reduced.head(interior).cwiseAbs2()));
  });
  return change;
}

LeastSquares::Lengths JoinedProblem::move() {
  Lengths squared{0, 0};
  each([&](Part& part) {
    part.schur.plus(part.x, part.step, part.candidate);
    part.set(part.candidate);
    for (const auto& [first, count] : part.counted) {
      for (ptrdiff_t k = first; k < first + count; ++k) {
        const double x = part.x[k], by = x - part.candidate[k];
        squared.unknowns += x * x, squared.step += by * by;
      }
    }
  });
  return {std::sqrt(squared.unknowns), std::sqrt(squared.step)};
}

void JoinedProblem::accept() {
  each([](Part& part) { part.x.swap(part.candidate); });
}

void JoinedProblem::take_back() {
  each([](Part& part) { part.set(part.x), part.schur.restore(); });
}

void JoinedProblem::describe(IterationRow& row) {
  each([&](Part& part) {
    IterationRow own{};
    part.model.association().accept();
    part.labels.describe(part.model, own);
    row.on_surface += own.on_surface, row.label_changes += own.label_changes, row.rays_missed += own.rays_missed;
  });
}

double JoinedProblem::gradient_norm() {
  double most = 0;
  each([&](Part& part) {
    part.step = {-part.schur.gradient().landmark, -part.schur.gradient().reduced};
    part.step.reduced.tail(static_cast<Eigen::Index>(part.to_top.size())) = -of_part(part, gradient_);
    part.schur.plus(part.x, part.step, part.candidate);
    for (size_t k = 0; k < part.x.size(); ++k) most = std::max(most, std::abs(part.x[k] - part.candidate[k]));
  });
  return most;
}

void JoinedProblem::end() {
  each([](Part& part) { part.set(part.x), part.model.refresh(false, true); });
}

std::vector<Covariance> JoinedProblem::marginals(bool of_landmarks) {
  const BlasGuard guard;
  bool determined = true;
  top_->clear();
  each([&](Part& part) {
    part.model.refresh(false, true);
    part.schur.linearise();
    determined = determined && part.schur.condense(part.schur.no_damping()) && part.schur.determines_all();
    if (determined) join(part);
  });
  constexpr double kVanished = 1e-12;  // of a pivot, as of a whole problem
  if (!determined || !top_->factor() || !(top_->least_pivot() > kVanished)) {
    each([](Part& part) { Information{part.model}; });  // names a landmark that its own factors do not determine
    throw StageError("the factors leave a direction undetermined", "parts", "add a prior or hold a block");
  }
  top_->invert();
  std::vector<Covariance> out;
  each([&](Part& part) {
    take_inverse(part);
    part.schur.invert();
    out.push_back(hullrecon::marginals(part.model, part.schur, of_landmarks));
  });
  return out;
}

// Gives a part the inverse of its interface and border.
void JoinedProblem::take_inverse(Part& part) {
  auto left = part.schur.condensed();
  const ReducedLayout& layout = part.schur.layout();
  const int first = part.offset(layout.blocks()), width = layout.border();
  for (size_t i = 0; i < part.interface.size(); ++i) {
    const int column = part.offset(part.interface[i]), columns = layout.width(part.interface[i]);
    for (size_t j = i; j < part.interface.size(); ++j) {
      const int row = part.offset(part.interface[j]), rows = layout.width(part.interface[j]);
      left.block(row, column, rows, columns) = top_->block(part.number[j], part.number[i]);
    }
    left.block(first, column, width, columns) = top_->block(shared_, part.number[i])(part.border, Eigen::all);
  }
  left.block(first, first, width, width) = top_->block(shared_, shared_)(part.border, part.border);
}

std::vector<Covariance> covariance(const std::vector<ProblemPart>& parts, bool of_landmarks) {
  return JoinedProblem(parts).marginals(of_landmarks);
}

Schur::Seconds JoinedProblem::seconds() const {
  Schur::Seconds sum;
  for (const auto& part : parts_) {
    const Schur::Seconds& own = part->schur.seconds;
    sum.eliminate += own.eliminate, sum.factor += own.factor, sum.back_substitute += own.back_substitute;
  }
  return sum;
}

}  // namespace hullrecon
