// SPDX-License-Identifier: MIT
#include "pipeline/errors/track_samples.h"

#include "evaluators/metrics/body_metrics.h"

namespace trilat {
namespace {

// Whether the truth is known at the instants from i - before to i + behind.
bool has_truth(const Window& w, std::uint64_t i, std::size_t j, std::uint64_t before, std::uint64_t behind) {
  if (i < w.begins() + before || i + behind >= w.ends()) return false;
  for (std::uint64_t k = i - before; k <= i + behind; ++k)
    if (!w.truth_m(k, j).allFinite()) return false;
  return true;
}

}  // namespace

SampleMarks::SampleMarks(const Windows& windows, const TakeHead& head, double rate_hz)
    : instants_(head.instants),
      marks_(head.joints.size() * head.instants),
      answered_(head.methods.size(), SampleSet(marks_.size())),
      truth_(head.joints.size()) {
  windows.each([&](const Window& w) {
    for (std::size_t j = 0; j < truth_.size(); ++j) {
      truth_[j].quantity = static_cast<std::uint32_t>(j);
      for (std::uint64_t i = w.first; i < w.end; ++i) {
        if (!has_truth(w, i, j, 0, 0)) continue;
        const std::size_t k = place(i, j);
        marks_[k] = kAsked;
        if (w.block.occluded[w.place(i, j)] > 0) marks_[k] |= kOccluded;
        for (std::size_t m = 0; m < answered_.size(); ++m)
          if (is_usable(w.status(w.slot(i, j, m)))) answered_[m].add(k);
        add_jerk(w, i, j, rate_hz);
      }
    }
  });
}

void SampleMarks::add_jerk(const Window& w, std::uint64_t i, std::size_t j, double rate_hz) {
  if (!has_truth(w, i, j, 1, 2)) return;
  ++truth_[j].jerks;
  truth_[j].jerk_m_s3 +=
      jerk_m_s3(w.truth_m(i - 1, j), w.truth_m(i, j), w.truth_m(i + 1, j), w.truth_m(i + 2, j), rate_hz);
}

}  // namespace trilat
