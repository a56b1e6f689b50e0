// SPDX-License-Identifier: MIT
// How often methods are ordered without truth as the truth orders them, in simulated campaigns all over the
// ranges of a study of variations. Usage: blind_ranking STUDY.json [CAMPAIGNS]
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "datasets/base/strict_json.h"
#include "evaluators/metrics/share.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/tracking_summary.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/variations/variations_spec.h"

namespace trilat {
namespace {

constexpr const char* kCriteria[] = {"the sensor left out", "bones that change", "jerk"};
constexpr double kApart[] = {0.0, 0.02, 0.05, 0.1};  // pairs whose true errors differ by more

struct Agreement {  // by campaign
  std::vector<double> agreeing, pairs;
};

std::vector<double> errors_m(const ResultsSummary& summary) {
  std::vector<double> errors;
  for (const std::string& method : summary.methods) {
    const SummaryCell* cell =
        find_cell(summary, method, summary.conditions.front(), kAverageGroup, summary.alignments.front());
    errors.push_back(cell && cell->coverage() > 0.8 ? cell->mae_m : kNoNumber);
  }
  return errors;
}

int run(const std::filesystem::path& file, std::size_t campaigns) {
  Json study = read_json(file);
  study.erase("scales");
  study["points"] = campaigns;
  VariationsSpec spec = parse_variations(study, file.string(), file.parent_path(), {});
  spec.study.alignments = {AlignmentKind::none};
  std::array<std::array<Agreement, std::size(kApart)>, std::size(kCriteria)> agreements;
  std::array<double, std::size(kCriteria)> worse{};
  double judged = 0.0;
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("blind-ranking-{}", getpid());
  for (std::size_t row = 0; row < campaigns; ++row) {
    const Campaign campaign = simulate_campaign(simulation_at(spec, row), folder / "campaign", {});
    StudySpec blind = spec.study;
    blind.truth = TruthSource::left_out_sensor;
    const std::vector<double> truth_m = errors_m(execute_study(spec.study, campaign, folder / "seen", {}));
    const std::vector<double> left_out_m = errors_m(execute_study(blind, campaign, folder / "blind", {}));
    std::array<std::vector<double>, std::size(kCriteria)> criteria{left_out_m, {}, {}};
    const TrackingSummary tracking = read_beside<TrackingSummary>(folder / "blind").value();
    for (const PredictionRow& p : tracking.predictions) {
      criteria[1].push_back(p.bone_m.value);
      criteria[2].push_back(p.jerk_m_s3.value);
    }
    const auto known = [&](std::size_t m) {
      return std::isfinite(truth_m[m]) && std::isfinite(left_out_m[m]);
    };
    for (std::size_t c = 0; c < criteria.size(); ++c) {
      std::size_t best = truth_m.size(), truly_best = truth_m.size();
      std::array<std::array<double, 2>, std::size(kApart)> counts{};
      for (std::size_t a = 0; a < truth_m.size(); ++a) {
        if (!known(a)) continue;
        if (best == truth_m.size() || criteria[c][a] < criteria[c][best]) best = a;
        if (truly_best == truth_m.size() || truth_m[a] < truth_m[truly_best]) truly_best = a;
        for (std::size_t b = 0; b < a; ++b)
          for (std::size_t k = 0; known(b) && k < std::size(kApart); ++k) {
            if (std::abs(std::log(truth_m[a] / truth_m[b])) <= std::log1p(kApart[k])) continue;
            counts[k][0] += (truth_m[a] < truth_m[b]) == (criteria[c][a] < criteria[c][b]);
            counts[k][1] += 1.0;
          }
      }
      for (std::size_t k = 0; k < counts.size(); ++k) {
        agreements[c][k].agreeing.push_back(counts[k][0]);
        agreements[c][k].pairs.push_back(counts[k][1]);
      }
      if (best < truth_m.size()) worse[c] += truth_m[best] / truth_m[truly_best] - 1.0;
    }
    judged += 1.0;
    std::filesystem::remove_all(folder);
    fmt::print(stderr, "\r{} of {} ", row + 1, campaigns);
  }
  fmt::print(stderr, "\n");
  for (std::size_t c = 0; c < std::size(kCriteria); ++c) {
    fmt::print("{}: its best method errs by {:.1f} % more than the truly best, on average\n", kCriteria[c],
               100.0 * worse[c] / judged);
    for (std::size_t k = 0; k < std::size(kApart); ++k) {
      const Agreement& a = agreements[c][k];
      double agreeing = 0.0, pairs = 0.0;
      for (std::size_t i = 0; i < a.pairs.size(); ++i) agreeing += a.agreeing[i], pairs += a.pairs[i];
      const ShareEstimate share = estimate_share(a.agreeing, a.pairs);
      fmt::print(
          "  pairs that differ by more than {:.0f} %: {:.1f} % ordered rightly ({:.1f} to {:.1f}), of "
          "{:.0f}\n",
          100.0 * kApart[k], 100.0 * agreeing / pairs, 100.0 * share.low, 100.0 * share.high, pairs);
    }
  }
  return 0;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: blind_ranking STUDY.json [CAMPAIGNS]\n", stderr);
    return 2;
  }
  return trilat::run(argv[1], argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 40);
}
