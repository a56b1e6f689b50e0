// SPDX-License-Identifier: MIT
// Mean errors and answers, take by take or between participants.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/results/item_store.h"
#include "datasets/results/stored_take.h"
#include "evaluators/metrics/statistics.h"
#include "pipeline/errors/error_changes.h"
#include "pipeline/gate/compare_results.h"

namespace trilat {
namespace {

constexpr std::uint64_t kMinLost = 15;  // samples of a take: the loss of fewer says nothing

// Whether a length grew or fell by more than the limits.
bool is_change(double now_m, double before_m, const GateLimits& limits) {
  const double off_m = std::abs(now_m - before_m);
  return off_m > limits.smallest_m && 100.0 * off_m > limits.smallest_percent * std::abs(before_m);
}

// The answers (samples) and summed error lengths (m) of one cell, or of one take in it, in both results.
// Lengths are of the samples that both answer, where these are known.
struct BothSums {
  std::uint64_t answered_before = 0, answered_now = 0;
  std::uint64_t compared_before = 0, compared_now = 0;
  double length_before_m = 0.0, length_now_m = 0.0;

  void add(const TakeJointRow& before, const TakeJointRow& now, const CommonErrors* common) {
    answered_before += before.answered;
    answered_now += now.answered;
    compared_before += common ? common->samples : before.answered;
    compared_now += common ? common->samples : now.answered;
    if (common) {
      length_before_m += common->before_m;
      length_now_m += common->now_m;
      return;
    }
    if (before.answered > 0) length_before_m += static_cast<double>(before.answered) * before.mae_m;
    if (now.answered > 0) length_now_m += static_cast<double>(now.answered) * now.mae_m;
  }
  double before_m() const {
    return compared_before == 0 ? kNaN : length_before_m / static_cast<double>(compared_before);
  }
  double now_m() const { return compared_now == 0 ? kNaN : length_now_m / static_cast<double>(compared_now); }
};

// The rows of both results that are of the same take, condition, joint and method.
class SameTakes {
 public:
  SameTakes(const ErrorsByJoint& before, const ErrorsByJoint& now, const std::vector<std::string>& same,
            const CommonErrorsOfRows& common) {
    std::map<std::tuple<std::string, std::string, std::string, std::string>, const TakeJointRow*> known;
    for (const TakeJointRow& row : before.rows)
      known[{row.take, row.condition, row.joint, row.method}] = &row;
    const std::set<std::string> wanted(same.begin(), same.end());
    for (const TakeJointRow& row : now.rows) {
      const auto found = known.find({row.take, row.condition, row.joint, row.method});
      if (found == known.end() || !wanted.contains(row.take)) continue;
      const CellKey key{row.condition, row.method, row.group};
      if (!cells_.contains(key)) order_.push_back(key);
      const auto both = common.find({row.take, row.joint, row.method});
      const bool is_other = found->second->answered != row.answered;
      const CommonErrors* const errors = is_other && both != common.end() ? &both->second : nullptr;
      cells_[key].add(*found->second, row, errors);
      takes_[key][row.take].add(*found->second, row, errors);
    }
  }
  struct CellKey {
    std::string condition, method, group;
    auto operator<=>(const CellKey&) const = default;
  };
  const std::vector<CellKey>& order() const { return order_; }
  const BothSums& cell(const CellKey& key) const { return cells_.at(key); }
  const std::map<std::string, BothSums>& takes(const CellKey& key) const { return takes_.at(key); }

