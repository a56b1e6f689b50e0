// SPDX-License-Identifier: MIT
#include "pipeline/gate/paired_sums.h"

#include <cmath>

namespace trilat {

void PairedCounts::merge(const PairedCounts& later) {
  asked += later.asked;
  both += later.both;
  lost += later.lost;
  gained += later.gained;
  for (std::size_t s = 0; s < status_now.size(); ++s) {
    status_before[s] += later.status_before[s];
    status_now[s] += later.status_now[s];
  }
}

PairedTakeSums::PairedTakeSums(const PairedAxes& axes, std::uint64_t blocks)
    : axes_(axes),
      sums_(RowMatrix::Zero(static_cast<Eigen::Index>(blocks),
                            static_cast<Eigen::Index>(axes.cells() * PairedColumns::count))),
      counts_(axes.cells()) {}

void PairedTakeSums::add(std::uint64_t block, std::size_t joint, std::size_t method, std::size_t sets,
                         const PairedAnswer& before, const PairedAnswer& now) {
  for (std::size_t a = 0; a < axes_.alignments; ++a)
    for (std::size_t set = 0; set < sets; ++set) {
      const std::size_t cell = axes_.cell(a, set, axes_.group_of_joint[joint], method);
      double* sums =
          &sums_(static_cast<Eigen::Index>(block), static_cast<Eigen::Index>(cell * PairedColumns::count));
      PairedCounts& counts = counts_[cell];
      const bool was = !std::isnan(before.error_m[a]), is = !std::isnan(now.error_m[a]);
      ++counts.asked;
      counts.both += was && is;
      counts.lost += was && !is;
      counts.gained += is && !was;
      ++counts.status_before[static_cast<std::size_t>(before.status)];
      ++counts.status_now[static_cast<std::size_t>(now.status)];
      sums[PairedColumns::asked] += 1.0;
      sums[PairedColumns::net_lost] += static_cast<double>(was) - static_cast<double>(is);
      if (!was || !is) continue;
      sums[PairedColumns::difference] += now.error_m[a] - before.error_m[a];
      sums[PairedColumns::both] += 1.0;
      sums[PairedColumns::before] += before.error_m[a];
      sums[PairedColumns::net_clamped] += static_cast<double>(now.status == SolveStatus::clamped) -
                                          static_cast<double>(before.status == SolveStatus::clamped);
    }
}

void PairedTakeSums::finish(PairedTake& take) {
  take.sums = std::move(sums_);
  take.cells = std::move(counts_);
}

}  // namespace trilat
