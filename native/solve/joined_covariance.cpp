// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Marginals of a problem in parts: each part's information is condensed to what it shares, the sum of that is inverted, and
// from there each part inverts its own (docs/schur.md, *Parts*).
#include <algorithm>
#include <deque>
#include <set>

#include "common/blas_guard.h"
#include "common/errors.h"
#include "solve/covariance.h"

namespace hullrecon {
namespace {

[[noreturn]] void refuse() {
  throw StageError("the factors leave a direction undetermined", "parts", "add a prior or hold a block");
}

// The information of one part, and what stands where.
class PartInformation {
  // Of two shared blocks, i at or before j: what stands for them in the condensed system.
  auto left(size_t j, size_t i) {
    const int inner = system_->interior();
    return system_->condensed().block(system_->offset(interface_[j]) - inner, system_->offset(interface_[i]) - inner, width(j),
                                      width(i));
  }

 public:
  explicit PartInformation(const ProblemPart& part, int globals_from)
      : model_(*part.model), information_(model_), pages_(part.memory()) {
    for (const SharedBlock& shared : part.shared) share(shared.block, shared.number);
    const auto first = static_cast<int>(model_.poses() + model_.landmarks());
    for (int g = 0; g < kGlobals; ++g) {
      if (information_.position(first + g) >= 0) share(first + g, globals_from + g);
    }
    lay_out();
  }

  const std::vector<int>& numbers() const { return number_; }
  int width(size_t k) const { return information_.reduced().width(interface_[k]); }

  void condense() {
    const BlockMatrix& m = information_.reduced();
    system_->clear();
    for (int column = 0; column < m.blocks(); ++column) {
      m.visit_column(column, [&](int row, const auto& block) {
        row == column ? system_->add_own(column, block) : system_->add(row, column, block);
      });
    }
    if (!system_->factor()) refuse();
  }

  void add_to(ReducedSystem& top) {
    for (size_t i = 0; i < number_.size(); ++i) {
      top.add_own(number_[i], left(i, i));
      for (size_t j = i + 1; j < number_.size(); ++j) top.add(number_[j], number_[i], left(j, i));
    }
  }

  Covariance invert(const ReducedSystem& top) {
    for (size_t i = 0; i < number_.size(); ++i) {
      for (size_t j = i; j < number_.size(); ++j) left(j, i) = top.block(number_[j], number_[i]);
    }
    system_->invert();
    BlockMatrix& m = information_.reduced();
    for (int column = 0; column < m.blocks(); ++column) {
      m.visit_column(column, [&](int row, const auto&) { m.lower(row, column) = system_->block(row, column); });
    }
    return marginals(model_, information_);
  }

 private:
  void share(int block, int number) {
    const bool known = block >= 0 && block < static_cast<int>(model_.blocks().size()) && information_.position(block) >= 0;
    if (!known || number < 0) throw InputError("block " + std::to_string(block) + " of a part cannot be shared", "parts", "");
    interface_.push_back(information_.position(block));
    number_.push_back(number);
  }
  void lay_out() {
    const BlockMatrix& m = information_.reduced();
    std::vector<std::vector<int32_t>> meets(m.blocks());
    std::vector<int> width;
    for (int column = 0; column < m.blocks(); ++column) {
      width.push_back(m.width(column));
      m.visit_column(column, [&](int row, const auto&) {
        if (row != column) meets[row].push_back(column), meets[column].push_back(row);
      });
    }
    std::vector<int64_t> start{0};
    std::vector<int32_t> neighbours;
    for (const auto& others : meets) {
      neighbours.insert(neighbours.end(), others.begin(), others.end());
      start.push_back(static_cast<int64_t>(neighbours.size()));
    }
    system_ =
        std::make_unique<ReducedSystem>(std::move(width), 0, start, neighbours, model_.options().threads, interface_, pages_);
  }
  const Model& model_;
  Information information_;
  std::pmr::memory_resource* pages_;
  std::vector<int> interface_, number_;  // positions in the information; numbers among all that are shared
  std::unique_ptr<ReducedSystem> system_;
};

// The system of all shared blocks: two meet where a part has both. Those that are held have no width.
ReducedSystem top_of(const std::deque<PartInformation>& parts, int blocks, int threads) {
  std::vector<int> width(blocks, 0);
  std::vector<std::set<int>> meets(blocks);
  for (const PartInformation& part : parts) {
    for (size_t k = 0; k < part.numbers().size(); ++k) {
      width[part.numbers()[k]] = part.width(k);
      meets[part.numbers()[k]].insert(part.numbers().begin(), part.numbers().end());
    }
  }
  std::vector<int64_t> start{0};
  std::vector<int32_t> neighbours;
  for (int n = 0; n < blocks; ++n) {
    meets[n].erase(n);
    neighbours.insert(neighbours.end(), meets[n].begin(), meets[n].end());
    start.push_back(static_cast<int64_t>(neighbours.size()));
  }
  return ReducedSystem(std::move(width), 0, start, neighbours, threads);
}

}  // namespace

std::vector<Covariance> covariance(const std::vector<ProblemPart>& given) {
  const BlasGuard guard;
  int shared = 0;
  for (const ProblemPart& part : given) {
    for (const SharedBlock& block : part.shared) shared = std::max(shared, block.number + 1);
  }
  std::deque<PartInformation> parts;
  for (const ProblemPart& part : given) {
    part.model->refresh(false, true);
    parts.emplace_back(part, shared);
    part.rest();
  }
  ReducedSystem top = top_of(parts, shared + kGlobals, given.front().model->options().threads);
  top.clear();
  for (size_t k = 0; k < parts.size(); ++k) parts[k].condense(), parts[k].add_to(top), given[k].rest();
  if (!top.factor()) refuse();
  top.invert();
  std::vector<Covariance> out;
  for (const ProblemPart& part : given) {
    out.push_back(parts.front().invert(top));
    parts.pop_front();
    part.rest();
  }
  return out;
}

}  // namespace hullrecon
