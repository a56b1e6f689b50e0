// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/files.h"
#include "datasets/results/numbers.h"

namespace trilat {

// Kind of a study and of its results.
enum class StudyKind : std::uint8_t { accuracy, threshold_sweep, calibration, clocks };
template <>
inline constexpr std::array words<StudyKind>{"accuracy", "threshold_sweep", "calibration", "clocks"};
inline std::string name_of(StudyKind kind) { return word_of(kind); }
// Kind that a study states; InputError when that is none.
StudyKind study_kind(const Json& study, const std::string& place);

// The experiment of the paper that a study repeats, whose claims its numbers are evidence on.
enum class PaperStudy : std::uint8_t { none, table1, table2, table3, sensors, calibration, clocks };
template <>
inline constexpr std::array words<PaperStudy>{"none",    "table1",      "table2", "table3",
                                              "sensors", "calibration", "clocks"};
inline constexpr const char* kPaperStudyMeaning =
    "Experiment of the paper that the study repeats: its claims are judged by these results";
inline std::string name_of(PaperStudy paper) { return word_of(paper); }

// Which reader `folder` wants; InputError when it is no results folder of this version.
StudyKind results_kind(const std::filesystem::path& folder);
Json read_results_json(const std::filesystem::path& folder);  // summary.json

// The keys that summaries of every kind begin with; other formats and versions are refused, or other kinds.
void visit_results_head(Fields& f, StudyKind& kind);
void visit_results_head_of(Fields& f, StudyKind wanted);

// summary.json and numbers.csv of a study. The struct states its kind, `static constexpr StudyKind kKind`,
// and has its `numbers` and how many there are, `rows`.
template <Described T>
struct ResultsDocument {
  T summary;

  static void fields(auto& self, auto&& f) {
    visit_results_head_of(f, T::kKind);
    T::fields(self.summary, f);
  }
  void check(const JsonPlace& place) const {
    if constexpr (requires { summary.check(place); }) summary.check(place);
  }
};
template <Described T>
void write_results(const std::filesystem::path& folder, T summary) {
  write_numbers(folder, summary.numbers);
  summary.rows = summary.numbers.all().size();
  write_file(folder / "summary.json", json_text(json_of(ResultsDocument<T>{summary}), 1) + "\n");
}
// InputError with the place when a file is not there, damaged, or not of that kind and version.
template <Described T>
T read_results(const std::filesystem::path& folder) {
  auto summary = read_as<ResultsDocument<T>>(read_results_json(folder), {folder / "summary.json"}).summary;
  summary.numbers = read_numbers(folder, summary.rows);
  return summary;
}

// A file that stands beside the summary. The struct states its name: `static constexpr const char* kFile`.
template <Described T>
void write_json_file(const std::filesystem::path& folder, const T& value, int indent = 1) {
  write_file(folder / T::kFile, json_text(json_of(value), indent) + "\n");
}
// Reads a file of results; nothing without the file, InputError when it is not one of these.
template <Described T>
std::optional<T> read_json_file(const std::filesystem::path& folder) {
  const auto path = folder / T::kFile;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return read_as<T>(read_json(path), {path});
}

}  // namespace trilat
