// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include <nlohmann/json.hpp>

#include "datasets/base/json.h"
#include "datasets/results/item_store.h"
#include "datasets/rig/skeleton.h"
#include "reports/figures/figure_look.h"
#include "reports/page/html.h"
#include "reports/report_content.h"

namespace trilat {
namespace {

constexpr double kMaxRate_hz = 15.0;
constexpr std::int64_t kShown_ns = 35'000'000'000;
constexpr std::uint64_t kMaxInstants = 35 * 1000;  // a study takes at most 1000 instants a second

std::int16_t millimetres(double metres) {
  constexpr std::int16_t kNone = -32768;
  constexpr double kMaxDistance_mm = 32'767.0;
  const double mm = std::round(metres * 1e3);
  return std::isfinite(mm) && std::abs(mm) <= kMaxDistance_mm ? static_cast<std::int16_t>(mm) : kNone;
}

// Packs every `step`th of the first `instants` instants.
class Packer {
 public:
  Packer(std::uint64_t instants, std::uint64_t step) : instants_(instants), step_(step) {}
  std::uint64_t count() const { return (instants_ + step_ - 1) / step_; }

  // A channel; `metres` says its number at an instant.
  void add(const auto& metres) {
    std::uint16_t before = 0;
    for (std::uint64_t i = 0; i < instants_; i += step_) {
      const auto now = static_cast<std::uint16_t>(millimetres(metres(i)));
      const auto difference = static_cast<std::uint16_t>(now - before);
      bytes_ += static_cast<char>(difference & 0xff);
      bytes_ += static_cast<char>(difference >> 8);
      before = now;
    }
  }
  std::string text() const { return base64_of(deflated(bytes_)); }

 private:
  std::uint64_t instants_, step_;
  std::string bytes_;
};

bool is_usable(const TakeHead& head, std::uint8_t status) {
  return status < head.status_names.size() && is_answer(head.status_names[status]);
}

// The methods that the replay shows, as indices into the samples' methods.
std::vector<std::size_t> shown_methods(const TakeHead& head, const ResultsSummary& summary) {
  std::set<std::string> wanted{"nonlinear", "mean", summary.reference};
  if (const BestMethod* best = find_best(summary, head.condition, average_group(summary)))
    wanted.insert(best->method);
  std::vector<std::size_t> shown;
  for (std::size_t m = 0; m < head.methods.size(); ++m)
    if (wanted.contains(head.methods[m])) shown.push_back(m);
  return shown;
}

Json skeleton_json() {
  Json names = Json::array(), parents = Json::array();
  for (int j = 0; j < kJointCount; ++j) {
    const auto joint = static_cast<Joint>(j);
    names.push_back(std::string(name_of(joint)));
    const auto parent = parent_of(joint);
    parents.push_back(parent ? static_cast<int>(*parent) : -1);
  }
  return {{"names", names}, {"parents", parents}};
}

PackedReplay pack(const StoredTake& take, const ResultsSummary& summary) {
  const TakeHead& head = take.head();
  const SampleBlock block = take.read(0, 0, std::min(head.instants, kMaxInstants), SampleColumns::errors);
  const auto since_start_ns = [&](std::int64_t time_ns) { return time_ns - block.time_ns.front(); };
  const auto end = std::ranges::upper_bound(block.time_ns, kShown_ns, {}, since_start_ns);
  const auto instants = static_cast<std::uint64_t>(end - block.time_ns.begin());
  const double span_s = static_cast<double>(since_start_ns(block.time_ns[instants - 1])) * 1e-9;
  const double rate_hz = span_s > 0.0 ? static_cast<double>(instants - 1) / span_s : 0.0;
  Packer packer(instants, std::max<std::uint64_t>(
                              1, static_cast<std::uint64_t>(std::ceil(rate_hz / kMaxRate_hz - 0.01))));
  const std::size_t joints = head.joints.size(), methods = head.methods.size();
  for (std::size_t c = 0; c < joints * 3; ++c)
    packer.add([&](std::uint64_t i) { return block.truth_m[i * joints * 3 + c]; });
  Json names = Json::array(), colours = Json::array();
  for (const std::size_t m : shown_methods(head, summary)) {
    names.push_back(head.methods[m]);
    colours.push_back(look_of_method(head.methods[m]).colour);
    for (std::size_t c = 0; c < joints * 3; ++c)
      packer.add([&](std::uint64_t i) {
        const std::size_t at = (i * joints + c / 3) * methods + m;
        return is_usable(head, block.status[at]) ? static_cast<double>(block.estimate_m[at * 3 + c % 3])
                                                 : kNaN;
      });
  }
  const std::string title = summary.study + ": " + head.condition + ", take " + head.id;
  const Json json{{"title", title},
                  {"simulated", summary.simulated},
                  {"instants", packer.count()},
                  {"span_s", span_s},
                  {"skeleton", skeleton_json()},
                  {"joints", head.joints},
                  {"methods", names},
                  {"colours", colours},
                  {"points", packer.text()}};
  return {title, json_text(json, -1)};
}

}  // namespace

std::vector<PackedReplay> packed_replays(const std::filesystem::path& results,
                                         const ResultsSummary& summary) {
  std::vector<PackedReplay> packed;
  std::set<std::string> conditions;
  for (const ResultTake& take : result_takes(results)) {
    if (take.folder.empty()) continue;
    const StoredTake file = open_take(take);
    if (file.head().instants > 0 && conditions.insert(file.head().condition).second)
      packed.push_back(pack(file, summary));
  }
  return packed;
}

}  // namespace trilat
