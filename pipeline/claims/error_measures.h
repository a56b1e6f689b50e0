// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "datasets/results/numbers.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {

// The group of numbers that are averages over the joint groups of which the paper prints errors.
inline constexpr const char* kPaperJoints = "the paper's joints";
// Groups of joints that the paper prints for a condition.
std::vector<std::string> printed_groups(const std::string& condition);

// Families of methods are compared by way of this method.
inline constexpr const char* kVia = "nonlinear";
inline constexpr std::string_view kBestOf = "best of ";

// The numbers that the paper's claims on accuracy are judged by and that a study can give, under its first
// alignment; `measure` and `statistic` are
// - "distance", "relative_difference": (method - against) / against, over the samples that both answer. A
// name is
//   that of a method; of a family, whose methods are taken together; or "best of FAMILY": for each cluster
//   the method of it that does best on all others, so that no cluster is judged by whom they helped to
//   choose. "share_compared" says how many of the samples both answer;
// - "place", "relative_difference": the method's error at the key's group against that at the group
// `against`, or
//   without a group of its own in the condition `against`;
// - "abrupt", "relative_difference": the error of nonlinear in the half of each joint's samples with the
// larger
//   acceleration, against the rest;
// - "clock_cost", "share_in_5ms": how far the fastest of the joints goes in 5 ms, in shares of the method's
// error
//   there;
// - "y" of the joint "wrist_right": "mean_largest", over the takes, and "mean_abs", of its height.
Numbers claimed_numbers(const StudyErrors& errors);

}  // namespace trilat
