// SPDX-License-Identifier: MIT
#include "pipeline/recording/recording_study.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/figure.h"
#include "datasets/results/results_file.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/recording/clock_errors.h"
#include "pipeline/recording/processing_time.h"
#include "pipeline/recording/recording_summary.h"
#include "pipeline/recording/recording_tables.h"
#include "pipeline/study/machine.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.study";
constexpr const char* kPaper = "Yang, Dong, El Saddik, arXiv 2212.14771";
constexpr const char* kAssumption = "assumption: no published figure";

void tell(Settings& s, NetworkSpec& n) {
  s("wire_s", n.wire_s, {0.0, 1.0}, "constant delay of a message");
  s("asymmetry_s", n.asymmetry_s, {-1.0, 1.0}, "more on the way to the sensor's machine");
  if (s.reading() && n.wire_s + n.asymmetry_s < 0.0)
    s.reading()->refuse("asymmetry_s",
                        "makes messages arrive before they are sent; \"wire_s\" must outweigh it");
  s("jitter_s", n.jitter_s, {0.0, 1.0}, "mean of the exponential part of the delay");
  double back_s = n.jitter_back_s.value_or(n.jitter_s);
  s("jitter_back_s", back_s, {0.0, 1.0}, "the same of messages to the server; without it jitter_s");
  n.jitter_back_s = back_s;
  s("lost_share", n.lost_share, {0.0, 1.0}, "of exchanges");
}

NetworkSpec read_network(JsonObject& object) {
  NetworkSpec network;
  network.name = object.text("name");
  if (network.name.empty()) object.refuse("name", "must not be empty");
  object.about({{"name", "of the network"}});
  Settings settings(object);
  tell(settings, network);
  object.finish();
  return network;
}

void read_networks(JsonObject& object, std::vector<NetworkSpec>& networks) {
  if (!object.has("networks")) return;
  networks.clear();
  for (JsonObject& entry : object.objects("networks")) {
    NetworkSpec network = read_network(entry);
    for (const NetworkSpec& other : networks)
      if (other.name == network.name) entry.refuse("name", "is there twice");
    networks.push_back(std::move(network));
  }
  if (networks.empty()) object.refuse("networks", "must hold at least one");
}

// A frame is timed by itself, so paths over time have no place here.
void read_methods(JsonObject& object, std::vector<MethodSpec>& methods) {
  if (!object.has("methods")) return;
  for (JsonObject& entry : object.objects("methods")) {
    MethodSpec method = read_method(entry);
    if (method.kind->over_time) entry.refuse("method", "must be one that takes a frame by itself");
    if (method.occlusion != OcclusionRule::off)
      entry.refuse("occlusion", "is of no use: occlusion is not looked for in this kind of study");
    for (const MethodSpec& other : methods)
      if (other.name == method.name) entry.refuse("name", "is there twice");
    methods.push_back(std::move(method));
  }
}

// A method that names a sensor which there is not is refused before anything is simulated.
void check_methods(const RecordingSpec& spec) {
  StudySpec study;
  study.methods = spec.methods;
  std::vector<std::string> rig;
  for (std::uint64_t s = 0; s < spec.sensors; ++s) rig.push_back(fmt::format("k{}", s + 1));
  resolve_methods(study, rig);
}

std::string delays_text(const NetworkSpec& n) {
  const double back_s = n.jitter_back_s.value_or(n.jitter_s);
  const std::string back = back_s != n.jitter_s ? fmt::format(", {:g} on the way back", back_s) : "";
  return fmt::format("{:g} + exponential of mean {:g}{}; {:g} more one way; {:g} of exchanges lost", n.wire_s,
                     n.jitter_s, back, n.asymmetry_s, n.lost_share);
}

}  // namespace

