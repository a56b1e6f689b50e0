// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "datasets/base/strict_json.h"

namespace trilat {

// Of a study and of its results.
enum class StudyKind : std::uint8_t {
  accuracy,
  threshold_sweep,
  calibration,
  error_budget,
  recording,
  sensitivity
};
std::string name_of(StudyKind kind);  // "accuracy", …
// What the study says; InputError when that is none.
StudyKind study_kind(const Json& study, const std::string& place);

// Which reader `folder` wants; InputError when it is no results folder of this version.
StudyKind results_kind(const std::filesystem::path& folder);

// The parts that the summaries of every kind share.
Json read_results_json(const std::filesystem::path& folder);  // summary.json
Json results_head(StudyKind kind);                            // its first keys
// Refuses other formats, versions and kinds. A summary without a kind is one of accuracy.
void check_results_head(JsonObject& object, StudyKind wanted);

// Refuses other formats and versions of a file that stands beside the summary.
void check_format(JsonObject& object, const std::string& format, int version);

// A number, or the null that stands for NaN.
double number_or_nan(JsonObject& object, const std::string& key);

Json counts_json(const std::map<std::string, std::uint64_t>& counts);
std::map<std::string, std::uint64_t> read_counts(JsonObject object);

}  // namespace trilat
