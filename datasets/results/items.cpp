// SPDX-License-Identifier: MIT
#include "datasets/results/items.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostItemsBytes = std::size_t{1} << 30;

// There may be very many items. What a power failure tears does not parse or has another size.
void write_unsynced(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) throw OutputError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
}

ItemsHead read_items_head(JsonObject& object) {
  check_format(object, "trilat.items", 2);
  ItemsHead head{object.text("key"), {}};
  JsonObject files = object.object("files");
  for (const std::string& name : files.keys()) {
    head.bytes[name];
    if (!files.value(name).is_null()) head.bytes[name] = files.count(name);
  }
  return head;
}

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

fs::path item_folder(const fs::path& output, const std::string& id) { return output / kItemsFolder / id; }

void put_item(const fs::path& made, const fs::path& output, const DoneItem& item) {
  StoredItem stored{item, {}};
  for (const fs::directory_entry& entry : fs::directory_iterator(made))
    stored.bytes[entry.path().filename().string()] = entry.file_size();
  Json json{{"format", "trilat.item"}, {"version", 1}};
  json.update(json_of(stored));
  write_unsynced(made / kItemFile, json_text(json, -1) + '\n');
  const fs::path folder = item_folder(output, item.id);
  make_folder(folder.parent_path());
  std::error_code error;
  fs::remove_all(folder, error);
  if (!error) fs::rename(made, folder, error);
  if (error) throw OutputError(folder.string(), "cannot be put in place: " + error.message());
}

std::optional<StoredItem> stored_item(const fs::path& folder) {
  const fs::path path = folder / kItemFile;
  if (!fs::exists(path)) return std::nullopt;
  const Json json = parse_json(read_file(path, kMostItemsBytes), path.string());
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.item", 1);
  std::optional<StoredItem> item(std::in_place);
  read_fields(object, *item);
  return item;
}

void StoredItem::check(const JsonObject& object) const {
  for (const auto& [name, size] : bytes)
    if (!is_plain_name(name)) object.refuse_below("files/" + name, "is no name of a file");
}

fs::path damaged_file(const StoredItem& item, const fs::path& folder) {
  for (const auto& [name, bytes] : item.bytes) {
    std::error_code error;
    if (fs::file_size(folder / name, error) != bytes || error) return folder / name;
  }
  return {};
}

void write_items(const fs::path& results, const std::string& key, std::size_t count,
                 const std::function<DoneItem(std::size_t)>& item) {
  std::map<std::string, Json> files{{"run.json", nullptr}};
  for (const fs::directory_entry& entry : fs::directory_iterator(results))
    if (const std::string name = entry.path().filename().string(); entry.is_regular_file())
      files[name] = name == "timings.json" ? Json(nullptr) : Json(entry.file_size());
  std::string text =
      json_text({{"format", "trilat.items"}, {"version", 2}, {"key", key}, {"files", files}}, -1);
  text.back() = ',';  // an item a line
  text += "\"items\":[";
  for (std::size_t i = 0; i < count; ++i) text += (i > 0 ? ",\n" : "\n") + json_text(json_of(item(i)), -1);
  write_file(results / "items.json", text + "\n]}\n");
}

ItemsHead read_items_head(const fs::path& results) {
  const fs::path path = results / "items.json";
  std::ifstream file(path);
  if (!file) return {};
  std::string head, end(2, '\0');
  std::getline(file, head);
  file.seekg(-3, std::ios::end).read(end.data(), 2);
  if (end != "]}") throw InputError(path.string(), "is not whole");
  const Json json = parse_json(head + "]}", path.string());
  JsonObject object(json, path.string(), "");
  return read_items_head(object);
}

bool has_all_files(const fs::path& results, const ItemsHead& head) {
  return std::ranges::all_of(head.bytes, [&](const auto& file) { return fs::exists(results / file.first); });
}

bool is_damaged(const fs::path& results, const ItemsHead& head) {
  return std::ranges::any_of(head.bytes, [&](const auto& file) {
    std::error_code missing;
    const std::uintmax_t bytes = fs::file_size(results / file.first, missing);
    return !missing && file.second.value_or(bytes) != bytes;
  });
}

std::vector<DoneItem> read_items(const fs::path& results) {
  const fs::path path = results / "items.json";
  std::vector<DoneItem> items;
  if (!fs::exists(path)) return items;
  const Json json = parse_json(read_file(path, kMostItemsBytes), path.string());
  JsonObject object(json, path.string(), "");
  read_items_head(object);
  items = read_list<DoneItem>(object, "items");
  object.finish();
  return items;
}

void write_part(const std::filesystem::path& folder, const WorkPart& part) {
  Json json{{"format", "trilat.part"}, {"version", 1}};
  json.update(json_of(part));
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
  read_fields(object, part);
  return part;
}

void WorkPart::check(const JsonObject& object) const {
  if (of == 0 || of > kMostShards) object.refuse("shards", fmt::format("must be 1 to {}", kMostShards));
  if (number == 0 || number > of) object.refuse("shard", "must be 1 to the number of shards");
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!(items[i].cost >= 0.0)) object.refuse_below(fmt::format("items/{}/cost", i), "must be a number");
    if (items[i].shard == 0 || items[i].shard > of)
      object.refuse_below(fmt::format("items/{}/shard", i), "must be 1 to the number of shards");
    if (!is_item_id(items[i].id))
      object.refuse_below(
          fmt::format("items/{}/id", i),
          "is no name of an item: letters, digits, '-', '_' or '.', parts of it divided by '/'");
  }
}

std::vector<FoundPart> read_parts(std::span<const std::filesystem::path> folders) {
  std::vector<FoundPart> parts;
  for (const std::filesystem::path& folder : folders) {
    parts.push_back({folder, read_part(folder)});
    check_belongs(parts.front(), parts.back());
  }
  if (parts.empty()) throw InputError("merge", "needs the folders of the parts");
  std::ranges::stable_sort(
      parts, [](const FoundPart& a, const FoundPart& b) { return a.part.number < b.part.number; });
  for (std::size_t i = 1; i < parts.size(); ++i)
    if (parts[i].part.number == parts[i - 1].part.number)
      throw InputError(
          parts[i].folder.string(),
          fmt::format("is shard {}, which {} is too", name_of(parts[i].part), parts[i - 1].folder.string()));
  check_complete(parts);
  return parts;
}

}  // namespace trilat
