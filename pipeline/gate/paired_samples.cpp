// SPDX-License-Identifier: MIT
#include "pipeline/gate/paired_samples.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/samples.h"
#include "datasets/skeleton/skeleton.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::uint64_t kWindow = 512;  // instants that are read together

std::string names_of(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

void check_headers(const SamplesHeader& now, const SamplesHeader& before, const std::string& place) {
  const auto check = [&](const char* what, const std::string& here, const std::string& there) {
    if (here != there)
      throw InputError(place, fmt::format("holds other {}: {} here, {} there", what, there, here));
  };
  check("joints", names_of(now.joints), names_of(before.joints));
  check("methods", names_of(now.methods), names_of(before.methods));
  check("alignment", now.alignment, before.alignment);
  std::vector<std::string> ids, older;
  for (const TakeShape& take : now.takes) ids.push_back(take.id);
  for (const TakeShape& take : before.takes) older.push_back(take.id);
  check("takes", names_of(ids), names_of(older));
}

PairedStudy study_of(const ResultsPair& pair, const SamplesHeader& header) {
  PairedStudy study;
  const Json& spec = pair.now.manifest.at("study");
  study.study = pair.now.name;
  study.methods = header.methods;
  study.alignments = {header.alignment};
  const auto kinds = spec.value("alignments", std::vector<std::string>{});
  if (header.alignment != "none" && std::find(kinds.begin(), kinds.end(), "none") != kinds.end())
    study.alignments.emplace_back("none");
  for (const std::string& name : header.joints) {
    const auto joint = joint_from_name(name);
    const std::string group = joint ? table_group(*joint) : name;
    auto found = std::find(study.groups.begin(), study.groups.end(), group);
    if (found == study.groups.end()) found = study.groups.insert(study.groups.end(), group);
    study.axes.group_of_joint.push_back(static_cast<std::size_t>(found - study.groups.begin()));
  }
  study.axes.alignments = study.alignments.size();
  study.axes.sets = spec.value("occluded_apart", false) ? 2 : 1;
  study.axes.groups = study.groups.size();
  study.axes.methods = study.methods.size();
  for (const TakeShape& take : header.takes)
    study.takes.push_back({take.id, take.id, take.condition, {}, {}});
  for (const Json& take : pair.now.manifest.value("takes", Json::array()))
    for (PairedTake& known : study.takes)
      if (known.id == take.value("id", "")) known.participant = take.value("participant", known.participant);
  return study;
}

// One night's window of a take.
struct Night {
  SampleBlock block;
  std::vector<float> error_m;
  Night(const SamplesFile& samples, std::size_t take, std::uint64_t first, std::uint64_t instants)
      : block(samples.read(take, first, instants, SampleColumns::positions)),
        error_m(samples.read_errors(take, first, instants)) {}
  bool has_truth(std::size_t place) const {
    return std::all_of(&block.truth_m[3 * place], &block.truth_m[3 * place] + 3,
                       [](double x) { return std::isfinite(x); });
  }
  PairedAnswer answer(std::size_t place, std::size_t slot) const {
    const auto status = static_cast<SolveStatus>(block.status[slot]);
    if (!is_usable(status)) return {{GateFinding::kNone, GateFinding::kNone}, status};
    double aligned_m2 = 0.0, plain_m2 = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto aligned = static_cast<double>(error_m[3 * slot + axis]);
      const double plain = block.estimate_m[3 * slot + axis] - block.truth_m[3 * place + axis];
      aligned_m2 += aligned * aligned;
      plain_m2 += plain * plain;
    }
    return {{std::sqrt(aligned_m2), std::sqrt(plain_m2)}, status};
  }
};

struct TakeReader {
  const SamplesFile& now;
  const SamplesFile& before;
  const PairedAxes& axes;
  std::uint64_t block_instants;

  // False when the instants are not the same; then nothing is filled.
  bool read(std::size_t t, PairedTake& take, std::uint64_t& truths_that_differ) const {
    const std::uint64_t instants = now.header().takes[t].instants;
    if (instants != before.header().takes[t].instants) return false;
    PairedTakeSums sums(axes, (instants + block_instants - 1) / block_instants);
    for (std::uint64_t first = 0; first < instants; first += kWindow) {
      const std::uint64_t count = std::min(kWindow, instants - first);
      const Night here(now, t, first, count), there(before, t, first, count);
      if (here.block.time_ns != there.block.time_ns) return false;
      for (std::uint64_t i = 0; i < count; ++i) add_instant(here, there, first, i, sums, truths_that_differ);
    }
    sums.finish(take);
    return true;
  }

  void add_instant(const Night& here, const Night& there, std::uint64_t first, std::uint64_t i,
                   PairedTakeSums& sums, std::uint64_t& truths_that_differ) const {
    for (std::size_t j = 0; j < axes.group_of_joint.size(); ++j) {
      const std::size_t place = i * axes.group_of_joint.size() + j;
      if (!here.has_truth(place) || !there.has_truth(place)) continue;
      truths_that_differ += !std::equal(&here.block.truth_m[3 * place], &here.block.truth_m[3 * place] + 3,
                                        &there.block.truth_m[3 * place]);
      const std::size_t sets = axes.sets == 1 || there.block.occluded[place] == 0 ? 1 : 2;
      for (std::size_t m = 0; m < axes.methods; ++m) {
        const std::size_t slot = place * axes.methods + m;
        sums.add((first + i) / block_instants, j, m, sets, there.answer(place, slot),
                 here.answer(place, slot));
      }
    }
  }
};

}  // namespace

PairedSamples read_paired_samples(const ResultsPair& pair) try {
  const SamplesFile now = SamplesFile::open(pair.now.folder / "samples.h5");
  const SamplesFile before = SamplesFile::open(pair.before.folder / "samples.h5");
  check_headers(now.header(), before.header(), (pair.before.folder / "samples.h5").string());
  PairedSamples samples;
  samples.study = study_of(pair, now.header());
  const double rate_hz = pair.now.manifest.at("study").value("rate_hz", 30.0);
  const auto block = static_cast<std::uint64_t>(std::max(1LL, std::llround(kPairedBlock_s * rate_hz)));
  const TakeReader reader{now, before, samples.study.axes, block};
  std::vector<PairedTake>& takes = samples.study.takes;
  std::vector<std::uint8_t> paired(takes.size());
  std::vector<std::uint64_t> other_truths(takes.size());
  parallel_for_index(takes.size(), 1,
                     [&](std::size_t t) { paired[t] = reader.read(t, takes[t], other_truths[t]); });
  for (std::size_t t = 0; t < takes.size(); ++t) {
    samples.truths_that_differ += other_truths[t];
    if (paired[t]) continue;
    if (samples.takes_with_other_instants++ == 0) samples.first_with_other_instants = takes[t].id;
  }
  return samples;
} catch (const Json::exception& error) {
  throw InputError((pair.now.folder / "manifest.json").string(), error.what());
}

}  // namespace trilat
