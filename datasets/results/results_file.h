// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/numbers.h"

namespace trilat {

// Of a study and of its results.
enum class StudyKind : std::uint8_t { accuracy, threshold_sweep, calibration, clocks };
std::string name_of(StudyKind kind);  // "accuracy", …
// What the study says; InputError when that is none.
StudyKind study_kind(const Json& study, const std::string& place);

// The experiment of the paper that a study repeats, whose claims its numbers are evidence on.
enum class PaperStudy : std::uint8_t { none, table1, table2, table3, sensors, calibration, clocks };
inline const std::vector<std::string> kPaperStudies{"none",    "table1",      "table2", "table3",
                                                    "sensors", "calibration", "clocks"};
inline constexpr const char* kPaperStudyMeaning =
    "the paper's experiment that the study repeats: its claims are judged by these results";
inline const std::string& name_of(PaperStudy paper) {
  return kPaperStudies.at(static_cast<std::size_t>(paper));
}

// Which reader `folder` wants; InputError when it is no results folder of this version.
StudyKind results_kind(const std::filesystem::path& folder);
StudyKind results_kind(JsonObject& summary);  // the same of its summary.json

// The parts that the summaries of every kind share.
Json read_results_json(const std::filesystem::path& folder);  // summary.json
Json results_head(StudyKind kind);                            // its first keys
// Refuses other formats, versions and kinds.
void check_results_head(JsonObject& object, StudyKind wanted);

// InputError where manifest.json and the summary beside it, of this kind, study and campaign, are of
// different runs. A campaign without a name is not compared.
void check_same_run(JsonObject& manifest, StudyKind kind, const std::string& study,
                    const std::string& campaign);

// Refuses other formats and versions of a file that stands beside the summary.
void check_format(JsonObject& object, const std::string& format, int version);

// summary.json and numbers.csv of a study. The struct states its kind, `static constexpr StudyKind kKind`,
// and has its `numbers` and how many there are, `rows`.
template <Described T>
void write_results(const std::filesystem::path& folder, const T& summary) {
  write_numbers(folder, summary.numbers);
  Json json = results_head(T::kKind);
  json.update(json_of(summary));
  json["rows"] = summary.numbers.all().size();
  write_file(folder / "summary.json", json_text(json, 1) + "\n");
}
// InputError with the place when a file is not there, damaged, or not of that kind and version.
template <Described T>
T read_results(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, T::kKind);
  T summary;
  read_fields(object, summary);
  summary.numbers = read_numbers(folder, summary.rows);
  return summary;
}

// A file that stands beside the summary. The struct states its name and format: `static constexpr const char
// *kFile, *kFormat`.
template <Described T>
void write_beside(const std::filesystem::path& folder, const T& value, int indent = 1) {
  Json json{{"format", T::kFormat}, {"version", 1}};
  json.update(json_of(value));
  write_file(folder / T::kFile, json_text(json, indent) + "\n");
}
// Nothing without the file; InputError when it is not one of these.
template <Described T>
std::optional<T> read_beside(const std::filesystem::path& folder) {
  const auto path = folder / T::kFile;
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, T::kFormat, 1);
  std::optional<T> value(std::in_place);
  read_fields(object, *value);
  return value;
}

}  // namespace trilat
