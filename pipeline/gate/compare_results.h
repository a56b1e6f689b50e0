// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "pipeline/errors/error_changes.h"
#include "pipeline/gate/gate_report.h"

namespace trilat {

// Sums of the error lengths of one method at one joint of a take, under the study's first alignment, over the
// samples that two results both answer.
struct CommonErrors {
  std::uint64_t samples = 0;
  double before_m = 0.0, now_m = 0.0;
};
using CommonErrorsOfRows = std::map<std::tuple<std::string, std::string, std::string>,  // take, joint, method
                                    CommonErrors>;

// Errors of these takes, from the samples that both results folders keep. A take that only one of them keeps
// is not in it, nor one that is held against left-out sensors.
CommonErrorsOfRows common_errors(const std::filesystem::path& before, const std::filesystem::path& now,
                                 const std::set<std::string>& takes);

// Compares each study that both folders have. Where takes have the same recordings, computing is
// deterministic, without chance: an alarm is a mean error that grew, answers that fell, or a take that
// lost a tenth of its answers, each by more than its limit; all other numbers that changed are listed. Takes
// of other recordings are judged by Student's t of the mean error between their participants, eight at least,
// with p values by Holm over all studies; of fewer the study is not judged, whatever its
// other takes say. A number of another kind of study is an alarm where it is worse by what better_of() says;
// where recordings are others, the study is not judged. Settings that differ are named, and the numbers are
// compared all the same. InputError when a side
// holds no results, or they have no study in common.
GateReport compare_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                           const GateLimits& limits = {});

// With fewer participants than this other recordings are not judged.
inline constexpr std::size_t kMinJudged = 8;

// Compares the errors of two accuracy results by take; `same`: the ids of the takes whose recordings are the
// same. Adds findings to the report. `common`: of rows that one side answers otherwise, errors on the samples
// that both answer.
void compare_takes(const std::string& study, const ErrorsByJoint& before, const ErrorsByJoint& now,
                   const std::vector<std::string>& same, const GateLimits& limits, GateReport& report,
                   const CommonErrorsOfRows& common = {});

// Compares the errors of two accuracy results of other recordings. The p values of the findings are not yet
// corrected, and no finding is an alarm: see adjust_p_values(). Gives what can be found, in percent of an
// average over the joint groups; NaN where nothing was compared.
double compare_unpaired(const std::string& study, const ErrorsByJoint& before, const ErrorsByJoint& now,
                        const GateLimits& limits, GateReport& report);
// Corrects the p values of all findings that have one, and keeps those that are significant.
void adjust_p_values(const GateLimits& limits, GateReport& report);

// How compare_numbers() treats numbers that changed by more than their limits.
enum class NumberRule : std::uint8_t {
  judge,      // worse is an alarm, and so is a number that is gone
  list,       // all are listed: the recordings are others
  list_rest,  // the same but for what takes are judged by
};
void compare_numbers(const std::string& study, const Numbers& before, const Numbers& now, NumberRule rule,
                     const GateLimits& limits, GateReport& report);

}  // namespace trilat