 private:
  std::vector<CellKey> order_;
  std::map<CellKey, BothSums> cells_;
  std::map<CellKey, std::map<std::string, BothSums>> takes_;
};

// The change of a mean error, whose direction and alarm are the caller's.
GateFinding accuracy_finding(const CellName& cell, double before_m, double now_m) {
  GateFinding finding = finding_of(cell, FindingKind::accuracy, Direction::changed, false);
  finding.what = "mean absolute error";
  finding.unit = "m";
  finding.before = before_m;
  finding.now = now_m;
  finding.percent = percent_of(now_m, before_m);
  return finding;
}

void add_accuracy(const CellName& cell, double before_m, double now_m, const GateLimits& limits,
                  GateReport& report) {
  ++report.looked_at;
  if (is_same(before_m, now_m)) return;
  const bool is_lost = std::isnan(before_m) || std::isnan(now_m);  // which its answers say
  if (!is_lost && !is_change(now_m, before_m, limits)) {
    ++report.within_limits;
    return;
  }
  GateFinding& finding = report.findings.emplace_back(accuracy_finding(cell, before_m, now_m));
  if (is_lost) return;
  finding.direction = now_m > before_m ? Direction::worse : Direction::better;
  finding.alarm = finding.direction == Direction::worse;
}

// The take that lost the largest share of its answers; nothing when none lost enough.
const std::pair<const std::string, BothSums>* worst_take(const std::map<std::string, BothSums>& takes,
                                                         const GateLimits& limits) {
  const auto share = [](const BothSums& sums) {
    return sums.answered_before == 0
               ? 0.0
               : 1.0 - static_cast<double>(sums.answered_now) / static_cast<double>(sums.answered_before);
  };
  const auto worst = std::ranges::max_element(
      takes, [&](const auto& a, const auto& b) { return share(a.second) < share(b.second); });
  if (worst == takes.end()) return nullptr;
  const BothSums& sums = worst->second;
  const bool enough = sums.answered_before >= sums.answered_now + kMinLost;
  return enough && 100.0 * share(sums) >= limits.take_loss_percent ? &*worst : nullptr;
}

void add_coverage(const CellName& name, const BothSums& cell, const std::map<std::string, BothSums>& takes,
                  const GateLimits& limits, GateReport& report) {
  const auto* worst = worst_take(takes, limits);
  if (cell.answered_before == cell.answered_now && !worst) return;
  const double percent =
      percent_of(static_cast<double>(cell.answered_now), static_cast<double>(cell.answered_before));
  const bool fell = worst || percent < -limits.smallest_loss_percent;
  const bool rose = !fell && (std::isnan(percent) || percent > limits.smallest_loss_percent);
  if (!fell && !rose) {
    ++report.within_limits;
    return;
  }
  GateFinding finding =
      finding_of(name, FindingKind::coverage, fell ? Direction::worse : Direction::better, fell);
  finding.what = "samples answered";
  finding.before = static_cast<double>(cell.answered_before);
  finding.now = static_cast<double>(cell.answered_now);
  finding.percent = percent;
  if (worst)
    finding.note = fmt::format("take {}: {} of {} left", worst->first, worst->second.answered_now,
                               worst->second.answered_before);
  report.findings.push_back(std::move(finding));
}

// "average without wrist".
std::string group_text(const std::string& group, const std::vector<std::string>& without) {
  return without.empty() ? group : fmt::format("{} without {}", group, fmt::join(without, ", "));
}

}  // namespace

void compare_takes(const std::string& study, const ErrorsByJoint& before, const ErrorsByJoint& now,
                   const std::vector<std::string>& same, const GateLimits& limits, GateReport& report,
                   const CommonErrorsOfRows& common) {
  const SameTakes both(before, now, same, common);
  struct Average {
    double before_m = 0.0, now_m = 0.0, groups = 0.0;
    std::vector<std::string> without;  // groups that one of both nights does not answer
  };
  std::map<std::pair<std::string, std::string>, Average> averages;  // by condition and method
  for (const SameTakes::CellKey& key : both.order()) {
    const BothSums& sums = both.cell(key);
    const CellName cell{study, key.method, key.condition, key.group};
    add_accuracy(cell, sums.before_m(), sums.now_m(), limits, report);
    add_coverage(cell, sums, both.takes(key), limits, report);
    Average& average = averages[{key.condition, key.method}];
    if (!std::isfinite(sums.before_m() + sums.now_m())) {
      average.without.push_back(key.group);
      continue;
    }
    average.before_m += sums.before_m();
    average.now_m += sums.now_m();
    average.groups += 1.0;
  }
  for (const auto& [key, average] : averages)
    if (average.groups > 1.0)
      add_accuracy({study, key.second, key.first, group_text(kAverageGroup, average.without)},
                   average.before_m / average.groups, average.now_m / average.groups, limits, report);
}

double compare_unpaired(const std::string& study, const ErrorsByJoint& before, const ErrorsByJoint& now,
                        const GateLimits& limits, GateReport& report) {
  constexpr double kPower = 0.95;
  const std::optional<ErrorChanges> changes = changes_between(before, now);
  if (!changes) return kNaN;
  std::vector<double> found_percent;
  const double level = limits.false_alarm_rate / static_cast<double>(changes->rows.size());
  for (const ErrorChange& row : changes->rows) {
    ++report.looked_at;
    if (is_same(row.before_m, row.after_m) || !std::isfinite(row.difference_m)) continue;
    if (row.degrees == 0) continue;
    const std::size_t degrees = row.degrees;
    const double reach = student_quantile(degrees, level) + student_quantile(degrees, 2.0 * (1.0 - kPower));
    if (row.group == kAverageGroup)
      found_percent.push_back(100.0 * reach * row.standard_error_m / row.before_m);
    GateFinding finding = accuracy_finding(
        {study, row.method, row.condition, group_text(row.group, row.without)}, row.before_m, row.after_m);
    finding.direction = row.difference_m > 0.0 ? Direction::worse : Direction::better;
    finding.low = 100.0 * row.low_m / row.before_m;
    finding.high = 100.0 * row.high_m / row.before_m;
    finding.p_value = row.p_value;
    finding.clusters = row.clusters;
    report.findings.push_back(std::move(finding));
  }
  if (found_percent.empty()) return kNaN;
  std::ranges::sort(found_percent);
  return found_percent[found_percent.size() / 2];
}

void adjust_p_values(const GateLimits& limits, GateReport& report) {
  std::vector<double> p_values;
  for (const GateFinding& f : report.findings) p_values.push_back(f.p_value);
  const std::vector<double> adjusted = holm_adjusted(p_values);
  for (std::size_t k = 0; k < p_values.size(); ++k) {
    GateFinding& f = report.findings[k];
    if (std::isnan(f.p_value)) continue;
    f.p_value = adjusted[k];
    f.alarm = f.direction == Direction::worse && adjusted[k] <= limits.false_alarm_rate &&
              is_change(f.now, f.before, limits);
  }
  std::erase_if(report.findings, [&](const GateFinding& f) {
    return !std::isnan(f.p_value) &&
           !(f.p_value <= limits.false_alarm_rate && is_change(f.now, f.before, limits));
  });
}

namespace {

constexpr std::uint64_t kInstantsAtOnce = 4096;

// Samples of one take, whose errors are asked for by the names of joint and method.
class TakeErrorsReader {
 public:
  explicit TakeErrorsReader(StoredTake take) : take_(std::move(take)) {
    for (const AlignmentRow& row : take_.read_errors().laid_over)
      if (row.alignment == 0) laid_over_[{row.quantity, row.method}] = row;
    for (const std::string& name : take_.head().status_names) is_answer_.push_back(is_answer(name));
  }
  const TakeHead& head() const { return take_.head(); }
  void read(std::uint64_t first, std::uint64_t count) {
    take_.read(0, first, count, SampleColumns::errors, block_);
  }
  // The error at an instant of the block that was read; nothing where the method has no answer or the joint
  // no truth.
  std::optional<double> error_m(std::uint64_t in_block, std::size_t joint, std::size_t method) const {
    const std::size_t joints = head().joints.size(), methods = head().methods.size();
    const std::size_t at_joint = in_block * joints + joint, at = at_joint * methods + method;
    const auto laid_over =
        laid_over_.find({static_cast<std::uint32_t>(joint), static_cast<std::uint32_t>(method)});
    if (!is_answer_[block_.status[at]] || laid_over == laid_over_.end() ||
        block_.first_instant + in_block < laid_over->second.first_instant)
      return std::nullopt;
    const Eigen::Vector3d estimate_m =
        Eigen::Map<const Eigen::Vector3f>(&block_.estimate_m[3 * at]).cast<double>();
    const Eigen::Map<const Eigen::Vector3d> truth_m(&block_.truth_m[3 * at_joint]);
    const double error_m =
        (laid_over->second.aligned_m(estimate_m, block_.heading_rad[in_block]) - truth_m).norm();
    return std::isfinite(error_m) ? std::optional(error_m) : std::nullopt;
  }

