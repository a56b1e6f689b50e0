// SPDX-License-Identifier: MIT
#include "pipeline/errors/track_samples.h"

namespace trilat {

SampleFlags::SampleFlags(const Windows& windows, const TakeHead& head)
    : instants_(head.instants),
      marks_(head.joints.size() * head.instants),
      answered_(head.methods.size(), SampleSet(marks_.size())) {
  windows.each([&](const Window& w) {
    for (std::size_t j = 0; j < head.joints.size(); ++j)
      for (std::uint64_t i = w.first; i < w.end; ++i) {
        if (!w.has_truth(i, j)) continue;
        const std::size_t k = place(i, j);
        marks_[k] = kAsked;
        if (w.block.occluded[w.place(i, j)] > 0) marks_[k] |= kOccluded;
        for (std::size_t m = 0; m < answered_.size(); ++m)
          if (is_usable(w.status(w.slot(i, j, m)))) answered_[m].add(k);
      }
  });
}

}  // namespace trilat
