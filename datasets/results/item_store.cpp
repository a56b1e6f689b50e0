// SPDX-License-Identifier: MIT
#include "datasets/results/item_store.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kItemFile = "item.json";
constexpr const char* kAside = ".aside.";
constexpr std::size_t kMaxItemBytes = std::size_t{1} << 30;

// There may be very many items. What a power failure tears does not parse or has another size.
void write_unsynced(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) throw OutputError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
}

bool is_aside(const fs::path& folder) { return folder.filename().string().starts_with(kAside); }

// Holds the folder until it is closed; -1 where another process does.
int locked(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  if (file >= 0) ::close(file);
  return -1;
}

Json read_manifest(const fs::path& results) {
  const fs::path path = results / "manifest.json";
  Json json = read_json(path);
  JsonObject manifest(json, path.string(), "");
  check_format(manifest, "trilat.manifest", 2);
  return json;
}

}  // namespace

void StoredItem::check(const JsonObject& object) const {
  for (const auto& [name, size] : bytes)
    if (!is_plain_name(name)) object.refuse_below("files/" + name, "is not a file name");
}

std::optional<StoredItem> ItemStore::find(const std::string& key) const {
  const fs::path path = folder(key) / kItemFile;
  if (!fs::exists(folder(key))) return std::nullopt;
  const Json json = parse_json(read_file(path, kMaxItemBytes), path.string());
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.item", 2);
  std::optional<StoredItem> item(std::in_place);
  read_fields(object, *item);
  if (item->key != key) object.refuse("key", "is another than the name of its folder");
  for (const auto& [name, bytes] : item->bytes) {
    std::error_code error;
    if (fs::file_size(folder(key) / name, error) != bytes || error)
      throw InputError((folder(key) / name).string(), "is not whole");
  }
  return item;
}

void ItemStore::put(const fs::path& made, StoredItem item) const {
  for (const fs::directory_entry& entry : fs::directory_iterator(made))
    item.bytes[entry.path().filename().string()] = entry.file_size();
  Json json{{"format", "trilat.item"}, {"version", 2}};
  json.update(json_of(item));
  write_unsynced(made / kItemFile, json_text(json, -1) + '\n');
  const fs::path place = folder(item.key);
  std::error_code error;
  fs::rename(made, place, error);
  if (error && fs::exists(place)) {  // it is to be replaced, or another process was faster
    fs::remove_all(place, error);
    fs::rename(made, place, error);
  }
  if (error) throw OutputError(place.string(), "cannot be put in place: " + error.message());
}

void ItemStore::remove_all_but(const std::set<std::string>& keys) const {
  std::vector<fs::path> others;
  if (!fs::exists(folder_)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    if (!keys.contains(entry.path().filename().string())) others.push_back(entry.path());
  for (const fs::path& other : others) {
    const int lock = is_aside(other) ? locked(other) : -1;
    if (is_aside(other) && lock < 0) continue;  // somebody is at work
    std::error_code ignored;
    fs::remove_all(other, ignored);
    if (lock >= 0) ::close(lock);
  }
}

void ItemStore::remove_if_empty() const {
  std::error_code not_empty;
  fs::remove(folder_, not_empty);
}

std::size_t ItemStore::size() const {
  std::size_t count = 0;
  if (!fs::exists(folder_)) return 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    count += is_aside(entry.path()) ? 0 : 1;
  return count;
}

ItemStore::Aside::Aside(const ItemStore& store) {
  make_folder(store.folder_);
  std::string name = (store.folder_ / (std::string(kAside) + "XXXXXX")).string();
  if (!::mkdtemp(name.data()))
    throw OutputError(store.folder_.string(), std::string("cannot be written to: ") + std::strerror(errno));
  path_ = name;
  folder_ = locked(path_);
}

ItemStore::Aside::~Aside() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (folder_ >= 0) ::close(folder_);
}

std::map<std::string, std::string> read_item_keys(const fs::path& results) {
  const Json json = read_manifest(results);
  JsonObject manifest(json, (results / "manifest.json").string(), "");
  JsonObject items = manifest.object("items");
  std::map<std::string, std::string> keys;
  for (const std::string& id : items.keys()) keys[id] = items.value(id).is_null() ? "" : items.text(id);
  return keys;
}

std::string unfinished_results(const fs::path& results) {
  if (fs::exists(results / "summary.json") || !fs::exists(results / "manifest.json")) return "";
  const ItemStore store(results);
  const auto keys = read_item_keys(results);
  std::size_t there = 0, known = 0;
  for (const auto& [id, key] : keys) {
    known += key.empty() ? 0 : 1;
    there += !key.empty() && fs::exists(store.folder(key)) ? 1 : 0;
  }
  if (known < keys.size()) there = std::min(store.size(), keys.size());  // shards know their own alone
  return fmt::format("is unfinished: {} of {} items are there; `trilat run` as before goes on from them",
                     there, keys.size());
}

std::vector<ResultTake> result_takes(const fs::path& results) {
  const ItemStore store(results);
  const auto keys = read_item_keys(results);
  const Json json = read_manifest(results);
  JsonObject manifest(json, (results / "manifest.json").string(), "");
  std::vector<ResultTake> takes;
  for (JsonObject& take : manifest.objects("takes")) {
    const std::string id = take.text("id");
    const auto key = keys.find("takes/" + id);
    if (key == keys.end()) take.refuse("id", "is of a take that is none of the items");
    takes.push_back(
        {id, take.text("activity"), key->second.empty() ? fs::path() : store.folder(key->second)});
    if (!key->second.empty() && !fs::exists(takes.back().folder))
      throw InputError(takes.back().folder.string(),
                       "is missing: the item of take \"" + id + "\"; run the study again");
  }
  return takes;
}

StoredTake open_take(const ResultTake& take) {
  StoredTake file = StoredTake::open(take.folder / StoredTake::kName);
  if (file.head().id != take.id)
    throw InputError(file.path().string(),
                     "is of the take \"" + file.head().id + "\", not \"" + take.id + '"');
  return file;
}

}  // namespace trilat
