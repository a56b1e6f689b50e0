// SPDX-License-Identifier: MIT
// `trilat compare`: joints that any method or system gave, against motion capture.
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "datasets/base/text_output.h"
#include "datasets/results/table.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/external/external_joints.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct CompareArguments {
  std::filesystem::path truth, mapping, output = "out/compare";
  std::vector<std::filesystem::path> files;
  std::string up;
  bool clock_by_motion = false, force = false, json = false;
  int threads = 0;
};

Campaign campaign_of(const CompareArguments& a) {
  Take take;
  take.id = file_name_from(a.truth.stem().string());
  take.participant = "one";
  take.activity = take.id;
  take.mocap = a.truth;
  take.mapping = a.mapping;
  if (!a.up.empty()) take.up_axis = a.up == "z" ? UpAxis::z : UpAxis::y;
  std::set<std::string> names;
  for (const std::filesystem::path& file : a.files) {
    const std::string name = file.stem().string();
    if (!names.insert(name).second)
      throw InputError(file.string(), "is called \"" + name + "\" as a file before it; rename one of them");
    take.joints.push_back({name, file, {}, a.clock_by_motion});
  }
  return {.name = take.id, .takes = {take}, .folder = a.truth.parent_path()};
}

// The truth's own frames are the instants.
double rate_of(const std::filesystem::path& truth) {
  const MocapTake positions = read_markers(truth);
  if (std::isfinite(positions.header.export_rate_hz)) return positions.header.export_rate_hz;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < positions.time.size(); ++i)
    steps_s.push_back((positions.time[i] - positions.time[i - 1]).seconds());
  if (steps_s.empty()) throw InputError(truth.string(), "has fewer than two frames");
  return 1.0 / upper_median(steps_s);
}

StudySpec study_of(const CompareArguments& a) {
  constexpr double kMaxRate_hz = 1000.0;  // of a study
  const double own_hz = rate_of(a.truth);
  const double rate_hz = own_hz / std::ceil(own_hz / kMaxRate_hz);
  return parse_study({{"format", "trilat.study"},
                      {"version", 1},
                      {"kind", "accuracy"},
                      {"name", "compare"},
                      {"alignments", {"none", "mean", "rigid"}},
                      {"truth_gap_s", std::max(0.055, 1.6 / rate_hz)},
                      {"rate_hz", rate_hz}},
                     "compare", {});
}

int compare(const CompareArguments& a) {
  const Campaign campaign = campaign_of(a);
  std::vector<std::filesystem::path> inputs = a.files;
  inputs.insert(inputs.end(), {a.truth, a.mapping});
  const OutputMark mark{"compare", {"compare"}, campaign.name};
  check_output_folder({a.output, inputs, a.force}, mark);
  const StudySpec study = study_of(a);
  mark_output(a.output, mark);
  const ResultsSummary summary = [&] {
    Progress progress("comparing");
    return execute_study(study, campaign, a.output,
                         {.threads = a.threads,
                          .stop_requested = stop_requested,
                          .progress = [&](double share) { progress.set(share); }});
  }();
  for (const TakeNote& note : summary.notes) {
    if (note.failed) throw InputError(note.place, note.text);
    fmt::print(stderr, "note: {}: {}\n", note.place, note.text);
  }
  if (a.json)
    fmt::print("{}\n", json_text(Json{{"results", a.output.string()},
                                      {"errors", errors_json(summary, summary.alignments)}},
                                 2));
  else {
    print_stored(a.output);
    fmt::print("results: {}\nnext: trilat report {} -o report\n", a.output.string(),
               shell_word(a.output.string()));
  }
  const bool any_answered = std::ranges::any_of(summary.numbers.all(), [](const Number& number) {
    return number.measure == "answered" && number.value > 0.0;
  });
  return any_answered ? kDone : kItemsFailed;
}

}  // namespace

void add_compare(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<CompareArguments>(
      app, code, "compare", "joints that any method or system gave, against motion capture", compare);
  verb.add_option("truth", a.truth, "OptiTrack CSV, TRC, or CSV of joints")->required();
  verb.add_option("files", a.files, "TRC, OptiTrack CSV, or CSV of joints, one a method")->required();
  verb.add_option(
      "--mapping", a.mapping,
      "mapping.json of the truth's assets; without it the names that both files have are compared");
  verb.add_option("--up", a.up, "the axis of the files that points up; y where it is not stated")
      ->check(CLI::IsMember(words_of<UpAxis>()));
  verb.add_flag("--clock-by-motion", a.clock_by_motion, "put each file at the start that its motion shows");
  verb.add_option("-o,--output", a.output, "results folder")->capture_default_str();
  add_threads(verb, a.threads);
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.footer("Example: trilat compare truth.csv mine.trc other.trc --mapping mapping.json");
}

}  // namespace trilat
