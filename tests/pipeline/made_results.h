// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/json.h"
#include "datasets/base/philox.h"
#include "datasets/results/summary.h"
#include "tests/pipeline/program.h"

namespace trilat {

// What one sample of made-up results is like; a test changes what it wants to be worse.
struct MadeSample {
  std::size_t take = 0, joint = 0, method = 0;
  std::uint64_t instant = 0;
  double error_m = 0.0;
  bool answered = true;
};
using Spoil = std::function<void(MadeSample&)>;

struct MadeStudy {
  std::string name = "walks";
  std::size_t participants = 10;
  std::uint64_t instants = 300;
  double rate_hz = 30.0;
  bool simulated = true;
  std::uint64_t seed = 1;
  std::string input_sha256 = "00";
  std::size_t same_takes = 0;    // so many of the first keep the hash "00"
  std::size_t first_person = 0;  // the number in the first participant's name
  std::uint64_t takes_failed = 0;
};

// The rows of all takes, joints and methods.
inline std::vector<TakeJointRow> made_rows(const MadeStudy& study, const Spoil& spoil) {
  constexpr std::array kJoints{"head", "wrist_left", "wrist_right"};
  constexpr std::array kMethods{"linear", "nonlinear"};
  std::vector<TakeJointRow> rows;
  for (std::size_t t = 0; t < study.participants; ++t)
    for (std::size_t j = 0; j < kJoints.size(); ++j)
      for (std::size_t m = 0; m < kMethods.size(); ++m) {
        const std::string person = "p" + std::to_string(study.first_person + t);
        TakeJointRow row{person + "-walking",       person,     "walking",
                         j == 0 ? "head" : "wrist", kJoints[j], kMethods[m]};
        const RandomStream random{study.seed, Purpose::test, t * 3 + j};
        double sum_m = 0.0;
        for (std::uint64_t i = 0; i < study.instants; ++i) {
          MadeSample sample{t, j, m, i, 0.05 + 0.01 * random.uniform(static_cast<std::uint32_t>(i))};
          if (spoil) spoil(sample);
          ++row.asked;
          if (!sample.answered) continue;
          ++row.answered;
          sum_m += sample.error_m;
        }
        if (row.answered > 0) row.mae_m = sum_m / static_cast<double>(row.answered);
        rows.push_back(row);
      }
  return rows;
}

inline void write_made_manifest(const std::filesystem::path& folder, const MadeStudy& study) {
  Json takes = Json::array(), inputs = Json::array(), items = Json::object();
  for (std::size_t p = 0; p < study.participants; ++p) {
    const std::string name = "p" + std::to_string(study.first_person + p);
    takes.push_back({{"id", name + "-walking"},
                     {"participant", name},
                     {"activity", "walking"},
                     {"mocap_start_host_ns", 7},
                     {"instants", study.instants}});
    items["takes/" + name + "-walking"] = "key" + std::to_string(p);
    inputs.push_back({{"take", name + "-walking"},
                      {"role", "session"},
                      {"sha256", p < study.same_takes ? "00" : study.input_sha256}});
  }
  const Json json{
      {"format", "trilat.manifest"},
      {"version", 2},
      {"program", "trilat test"},
      {"study",
       {{"kind", "accuracy"}, {"name", study.name}, {"rate_hz", study.rate_hz}, {"alignments", {"none"}}}},
      {"simulated", study.simulated},
      {"takes", takes},
      {"inputs", inputs},
      {"items", items}};
  write_file(folder / "manifest.json", json_text(json, 1) + "\n");
}

// A results folder of an accuracy study without its items. Its summary has one cell only.
inline void write_made_results(const std::filesystem::path& folder, const MadeStudy& study = {},
                               const Spoil& spoil = {}) {
  std::filesystem::create_directories(folder);
  write_made_manifest(folder, study);
  ResultsSummary summary;
  summary.study = study.name;
  summary.takes = study.participants;
  summary.takes_failed = study.takes_failed;
  summary.participants = study.participants;
  summary.methods = {"linear", "nonlinear"};
  summary.reference = "linear";
  summary.conditions = {"walking"};
  summary.groups = {"head", "wrist"};
  summary.alignments = {"none"};
  for (const TakeJointRow& row : made_rows(study, spoil)) add_row(row, summary);
  MadeSample sample{0, 0, 1, 0, 0.055};
  if (spoil) spoil(sample);
  const NumberKey key{.condition = "walking", .group = "head", .method = "nonlinear", .alignment = "none"};
  summary.numbers.add({key.with({.measure = "answered", .statistic = "share"}), 1.0, kNaN, kNaN, 100});
  summary.numbers.add(
      {key.with({.measure = "distance", .statistic = "mean"}), sample.error_m, kNaN, kNaN, 100});
  for (std::uint64_t f = 0; f < study.takes_failed; ++f)
    summary.notes.push_back({"p" + std::to_string(f) + "-walking", true, "session.h5", "is damaged"});
  write_results(folder, summary);
  write_file(folder / "run.json", "{}\n");
}

// Errors of `nonlinear` at the head that are so many times as large.
inline Spoil larger_errors(double factor) {
  return [factor](MadeSample& s) {
    if (s.method == 1 && s.joint == 0) s.error_m *= factor;
  };
}

// Two nights in a folder.
struct Nights {
  ScratchFolder folder;

  Nights() = default;
  Nights(const MadeStudy& study, const Spoil& spoil) { write(spoil, study); }
  std::string now() const { return (folder / "now").string(); }
  std::string before() const { return (folder / "before").string(); }
  void write(const Spoil& spoil, const MadeStudy& study = {}) {
    write_made_results(folder / "before", study);
    write_made_results(folder / "now", study, spoil);
  }
  Ended gate(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"gate", now(), "--baseline", before()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_trilat(folder, arguments);
  }
};

}  // namespace trilat
