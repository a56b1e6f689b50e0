// SPDX-License-Identifier: MIT
#include "pipeline/gate/common_samples.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/results/item_store.h"
#include "datasets/results/stored_take.h"

namespace trilat {
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
