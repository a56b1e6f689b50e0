// SPDX-License-Identifier: MIT
// How often a study without mocap, which leaves out one sensor after the other, ranks methods as mocap does:
// in simulations spread over the space of a sensitivity study. Usage: blind_ranking STUDY.json [CAMPAIGNS]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <unistd.h>

#include "evaluators/metrics/sobol_indices.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/sensitivity/sensitivity_spec.h"
#include "pipeline/simulate/campaign_study.h"

namespace trilat {
namespace {

constexpr const char* kMethods = R"([{"name": "mean", "method": "mean"},
  {"name": "tracked mean", "method": "tracked_mean"}, {"name": "nonlinear", "method": "nonlinear"},
  {"name": "range_bearing", "method": "range_bearing", "sigma": "estimated"}])";

// Each method's error above that of the first, per cent, on all samples with fallbacks. NaN where unknown.
std::vector<double> percents_of(StudySpec study, TruthSource truth, const Campaign& campaign,
                                const std::filesystem::path& results) {
  study.truth = truth;
  const ResultsSummary summary = execute_study(study, campaign, results, {});
  std::vector<double> percents(summary.methods.size(), kNoNumber);
  percents[0] = 0.0;
  for (const DifferenceCell& cell : summary.differences)
    if (cell.group == kAverageGroup && cell.condition == summary.conditions.front())
      percents[static_cast<std::size_t>(std::ranges::find(summary.methods, cell.method) -
                                        summary.methods.begin())] = cell.complete_percent;
  return percents;
}

struct Tally {
  std::size_t pairs = 0, alike = 0;
};

std::size_t best_of(const std::vector<double>& percents) {
  return static_cast<std::size_t>(std::ranges::min_element(percents) - percents.begin());
}

int run(const std::filesystem::path& file, std::size_t campaigns) {
  Json json = read_json(file);
  json["methods"] = Json::parse(kMethods);
  json["claims"] = Json::parse(R"([{"name": "one", "better": "range_bearing", "than": ["mean"]}])");
  json["slices"] = Json::array();
  const SensitivitySpec spec = parse_sensitivity(json, file.string(), file.parent_path(), Json());
  const std::size_t factors = spec.head.factors.size();
  const auto design = saltelli_design(factors, campaigns);
  const std::filesystem::path scratch =
      std::filesystem::temp_directory_path() / ("blind_ranking-" + std::to_string(::getpid()));
  constexpr std::array<double, 3> kSizes{0.0, 2.0, 10.0};  // per cent: differences at least as large
  std::array<Tally, kSizes.size()> tallies;
  Tally winners;
  std::vector<double> regret_percent;
  for (std::size_t k = 0; k < campaigns; ++k) {
    const Campaign campaign =
        simulate_campaign(simulation_at(spec, design[k * (factors + 2)], 1 + k), scratch / "campaign", {});
    const auto seen = percents_of(spec.study, TruthSource::mocap, campaign, scratch / "seen");
    const auto blind = percents_of(spec.study, TruthSource::left_out_sensor, campaign, scratch / "blind");
    std::filesystem::remove_all(scratch);
    if (!std::ranges::all_of(seen, [](double p) { return std::isfinite(p); }) ||
        !std::ranges::all_of(blind, [](double p) { return std::isfinite(p); }))
      continue;
    for (std::size_t a = 0; a < seen.size(); ++a)
      for (std::size_t b = a + 1; b < seen.size(); ++b)
        for (std::size_t size = 0; size < kSizes.size(); ++size) {
          if (std::abs(seen[a] - seen[b]) < kSizes[size]) continue;
          ++tallies[size].pairs;
          tallies[size].alike += (seen[a] < seen[b]) == (blind[a] < blind[b]);
        }
    ++winners.pairs;
    winners.alike += best_of(seen) == best_of(blind);
    regret_percent.push_back(100.0 * ((100.0 + seen[best_of(blind)]) / (100.0 + seen[best_of(seen)]) - 1.0));
    std::fprintf(stderr, "\r%zu of %zu ", k + 1, campaigns);
  }
  const auto share = [](const Tally& tally) {
    return 100.0 * static_cast<double>(tally.alike) / static_cast<double>(tally.pairs);
  };
  std::fprintf(stderr, "\n");
  std::printf("simulated campaigns that both could judge: %zu of %zu\n", winners.pairs, campaigns);
  for (std::size_t size = 0; size < kSizes.size(); ++size)
    std::printf("pairs of methods at least %g %% apart by mocap: %zu, ranked alike without it: %.1f %%\n",
                kSizes[size], tallies[size].pairs, share(tallies[size]));
  std::printf("the same best method of %zu: %.1f %%\n", spec.head.methods.size(), share(winners));
  if (regret_percent.empty()) return 1;
  std::ranges::sort(regret_percent);
  std::printf(
      "the best method without mocap errs more than the best with it by: median %.1f %%, "
      "9 of 10 at most %.1f %%, largest %.1f %%\n",
      regret_percent[regret_percent.size() / 2], regret_percent[regret_percent.size() * 9 / 10],
      regret_percent.back());
  return 0;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: blind_ranking STUDY.json [CAMPAIGNS]\n");
    return 2;
  }
  return trilat::run(argv[1], argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 100);
}