namespace {

void tell(Settings& s, RecordingSpec& r) {
  s("seed", r.seed, "of every random number");
  s("frames", r.frames, {2, 200'000}, "of a recording");
  s("rate_hz", r.rate_hz, {1.0, 1000.0}, "of frames");
  s("sensors", r.sensors, {1, 8}, "each with a machine of its own");
  s("runs", r.runs, {1, 250}, "recordings, each with other clocks");
  s("clock_offset_s", r.clock_offset_s, {0.0, 1000.0}, "uniform in +-, of a machine's clock at the start");
  s("clock_drift_ppm", r.clock_drift_ppm, {0.0, 400.0}, "uniform in +-, of a machine and of a sensor");
  s("exchange_period_s", r.exchange_period_s, {0.01, 3600.0}, "between two exchanges of clock messages");
  s("latency_s", r.latency_s, {0.0, 1.0}, "exposure to arrival, known");
  s("arrival_jitter_s", r.arrival_jitter_s, {0.0, 1.0}, "mean of the exponential part");
  s("late_s", r.late_s, {0.0, 10.0}, "the most by which a frame may be late for the paper's queue");
  s("body_tracking_s", r.body_tracking_s, {0.0, 1.0}, "of a depth image");
  s("body_tracking_jitter_s", r.body_tracking_jitter_s, {0.0, 1.0}, "mean of the exponential part");
}

}  // namespace

RecordingSpec parse_recording_spec(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  RecordingSpec spec;
  object.format(kFormat);
  object.choice("kind", {"recording"});
  spec.name = object.text("name");
  if (spec.name.empty()) object.refuse("name", "must not be empty");
  Settings settings(object);
  tell(settings, spec);
  read_networks(object, spec.networks);
  read_methods(object, spec.methods);
  object.about({{"name", "of the study"},
                {"networks", "over which clocks are compared"},
                {"methods", "that are timed, frame by frame"}});
  object.finish();
  check_methods(spec);
  return spec;
}

Json resolved_json(RecordingSpec spec) {
  Json json{{"format", kFormat}, {"version", 1}, {"kind", "recording"}, {"name", spec.name}};
  Settings settings(json);
  tell(settings, spec);
  json.update(Json{{"networks", Json::array()}, {"methods", Json::array()}});
  for (NetworkSpec& network : spec.networks) {
    json["networks"].push_back({{"name", network.name}});
    Settings of_network(json["networks"].back());
    tell(of_network, network);
  }
  for (const MethodSpec& method : spec.methods) json["methods"].push_back(resolved_json(method));
  return json;
}

std::vector<DeclaredParameter> recording_parameters(const RecordingSpec& s) {
  const auto text = [](double value) { return fmt::format("{:g}", value); };
  std::vector<DeclaredParameter> list{
      {"frames", std::to_string(s.frames), "", kPaper},
      {"frame rate", text(s.rate_hz), "Hz", kPaper},
      {"sensors", std::to_string(s.sensors), "", kPaper},
      {"clock at the start", "+-" + text(s.clock_offset_s), "s", kAssumption},
      {"clock drift", "+-" + text(s.clock_drift_ppm), "ppm", "tolerance of common crystal oscillators"},
      {"clock exchanges", "every " + text(s.exchange_period_s), "s", kAssumption},
      {"latency", text(s.latency_s), "s", "at least 20 ms by the sensor's makers; taken as known"},
      {"arrival jitter", text(s.arrival_jitter_s), "s, mean of exponential", kAssumption},
      {"limit of the queue", text(s.late_s), "s", kPaper},
      {"body tracking", text(s.body_tracking_s), "s",
       "under 5 ms on the Xbox 360: Shotton et al., Communications of the ACM 56(1), 2013"},
      {"body tracking, jitter", text(s.body_tracking_jitter_s), "s, mean of exponential", kAssumption}};
  for (const NetworkSpec& n : s.networks)
    list.push_back({n.name, delays_text(n), "s a message", kAssumption});
  return list;
}

namespace {

RecordingSummary summarise(const RecordingSpec& spec, const Outcomes& outcomes) {
  RecordingSummary summary;
  summary.study = spec.name;
  summary.seed = spec.seed;
  summary.frames = spec.frames;
  summary.sensors = spec.sensors;
  summary.runs = spec.runs;
  summary.late_s = spec.late_s;
  ClockErrorResults clocks = read_clocks(spec, outcomes);
  summary.clocks = std::move(clocks.rows);
  summary.fits = std::move(clocks.fits);
  summary.queues = std::move(clocks.queues);
  summary.claims = claims_of(summary);
  return summary;
}

}  // namespace

Study recording_study(const RecordingSpec& spec) {
  const Json resolved = resolved_json(spec);
  Study study{.kind = name_of(StudyKind::recording),
              .settings = resolved,
              .items = clock_items(spec),
              .write_beside =
                  [spec](const std::filesystem::path& folder) {
                    write_declared_parameters(folder, recording_parameters(spec));
                  },
              .reduce =
                  [spec](const Outcomes& outcomes, const std::filesystem::path& results, const Watch&) {
                    const RecordingSummary summary = summarise(spec, outcomes);
                    store_tables(results, recording_tables(summary, read_beside<StageTimings>(results)));
                    write_beside(results, StoredFigures{});
                    write_results(results, summary, -1);
                  },
              .manifest = [resolved] { return manifest_of_generated(resolved); }};
  if (!spec.methods.empty())
    study.time = [spec](const std::filesystem::path& folder, const Watch& watch) {
      write_beside(folder, StageTimings{spec.name, processor_name(), time_processing(spec, watch)});
    };
  return study;
}

}  // namespace trilat
