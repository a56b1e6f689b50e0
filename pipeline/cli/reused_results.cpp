// SPDX-License-Identifier: MIT
#include "pipeline/cli/reused_results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/check_output.h"

namespace trilat {
namespace {

std::string some_of(const std::vector<std::string>& ids) {
  constexpr std::size_t kMostNamed = 8;
  const std::size_t named = std::min(ids.size(), kMostNamed);
  std::string text =
      fmt::format("{}", fmt::join(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(named), ", "));
  if (ids.size() > named) text += fmt::format(" and {} more", ids.size() - named);
  return text;
}

}  // namespace

void check_run_output(const RunArguments& arguments, StudyKind kind,
                      std::vector<std::filesystem::path> inputs) {
  if (arguments.output.empty()) throw InputError("--output", "is missing: where should the results go?");
  inputs.insert(inputs.end(), {arguments.study, arguments.calibration});
  for (const std::filesystem::path& folder : arguments.reuse)
    if (std::error_code error; !std::filesystem::equivalent(folder, arguments.output, error))
      inputs.push_back(folder);
  check_output({arguments.output, arguments.shard.empty() ? OutputKind::results : OutputKind::part, inputs,
                arguments.force, name_of(kind)});
}

std::vector<std::filesystem::path> reused_results(const RunArguments& arguments) {
  std::vector<std::filesystem::path> folders = arguments.reuse;
  if (!arguments.fresh && std::filesystem::is_directory(arguments.output))
    folders.push_back(arguments.output);
  return folders;
}

void print_part(const std::filesystem::path& output, const Shard& shard, const ItemTally& tally, bool json) {
  Json document{{"part", output.string()}, {"shard", name_of(shard)}};
  document.update(tally_json(tally));
  if (json)
    fmt::print("{}\n", json_text(document, 2));
  else
    fmt::print("part {}: {} items: {}\n", name_of(shard), document.at("items").get<std::size_t>(),
               output.string());
}

Json tally_json(const ItemTally& tally) {
  return {{"items", tally.all()},
          {"items_computed", tally.computed.size()},
          {"items_continued", tally.continued.size()},
          {"items_reused", tally.reused.size()},
          {"unchanged", tally.unchanged}};
}

void tell_reuse(const std::string& items, const ItemTally& tally) {
  if (tally.unchanged) {
    fmt::print(stderr, "nothing changed: the results are there already\n");
    return;
  }
  if (!tally.reused.empty())
    fmt::print(stderr, "{} {} did not change and are taken from earlier results: {}\n", tally.reused.size(),
               items, some_of(tally.reused));
  if (!tally.continued.empty())
    fmt::print(stderr, "{} {} were done before the run was stopped\n", tally.continued.size(), items);
  if (!tally.computed.empty() && tally.reused.size() + tally.continued.size() > 0)
    fmt::print(stderr, "{} {} were computed: {}\n", tally.computed.size(), items, some_of(tally.computed));
}

void tell_interrupted(const std::filesystem::path& folder) {
  fmt::print(
      stderr,
      "trilat: interrupted; what was finished has been kept in {}, and the same command goes on from there\n",
      folder.string());
}

}  // namespace trilat
