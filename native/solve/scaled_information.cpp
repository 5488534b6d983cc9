// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
#include "solve/scaled_information.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/errors.h"

namespace hullrecon {
namespace {

const char* coordinate(const std::string& name, int size, int k) {
  static constexpr std::array<const char*, 7> motion{"x", "y", "z", "rotation x", "rotation y", "rotation z", "tray angle"};
  static constexpr std::array<const char*, 6> navigation{"DVL scale",  "heading drift", "roll bias",
                                                         "pitch bias", "depth bias",    "tray backlash"};
  static constexpr std::array<const char*, 9> intrinsics{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  if (name == "navigation") return navigation[k];
  if (name.starts_with("link_switch")) return "value";
  if (name.starts_with("lens")) return "displacement";
  return size == 9 ? intrinsics[k] : size == 1 ? "offset" : motion[k];
}

std::string name_of(const Model& model, const Information& information, int scalar) {
  const BlockMatrix& m = information.reduced();
  int p = 0;
  while (m.offset(p + 1) <= scalar) ++p;
  const int block = information.block_at(p);
  const std::string name = model.name_of(block);
  return name + " " + coordinate(name, model.blocks()[block].size, scalar - m.offset(p));
}

}  // namespace

void ScaledInformation::refuse(const Model& model, const Information& information) const {
  const std::vector<double> scaled = weakest_direction(lower);
  std::vector<int> order(scaled.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto larger = [&](int a, int b) { return std::abs(scaled[a]) > std::abs(scaled[b]); };
  const size_t shown = std::min<size_t>(3, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<long>(shown), order.end(), larger);
  std::string where;
  for (size_t k = 0; k < shown; ++k) where += (k ? ", " : "") + name_of(model, information, order[k]);
  throw StageError("the factors leave a direction undetermined, foremost in it", where, "add a prior or hold a block");
}

ScaledInformation::ScaledInformation(const Model& model, Information& information) {
  BlockMatrix& m = information.reduced();
  Lower& a = lower;
  scale.assign(m.size(), 0.0);
  m.each_scalar([&](int r, int c, double& v) {
    if (r == c) scale[r] = v > 0 ? 1 / std::sqrt(v) : 0;
  });
  for (int i = 0; i < m.size(); ++i) {
    if (scale[i] > 0) continue;
    throw StageError("no factor determines it", name_of(model, information, i), "add a prior or hold the block");
  }
  a.size = m.size();
  int column = -1;
  m.each_scalar([&](int r, int c, double& v) {
    for (; column < c; ++column) a.start.push_back(static_cast<int>(a.row.size()));
    a.row.push_back(r);
    a.value.push_back(r == c ? 1.0 : v * scale[r] * scale[c]);
  });
  a.start.push_back(static_cast<int>(a.row.size()));
}

}  // namespace hullrecon
