// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <tuple>

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

}  // namespace trilat
