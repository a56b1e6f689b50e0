// SPDX-License-Identifier: MIT
#include "datasets/results/items.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/plain_name.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostItemsBytes = std::size_t{1} << 30;

Json json_of(const DoneItem& item) { return {{"id", item.id}, {"key", item.key}, {"outcome", item.outcome}}; }

DoneItem read_item(JsonObject& object) {
  DoneItem item{object.text("id"), object.text("key"), object.value("outcome")};
  object.finish();
  return item;
}

// There may be very many items. What a power failure tears does not parse or has another size.
void write_unsynced(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) throw OutputError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
}

// Nothing of an older version, which no item of this program's can be in.
std::optional<ItemsHead> read_items_head(JsonObject& object) {
  if (object.text("format") == "trilat.items" && object.integer("version") == 1) return std::nullopt;
  check_format(object, "trilat.items", 2);
  return ItemsHead{object.text("key"), object.texts("files")};
}

}  // namespace

fs::path item_folder(const fs::path& output, const std::string& id) { return output / kItemsFolder / id; }

void put_item(const fs::path& made, const fs::path& output, const DoneItem& item) {
  std::map<std::string, std::uintmax_t> bytes;
  for (const fs::directory_entry& entry : fs::directory_iterator(made))
    bytes[entry.path().filename().string()] = entry.file_size();
  const Json json{{"format", "trilat.item"}, {"version", 1},   {"id", item.id},
                  {"key", item.key},         {"files", bytes}, {"outcome", item.outcome}};
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
  object.text("id");
  StoredItem item{object.text("key"), object.value("outcome"), {}};
  JsonObject files = object.object("files");
  for (const std::string& name : files.keys()) {
    if (!is_plain_name(name)) files.refuse(name, "is no name of a file");
    item.bytes[name] = files.count(name);
  }
  object.finish();
  return item;
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
  std::set<std::string> files{"run.json"};
  for (const fs::directory_entry& entry : fs::directory_iterator(results))
    if (entry.is_regular_file()) files.insert(entry.path().filename().string());
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
  std::string head;
  if (!std::getline(file, head)) return {};
  const Json json = parse_json(head + "]}", path.string());
  JsonObject object(json, path.string(), "");
  return read_items_head(object).value_or(ItemsHead{});
}

std::vector<DoneItem> read_items(const fs::path& results) {
  const fs::path path = results / "items.json";
  std::vector<DoneItem> items;
  if (!fs::exists(path)) return items;
  const Json json = parse_json(read_file(path, kMostItemsBytes), path.string());
  JsonObject object(json, path.string(), "");
  if (!read_items_head(object)) return items;
  for (JsonObject& entry : object.objects("items")) items.push_back(read_item(entry));
  object.finish();
  return items;
}

}  // namespace trilat