 private:
  StoredTake take_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, AlignmentRow> laid_over_;
  std::vector<bool> is_answer_;
  SampleBlock block_;
};

// Places of the names that both have.
std::vector<std::pair<std::size_t, std::size_t>> common_places(const std::vector<std::string>& before,
                                                               const std::vector<std::string>& now) {
  std::vector<std::pair<std::size_t, std::size_t>> places;
  for (std::size_t k = 0; k < before.size(); ++k)
    if (const auto found = std::ranges::find(now, before[k]); found != now.end())
      places.emplace_back(k, static_cast<std::size_t>(found - now.begin()));
  return places;
}

void add_take(TakeErrorsReader before, TakeErrorsReader now, CommonErrorsOfRows& rows) {
  const TakeHead &head = before.head(), &head_now = now.head();
  if (head.tracks.size() != 1 || head_now.tracks.size() != 1 || head.instants != head_now.instants) return;
  const auto joints = common_places(head.joints, head_now.joints),
             methods = common_places(head.methods, head_now.methods);
  for (const auto& [joint, joint_now] : joints)  // also those without a common sample
    for (const auto& [method, method_now] : methods)
      rows[{head.id, head.joints[joint], head.methods[method]}];
  for (std::uint64_t first = 0; first < head.instants; first += kInstantsAtOnce) {
    const std::uint64_t count = std::min(kInstantsAtOnce, head.instants - first);
    before.read(first, count);
    now.read(first, count);
    for (std::uint64_t i = 0; i < count; ++i)
      for (const auto& [joint, joint_now] : joints)
        for (const auto& [method, method_now] : methods) {
          const auto before_m = before.error_m(i, joint, method),
                     now_m = now.error_m(i, joint_now, method_now);
          if (!before_m || !now_m) continue;
          CommonErrors& row = rows[{head.id, head.joints[joint], head.methods[method]}];
          ++row.samples;
          row.before_m += *before_m;
          row.now_m += *now_m;
        }
  }
}

// The takes of results that keep their samples.
std::map<std::string, std::filesystem::path> kept_takes(const std::filesystem::path& results) {
  constexpr std::string_view kOfTakes = "takes/";
  std::map<std::string, std::filesystem::path> folders;
  for (const auto& [id, key] : read_manifest(results).items) {
    if (!id.starts_with(kOfTakes) || !key) continue;
    const std::filesystem::path folder = ItemStore(results).folder(*key);
    if (std::filesystem::exists(folder / StoredTake::kName)) folders[id.substr(kOfTakes.size())] = folder;
  }
  return folders;
}

}  // namespace

CommonErrorsOfRows common_errors(const std::filesystem::path& before, const std::filesystem::path& now,
                                 const std::set<std::string>& takes) {
  CommonErrorsOfRows rows;
  const auto kept_before = kept_takes(before), kept_now = kept_takes(now);
  for (const std::string& take : takes) {
    const auto one = kept_before.find(take), other = kept_now.find(take);
    if (one == kept_before.end() || other == kept_now.end()) continue;
    add_take(TakeErrorsReader(StoredTake::open(one->second / StoredTake::kName)),
             TakeErrorsReader(StoredTake::open(other->second / StoredTake::kName)), rows);
  }
  return rows;
}

}  // namespace trilat
