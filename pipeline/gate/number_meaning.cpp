// SPDX-License-Identifier: MIT
#include "pipeline/gate/number_meaning.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <vector>

namespace trilat {
namespace {

std::vector<std::string> words_of(const std::string& key) {
  std::vector<std::string> words;
  std::istringstream stream(key);
  for (std::string word; std::getline(stream, word, '_');) words.push_back(word);
  return words;
}

template <std::size_t n>
bool has_any(const std::vector<std::string>& words, const std::array<std::string_view, n>& wanted) {
  return std::find_first_of(words.begin(), words.end(), wanted.begin(), wanted.end()) != words.end();
}

constexpr std::array<std::string_view, 2> kWholeKeys{"statuses", "sd_m"};
constexpr std::array<std::string_view, 4> kSpread{"low", "high", "clusters", "resamples"};
constexpr std::array<std::string_view, 8> kMoreIsBetter{"answered", "asked", "digits", "coverage",
                                                        "within",   "below", "ok",     "pck"};
constexpr std::array<std::string_view, 24> kMoreIsWorse{
    "mae", "mpjpe", "rmse",  "rms",    "error", "errors", "residual",   "median",
    "p05", "p25",   "p50",   "p75",    "p90",   "p95",    "p99",        "p999",
    "max", "mean",  "worst", "failed", "sigma", "bound",  "iterations", "jitter"};

}  // namespace

NumberMeaning meaning_of_key(const std::string& key) {
  if (std::find(kWholeKeys.begin(), kWholeKeys.end(), key) != kWholeKeys.end())
    return NumberMeaning::not_judged;
  const std::vector<std::string> words = words_of(key);
  if (has_any(words, kSpread) || key.find("standard_error") != std::string::npos)
    return NumberMeaning::not_judged;
  if (has_any(words, kMoreIsBetter)) return NumberMeaning::less_is_worse;
  if (has_any(words, kMoreIsWorse) || key.starts_with("bone_length_sd")) return NumberMeaning::more_is_worse;
  return NumberMeaning::unknown;
}

}  // namespace trilat
