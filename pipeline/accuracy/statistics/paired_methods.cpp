// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/paired_methods.h"

#include <optional>

namespace trilat {
namespace {

constexpr std::uint64_t kInMemoryBytes = 64'000'000;

// The samples of a take, visited as often as it takes.
class TakeVisits {
 public:
  TakeVisits(const SamplesFile& samples, const Axes& axes) : samples_(samples), axes_(axes) {
    const std::uint64_t instants = samples.header().takes[0].instants;
    if (instants * axes.joints * axes.methods * sizeof(double) * 3 <= kInMemoryBytes)
      whole_ = samples.read(0, 0, instants, SampleColumns::positions);
  }
  template <class Visit>
  void visit(const Visit& visit) const {
    if (whole_)
      visit_samples(*whole_, axes_, visit);
    else
      stream_take(samples_, axes_, SampleColumns::positions, visit, [](const SampleBlock&) {});
  }

 private:
  const SamplesFile& samples_;
  const Axes& axes_;
  std::optional<SampleBlock> whole_;
};

// Methods that answer the same samples of a take are of one class: what another method is compared with them
// on is the same, and is aligned and summed once.
class Pairing {
 public:
  Pairing(const StatisticsLayout& layout, std::uint64_t instants)
      : layout_(layout),
        training_end_(layout.training_end(instants)),
        competitor_(layout.axes.methods, kNone),
        answered_(layout.competitors.size(), std::vector<bool>(instants * layout.axes.joints)) {
    for (std::size_t c = 0; c < layout.competitors.size(); ++c) competitor_[layout.competitors[c]] = c;
  }

  PairTable of(const TakeVisits& take) {
    each_answer(take, [&](std::size_t c, std::size_t place, auto&&...) { answered_[c][place] = true; });
    find_classes();
    std::vector<AlignedSums> sums(layout_.axes.joints * columns());
    each_class(take,
               [&](std::size_t column, const SampleView& view, std::uint64_t i, std::size_t j,
                   std::size_t slot) { sums[j * columns() + column].add(view, i, j, slot, training_end_); });
    const AlignmentTable alignments =
        solve_alignments(sums, layout_.axes.joints, layout_.alignments.front(), training_end_);
    sums_.resize(layout_.axes.sets * layout_.axes.joints * columns());
    each_class(take, [&](std::size_t column, const SampleView& view, std::uint64_t i, std::size_t j,
                         std::size_t slot) {
      const AlignedError e = error_of(view, i, j, slot, alignments[j * columns() + column]);
      if (!e.asked || !is_usable(e.status)) return;
      for (std::size_t set = 0; set < view.sets(i, j); ++set) sum(set, j, column).add(e.error_m.norm());
    });
    return table();
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  struct Sum {
    std::uint64_t n = 0;
    double error_m = 0.0;
    void add(double length_m) {
      ++n;
      error_m += length_m;
    }
  };

  std::size_t columns() const { return answered_.size() * first_of_class_.size(); }
  std::size_t column(std::size_t competitor, std::size_t of_class) const {
    return competitor * first_of_class_.size() + of_class;
  }
  Sum& sum(std::size_t set, std::size_t joint, std::size_t column) {
    return sums_[(set * layout_.axes.joints + joint) * columns() + column];
  }

  // Calls visit(competitor, place, view, i, j, slot) for every answer.
  template <class Visit>
  void each_answer(const TakeVisits& take, const Visit& visit) const {
    take.visit([&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
      if (competitor_[m] == kNone || !is_usable(view.status(slot))) return;
      visit(competitor_[m], (view.block.first_instant + i) * layout_.axes.joints + j, view, i, j, slot);
    });
  }
  // Calls visit(column, view, i, j, slot) for every answer that all methods of a class have too.
  template <class Visit>
  void each_class(const TakeVisits& take, const Visit& visit) const {
    each_answer(take, [&](std::size_t c, std::size_t place, const SampleView& view, std::uint64_t i,
                          std::size_t j, std::size_t slot) {
      for (std::size_t q = 0; q < first_of_class_.size(); ++q)
        if (answered_[first_of_class_[q]][place]) visit(column(c, q), view, i, j, slot);
    });
  }

  void find_classes() {
    for (std::size_t c = 0; c < answered_.size(); ++c) {
      std::size_t q = 0;
      while (q < first_of_class_.size() && answered_[first_of_class_[q]] != answered_[c]) ++q;
      if (q == first_of_class_.size()) first_of_class_.push_back(c);
      class_.push_back(q);
    }
  }

  PairTable table() {
    const std::size_t count = answered_.size();
    PairTable table{layout_.axes.joints, count, {}};
    for (std::size_t set = 0; set < layout_.axes.sets; ++set)
      for (std::size_t j = 0; j < layout_.axes.joints; ++j)
        for (std::size_t a = 0; a < count; ++a)
          for (std::size_t b = 0; b < count; ++b) {
            const Sum &first = sum(set, j, column(a, class_[b])), &second = sum(set, j, column(b, class_[a]));
            table.cells.push_back({first.n, first.error_m, second.error_m});
          }
    return table;
  }

  const StatisticsLayout& layout_;
  std::uint64_t training_end_;
  std::vector<std::size_t> competitor_;      // by method
  std::vector<std::vector<bool>> answered_;  // by competitor; by instant and joint
  std::vector<std::size_t> class_;           // by competitor
  std::vector<std::size_t> first_of_class_;  // a competitor
  std::vector<Sum> sums_;                    // by set, joint and column
};

}  // namespace

PairTable pair_methods(const SamplesFile& samples, const StatisticsLayout& layout) {
  return Pairing(layout, samples.header().takes[0].instants).of(TakeVisits(samples, layout.axes));
}

}  // namespace trilat
