// SPDX-License-Identifier: MIT
#include "datasets/results/numbers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/text_output.h"

namespace trilat {
namespace {

constexpr std::array kKeyParts{&NumberKey::condition, &NumberKey::group,     &NumberKey::method,
                               &NumberKey::against,   &NumberKey::alignment, &NumberKey::measure,
                               &NumberKey::statistic, &NumberKey::take};
constexpr const char* kHeader =
    "condition,group,method,against,alignment,measure,statistic,take,unit,value,low,high,n,clusters,p";
constexpr std::array kNumberColumns{"condition", "group",     "method", "against",  "alignment",
                                    "measure",   "statistic", "take",   "unit",     "value",
                                    "low",       "high",      "n",      "clusters", "p"};
constexpr std::size_t kUnit = kKeyParts.size(), kValue = kUnit + 1, kN = kValue + 3;

struct Measure {
  const char *name, *unit;
  Better better = Better::smaller;
};
constexpr Measure kMeasure{"", "m"};  // of every other name
constexpr std::array<Measure, 15> kMeasures{{{"answered", "1", Better::larger},
                                             {"within", "1", Better::larger},
                                             {"status", "1", Better::neither},
                                             {"interpretations", "1", Better::neither},
                                             {"queue", "1"},
                                             {"iterations", "steps", Better::neither},
                                             {"jerk", "m/s3"},
                                             {"angle", "rad"},
                                             {"rotation", "rad"},
                                             {"tilt", "rad", Better::neither},
                                             {"wall", "m", Better::neither},
                                             {"clock_error", "s"},
                                             {"clock_fit", "s"},
                                             {"latency", "s"},
                                             {"start", "m"}}};
// Statistics that are better otherwise than their measure.
constexpr std::array<std::pair<const char*, Better>, 14> kStatistics{
    {{"share_below_2ms", Better::larger},
     {"share_compared", Better::larger},
     {"share_below_4ms", Better::larger},
     {"share_of_units_below_4ms", Better::larger},
     {"share_within_bound", Better::larger},
     {"share_in_time", Better::larger},
     {"taken", Better::larger},
     {"noise", Better::smaller},
     {"came", Better::neither},
     {"share_used", Better::neither},
     {"bias", Better::neither},
     {"lower_limit", Better::neither},
     {"upper_limit", Better::neither},
     {"mean_of_truth", Better::neither}}};

const Measure& measure_of(const NumberKey& key) {
  const auto found = std::ranges::find_if(kMeasures, [&](const Measure& m) { return key.measure == m.name; });
  return found == kMeasures.end() ? kMeasure : *found;
}

// One row of the file, whose cells are read with their place.
class Row {
 public:
  Row(const std::string& place, const std::string& text) : place_(place), cells_(csv_fields(text)) {
    if (cells_.size() != kNumberColumns.size())
      throw InputError(place_, fmt::format("has {} of {} cells: {}", cells_.size(), kNumberColumns.size(),
                                           "the file is cut or was edited; make the results again"));
  }

  Number number() const {
    Number number;
    for (std::size_t part = 0; part < kKeyParts.size(); ++part) number.*kKeyParts[part] = cells_[part];
    if (cells_[kUnit] != unit_of(number))
      refuse(kUnit,
             fmt::format("must be {}, the unit of {} {}", unit_of(number), number.measure, number.statistic));
    number.value = real(kValue);
    if (std::isnan(number.value)) refuse(kValue, "must be a number");
    number.low = real(kValue + 1);
    number.high = real(kValue + 2);
    number.n = count(kN);
    number.clusters = count(kN + 1);
    number.p = real(kN + 2);
    return number;
  }

 private:
  [[noreturn]] void refuse(std::size_t column, const std::string& right) const {
    throw InputError(place_,
                     fmt::format("{} is \"{}\"; it {}", kNumberColumns[column], cells_[column], right));
  }
  template <class T>
  T parsed(std::size_t column, const char* what) const {
    const std::string& cell = cells_[column];
    T value{};
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || end != cell.data() + cell.size()) refuse(column, what);
    return value;
  }
  double real(std::size_t column) const {
    if (cells_[column].empty()) return kNaN;
    const auto value = parsed<double>(column, "must be a number or empty");
    if (!std::isfinite(value)) refuse(column, "must be a number or empty");
    return value;
  }
  std::uint64_t count(std::size_t column) const { return parsed<std::uint64_t>(column, "must be a count"); }

  std::string place_;
  std::vector<std::string> cells_;
};

std::string cell_of(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); }

}  // namespace

NumberKey NumberKey::with(const NumberKey& more) const {
  NumberKey key = *this;
  for (const auto part : kKeyParts)
    if (!(more.*part).empty()) key.*part = more.*part;
  return key;
}

std::size_t Numbers::Hash::operator()(const NumberKey& key) const {
  std::size_t hash = 0;
  for (const auto part : kKeyParts) hash = hash * 1000003 + std::hash<std::string>{}(key.*part);
  return hash;
}

void Numbers::add(Number number) {
  if (!std::isfinite(number.value)) return;
  const bool is_new = places_.try_emplace(number, numbers_.size()).second;
  TRILAT_CHECK(is_new, "every number has a key of its own");
  numbers_.push_back(std::move(number));
}

void Numbers::add(const Numbers& more) {
  for (const Number& number : more.all()) add(number);
}

const Number* Numbers::find(const NumberKey& key) const {
  const auto found = places_.find(key);
  return found == places_.end() ? nullptr : &numbers_[found->second];
}

double Numbers::value(const NumberKey& key) const {
  const Number* number = find(key);
  return number ? number->value : kNaN;
}

std::uint64_t Numbers::n(const NumberKey& key) const {
  const Number* number = find(key);
  return number ? number->n : 0;
}

std::string unit_of(const NumberKey& key) {
  if (key.statistic == "relative_difference" || key.statistic.starts_with("share")) return "1";
  return measure_of(key).unit;
}

Better better_of(const NumberKey& key) {
  for (const auto& [statistic, better] : kStatistics)
    if (key.statistic == statistic) return better;
  return measure_of(key).better;
}

void write_numbers(const std::filesystem::path& folder, const Numbers& numbers) {
  TextOutput file(folder / kNumbersFile);
  file.add("{}\n", kHeader);
  for (const Number& number : numbers.all()) {
    for (const auto part : kKeyParts) file.add("{},", csv_field(number.*part));
    file.add("{},{},{},{},{},{},{}\n", unit_of(number), cell_of(number.value), cell_of(number.low),
             cell_of(number.high), number.n, number.clusters, cell_of(number.p));
  }
  file.publish();
}

Numbers read_numbers(const std::filesystem::path& folder, std::size_t expected) {
  const std::string file = (folder / kNumbersFile).string();
  Numbers numbers;
  bool is_first = true;
  for_each_csv_record(file, read_file(file, kMaxNumbersBytes),
                      [&](const std::string& place, const std::string& record) {
                        if (std::exchange(is_first, false)) {
                          if (record == kHeader) return;
                          throw InputError(place, fmt::format("must be the line \"{}\"", kHeader));
                        }
                        Number number = Row(place, record).number();
                        if (numbers.find(number))
                          throw InputError(place, "repeats a number that stands above");
                        numbers.add(std::move(number));
                      });
  if (numbers.all().size() != expected)
    throw InputError(file, fmt::format("has {} numbers, and {} were written; make the results again",
                                       numbers.all().size(), expected));
  return numbers;
}

}  // namespace trilat
