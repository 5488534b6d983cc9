// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "sparse/front_tree.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace hullrecon {
namespace {

// Two fronts are joined when the zeros that this adds are few: up to so many columns, up to this share of the panel.
constexpr std::array<std::pair<int, double>, 4> kJoin{{{14, 1.0}, {28, 0.2}, {112, 0.03}, {1 << 30, 0.01}}};

bool worth_joining(int columns, double zeros, double entries) {
  return std::any_of(kJoin.begin(), kJoin.end(),
                     [&](const auto& k) { return columns <= k.first && zeros <= k.second * entries; });
}

double panel(double height, double columns) {
  return columns * height - columns * (columns - 1) / 2;
}

}  // namespace

FrontTree::FrontTree(const std::vector<int>& width, const std::vector<int64_t>& start, const std::vector<int32_t>& below,
                     int kept)
    : offset_(1, 0), front_of_(width.size()) {
  for (int w : width) offset_.push_back(offset_.back() + w);
  const Rows rows = fill(start, below);
  gather(rows, kept);
  lay_out(rows);
  find_runs();
  count_work();
  find_children();
  find_order();
}

// The block rows below each column's own in the factor: its own, and those that its children in the elimination tree meet.
FrontTree::Rows FrontTree::fill(const std::vector<int64_t>& start, const std::vector<int32_t>& below) {
  const auto blocks = static_cast<int32_t>(start.size() - 1);
  Rows rows(blocks);
  std::vector<int32_t> both;
  for (int32_t b = 0; b < blocks; ++b) rows[b].assign(below.begin() + start[b], below.begin() + start[b + 1]);
  for (int32_t b = 0; b < blocks; ++b) {
    if (rows[b].empty()) continue;
    auto& parent = rows[rows[b][0]];
    both.clear();
    std::set_union(rows[b].begin() + 1, rows[b].end(), parent.begin(), parent.end(), std::back_inserter(both));
    parent = both;
    rows[b].shrink_to_fit();
  }
  return rows;
}

// From the root down: a column joins the front after it when that is its parent's and the zeros are worth it, or both are kept.
void FrontTree::gather(const Rows& rows, int kept) {
  const auto blocks = static_cast<int32_t>(rows.size()), first_kept = blocks - kept;
  double entries = 0, height = 0;  // of the front at hand: numbers that are not zeros by joining; rows and columns
  for (int32_t b = blocks - 1; b >= 0; --b) {
    double below = 0;
    for (int32_t r : rows[b]) below += offset_[r + 1] - offset_[r];
    const double width = offset_[b + 1] - offset_[b], own = panel(below + width, width);
    const bool chain = !fronts_.empty() && b + 1 != first_kept && rows[b][0] == b + 1;
    const int columns = chain ? offset_[fronts_.back().last] - offset_[b] : 0;
    const double whole = panel(height + width, columns);
    if (chain && (b >= first_kept || worth_joining(columns, whole - entries - own, whole))) {
      fronts_.back().first = b;
      entries += own, height += width;
    } else {
      fronts_.push_back({b, b + 1});
      entries = own, height = below + width;
    }
  }
  std::reverse(fronts_.begin(), fronts_.end());
  for (size_t f = 0; f < fronts_.size(); ++f) {
    for (int32_t b = fronts_[f].first; b < fronts_[f].last; ++b) front_of_[b] = static_cast<int>(f);
  }
}

void FrontTree::lay_out(const Rows& rows) {
  int64_t value = 0;
  for (Front& f : fronts_) {
    f.size = f.height = offset_[f.last] - offset_[f.first];
    for (int32_t r : rows[f.last - 1]) {
      rows_.push_back({r, f.height});
      f.height += offset_[r + 1] - offset_[r];
    }
    f.rows = static_cast<int64_t>(rows_.size());
    f.value = value;
    value += int64_t{f.height} * f.size;
    if (!rows[f.last - 1].empty()) f.parent = front_of_[rows[f.last - 1][0]];
  }
}

