// SPDX-License-Identifier: MIT
// `trilat measure-tracker`.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/tracker/watched_takes.h"

namespace trilat {
namespace {

struct MeasureTrackerArguments {
  std::vector<std::filesystem::path> campaigns;
  std::filesystem::path output;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

// Three digits say more than the intervals do.
double rounded(double value) { return std::stod(fmt::format("{:.3g}", value)); }

std::string text_of(const MeasuredParameter& m) {
  return std::isfinite(m.low) ? fmt::format("{:.3g} ({:.3g} to {:.3g})", m.value, m.low, m.high)
                              : fmt::format("{:.3g} (no interval: {} participants)", m.value, m.participants);
}

// The declared document with what was measured in the place of what was declared. The source of a parameter
// of groups counts those who say something of any group.
Json document_of(const TrackerMeasurement& measurement, const std::string& takes,
                 const std::string& campaigns) {
  Json document = declared_body_tracker();
  std::map<std::string, std::size_t> participants;
  for (const MeasuredParameter& m : measurement.measured)
    participants[m.name] = std::max(participants[m.name], m.participants);
  for (const MeasuredParameter& m : measurement.measured) {
    Json& entry = document.at(m.group.empty() ? "values" : "groups").at(m.name);
    entry[m.group.empty() ? "value" : m.group] = rounded(m.value);
    if (std::isfinite(m.low)) {
      Json& interval = m.group.empty() ? entry["interval"] : entry["interval"][m.group];
      interval = {rounded(m.low), rounded(m.high)};
    }
    entry["source"] =
        fmt::format("measured on {}; {} of them tell it ({})", takes, participants[m.name], campaigns);
  }
  return document;
}

void print(const TrackerMeasurement& measurement) {
  std::string last;
  for (const MeasuredParameter& m : measurement.measured) {
    if (m.name != last) fmt::print("{}\n", m.name);
    fmt::print("  {:10} {}\n", m.group, text_of(m));
    last = m.name;
  }
  for (const UntoldParameter& u : measurement.untold) fmt::print("{}: left as declared; {}\n", u.name, u.why);
}

int measure_tracker(const MeasureTrackerArguments& a) {
  check_output({a.output, OutputKind::body_tracker, a.campaigns, a.force});
  std::vector<WatchedTake> takes;
  std::set<std::string> participants;
  std::size_t left_out = 0;
  {
    Progress progress("measuring the tracker");
    for (std::size_t c = 0; c < a.campaigns.size(); ++c) {
      const auto n = static_cast<double>(a.campaigns.size());
      WatchedCampaign campaign = read_watched_takes(
          read_campaign(a.campaigns[c]),
          {stop_requested, [&](double share) { progress.set(0.5 * (static_cast<double>(c) + share) / n); }});
      for (const std::string& text : campaign.left_out) fmt::print(stderr, "note: left out: {}\n", text);
      left_out += campaign.left_out.size();
      for (WatchedTake& take : campaign.takes) {
        // nobody is known to be in two campaigns
        take.participant = fmt::format("{}: {}", a.campaigns[c].string(), take.participant);
        participants.insert(take.participant);
        takes.push_back(std::move(take));
      }
    }
    progress.set(0.5);
  }
  const TrackerMeasurement measurement = measure_tracker(takes);
  std::set<std::string> names;
  for (const auto& campaign : a.campaigns) names.insert(read_campaign(campaign).name);
  const std::string measured_on =
                        fmt::format("{} takes of {} participants", takes.size(), participants.size()),
                    campaigns = fmt::format("{}", fmt::join(names, ", "));
  const Json document = document_of(measurement, measured_on, campaigns);
  write_file(a.output, json_text(document, 2) + "\n");
  if (a.json)
    fmt::print("{}\n", json_text(document, 2));
  else {
    print(measurement);
    fmt::print("{}: measured on {} ({}); {} takes left out\n", a.output.string(), measured_on, campaigns,
               left_out);
  }
  return left_out == 0 ? kDone : kItemsFailed;
}

}  // namespace

void add_measure_tracker(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<MeasureTrackerArguments>(
      app, code, "measure-tracker",
      "takes with a truth, or of several sensors -> the parameters of the simulated tracker, with intervals",
      measure_tracker);
  verb.add_option("campaigns", a.campaigns, "folders of takes; a participant is known in one of them only")
      ->required();
  verb.add_option("-o,--output", a.output,
                  "body_tracker.json; simulation.json may name it as \"body_tracker\"")
      ->required();
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.footer(
      "What the takes do not tell stays as declared and is named. Intervals are over participants; fewer "
      "than three give none.\nExample: trilat measure-tracker ui-prmd kinectmultitrack -o body_tracker.json");
}

}  // namespace trilat
