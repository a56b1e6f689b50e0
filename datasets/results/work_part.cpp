// SPDX-License-Identifier: MIT
#include "datasets/results/work_part.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/plain_name.h"
#include "datasets/base/version.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr std::size_t kMostPartBytes = std::size_t{1} << 28;
constexpr std::size_t kMostNamed = 10;

// None that would lead out of the part.
bool is_item_id(std::string_view id) {
  for (std::size_t end; (end = id.find('/')) != std::string_view::npos; id.remove_prefix(end + 1))
    if (!is_plain_name(id.substr(0, end))) return false;
  return is_plain_name(id);
}

std::string name_of(const WorkPart& part) { return fmt::format("{}/{}", part.number, part.of); }

// The first place where two documents differ, as a JSON pointer and both values.
std::string difference(const Json& first, const Json& second) {
  const Json patch = Json::diff(first, second);
  if (patch.empty()) return {};
  const std::string pointer = patch[0].at("path").get<std::string>();
  const auto shown = [&](const Json& json) {
    const Json::json_pointer at(pointer);
    return json.contains(at) ? json_text(json.at(at), -1).substr(0, 100) : std::string("nothing");
  };
  return fmt::format("{} is {} in the first and {} here", pointer, shown(first), shown(second));
}

void check_belongs(const FoundPart& first, const FoundPart& other) {
  const std::string place = other.folder.string();
  const auto refuse = [&](const std::string& what) {
    throw InputError(place, "does not belong to " + first.folder.string() + ": " + what);
  };
  const WorkPart &a = first.part, &b = other.part;
  if (a.kind != b.kind) refuse(fmt::format("it is a part of kind {}, the first is of {}", b.kind, a.kind));
  if (a.of != b.of) refuse(fmt::format("it is shard {}, the first is {}", name_of(b), name_of(a)));
  if (const std::string what = difference(a.work, b.work); !what.empty()) refuse(what);
  if (a.build != b.build)
    refuse("another build of the program made it; make all parts of a work with one build");
  const auto same = [](const PartItem& x, const PartItem& y) { return x.id == y.id && x.shard == y.shard; };
  if (!std::equal(a.items.begin(), a.items.end(), b.items.begin(), b.items.end(), same))
    refuse("its list of items is another");
}

std::string items_of(const WorkPart& part, std::uint64_t number) {
  std::string text;
  std::size_t count = 0;
  for (const PartItem& item : part.items) {
    if (item.shard != number) continue;
    if (++count <= kMostNamed) text += (count > 1 ? ", " : "") + item.id;
  }
  if (count > kMostNamed) text += fmt::format(" and {} more", count - kMostNamed);
  return count == 0 ? "" : " (" + text + ")";
}

void check_complete(const std::vector<FoundPart>& parts) {
  const WorkPart& any = parts.front().part;
  std::string missing;
  std::size_t count = 0, next = 0;
  for (std::uint64_t number = 1; number <= any.of; ++number) {
    if (next < parts.size() && parts[next].part.number == number) {
      ++next;
    } else if (++count <= kMostNamed) {
      missing += fmt::format("{}shard {}/{}{}", count > 1 ? ", " : "", number, any.of, items_of(any, number));
    }
  }
  if (count > kMostNamed) missing += fmt::format(" and {} shards more", count - kMostNamed);
  if (count > 0)
    throw InputError(parts.front().folder.string(), "is not all of its work; missing: " + missing);
}

}  // namespace

void write_part(const std::filesystem::path& folder, const WorkPart& part) {
  Json items = Json::array();
  for (const PartItem& item : part.items)
    items.push_back({{"id", item.id}, {"cost", item.cost}, {"shard", item.shard}});
  const Json json{{"format", "trilat.part"}, {"version", 1},        {"program", kProgramVersion},
                  {"kind", part.kind},       {"build", part.build}, {"shard", part.number},
                  {"shards", part.of},       {"work", part.work},   {"items", items}};
  write_file(folder / "part.json", json_text(json, 1) + "\n");
}

WorkPart read_part(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "part.json";
  if (!std::filesystem::exists(path))
    throw InputError(folder.string(), std::filesystem::exists(partial_name(folder))
                                          ? "is not finished yet; run its shard again, it goes on from there"
                                          : "holds no part.json; name folders that --shard has written");
  const Json json = parse_json(read_file(path, kMostPartBytes), path.string());
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.part", 1);
  WorkPart part;
  object.text("program");
  part.kind = object.text("kind");
  part.build = object.text("build");
  part.number = object.count("shard");
  part.of = object.count("shards");
  if (part.of == 0 || part.of > kMostShards)
    object.refuse("shards", fmt::format("must be 1 to {}", kMostShards));
  if (part.number == 0 || part.number > part.of) object.refuse("shard", "must be 1 to the number of shards");
  part.work = object.value("work");
  for (JsonObject& entry : object.objects("items")) {
    part.items.push_back({entry.text("id"), entry.number("cost"), entry.count("shard")});
    entry.finish();
    const PartItem& item = part.items.back();
    if (item.shard == 0 || item.shard > part.of) entry.refuse("shard", "must be 1 to the number of shards");
    if (!is_item_id(item.id))
      entry.refuse("id",
                   "is no name of an item: letters, digits, '-', '_' or '.', parts of it divided by '/'");
  }
  object.finish();
  return part;
}

std::vector<FoundPart> read_parts(std::span<const std::filesystem::path> folders) {
  std::vector<FoundPart> parts;
  for (const std::filesystem::path& folder : folders) {
    parts.push_back({folder, read_part(folder)});
    check_belongs(parts.front(), parts.back());
  }
  if (parts.empty()) throw InputError("merge", "needs the folders of the parts");
  std::stable_sort(parts.begin(), parts.end(),
                   [](const FoundPart& a, const FoundPart& b) { return a.part.number < b.part.number; });
  for (std::size_t i = 1; i < parts.size(); ++i)
    if (parts[i].part.number == parts[i - 1].part.number)
      throw InputError(
          parts[i].folder.string(),
          fmt::format("is shard {}, which {} is too", name_of(parts[i].part), parts[i - 1].folder.string()));
  check_complete(parts);
  return parts;
}

}  // namespace trilat