void FrontTree::find_runs() {
  for (int f = 0; f < static_cast<int>(fronts_.size()); ++f) {
    const int parent = fronts_[f].parent;
    const auto first = static_cast<int64_t>(runs_.size());
    auto above = parent >= 0 ? rows(parent).begin() : std::span<const FrontRow>::iterator{};
    for (const FrontRow& row : rows(f)) {
      const int from = row.place - fronts_[f].size, length = offset_[row.block + 1] - offset_[row.block];
      int to = offset_[row.block] - offset_[fronts_[parent].first];
      if (row.block >= fronts_[parent].last) {
        while (above->block < row.block) ++above;
        to = above->place;
      }
      const bool joins = static_cast<int64_t>(runs_.size()) > first && runs_.back().to + runs_.back().length == to &&
                         to != fronts_[parent].size;
      if (joins) {
        runs_.back().length += length;
      } else {
        runs_.push_back({from, to, length});
      }
    }
    fronts_[f].runs = static_cast<int64_t>(runs_.size());
  }
}

void FrontTree::count_work() {
  for (Front& f : fronts_) {
    const double n = f.size, m = f.height;
    f.work += n * n * n / 6 + n * n * (m - n) / 2 + n * (m - n) * (m - n) / 2 + (m - n) * (m - n);
    if (f.parent < 0) continue;
    fronts_[f.parent].work += f.work;
    fronts_[f.parent].descendants += f.descendants + 1;
  }
}

void FrontTree::find_children() {
  child_start_.assign(fronts_.size() + 1, 0), child_.resize(fronts_.size() - 1);
  for (const Front& f : fronts_) {
    if (f.parent >= 0) ++child_start_[f.parent + 1];
  }
  std::partial_sum(child_start_.begin(), child_start_.end(), child_start_.begin());
  std::vector<int32_t> next(child_start_.begin(), child_start_.end() - 1);
  for (size_t f = 0; f + 1 < fronts_.size(); ++f) child_[next[fronts_[f].parent]++] = static_cast<int32_t>(f);
}

// The child that needs more memory beyond what it leaves goes first; this is the order of least memory [Liu1992].
void FrontTree::find_order() {
  std::vector<double> most(fronts_.size());  // numbers that wait at a time in the subtree, what the front leaves counted in
  const auto leaves = [&](int f) { return double(fronts_[f].below()) * fronts_[f].below(); };
  for (int f = 0; f < static_cast<int>(fronts_.size()); ++f) {
    const std::span<int32_t> own{child_.data() + child_start_[f], children(f).size()};
    std::stable_sort(own.begin(), own.end(), [&](int a, int b) { return most[a] - leaves(a) > most[b] - leaves(b); });
    double waits = 0;
    for (int child : own) most[f] = std::max(most[f], waits + most[child]), waits += leaves(child);
    most[f] = std::max(most[f], waits + leaves(f));
  }
  order_.resize(fronts_.size());
  fronts_.back().turn = static_cast<int32_t>(fronts_.size()) - 1;
  for (int f = fronts_.back().turn; f >= 0; --f) {
    order_[fronts_[f].turn] = f;
    int32_t turn = fronts_[f].turn - fronts_[f].descendants;
    for (int child : children(f)) turn += fronts_[child].descendants, fronts_[child].turn = turn++;
  }
}

FrontTree::EntryPosition FrontTree::position(int row, int column) const {
  const int front = front_of_[column], top = offset_[fronts_[front].first];
  if (row < fronts_[front].last) return {front, offset_[row] - top, offset_[column] - top};
  const auto all = rows(front);
  const auto found =
      std::lower_bound(all.begin(), all.end(), row, [](const FrontRow& r, int block) { return r.block < block; });
  return {front, found->place, offset_[column] - top};
}

}  // namespace hullrecon
