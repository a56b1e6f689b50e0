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

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kItemFile = "item.json";
constexpr const char* kStagingPrefix = ".aside.";
constexpr std::size_t kMaxItemBytes = std::size_t{1} << 30;

// There may be very many items. What a power failure tears does not parse or has another size.
void write_unsynced(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) throw OutputError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
}

bool is_aside(const fs::path& folder) { return folder.filename().string().starts_with(kStagingPrefix); }

// Holds the folder until it is closed; -1 where another process does.
int locked(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  if (file >= 0) ::close(file);
  return -1;
}

}  // namespace

void StoredItem::check(const JsonPlace& place) const {
  for (const auto& [name, size] : bytes)
    if (!is_plain_name(name)) place.at("files").at(name).refuse("is not a file name");
}

std::optional<StoredItem> ItemStore::find(const std::string& key) const {
  const fs::path path = folder(key) / kItemFile;
  if (!fs::exists(folder(key))) return std::nullopt;
  const auto item = read_as<StoredItem>(parse_json(read_file(path, kMaxItemBytes), path.string()), {path});
  if (item.key != key) JsonPlace(path).at("key").refuse("is another than the name of its folder");
  for (const auto& [name, bytes] : item.bytes) {
    std::error_code error;
    if (fs::file_size(folder(key) / name, error) != bytes || error)
      throw InputError((folder(key) / name).string(), "is not whole");
  }
  return item;
}

void ItemStore::put(const fs::path& made, StoredItem item) const {
  for (const fs::directory_entry& entry : fs::directory_iterator(made))
    item.bytes[entry.path().filename().string()] = entry.file_size();
  write_unsynced(made / kItemFile, json_text(json_of(item), -1) + '\n');
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

ItemStore::StagingFolder::StagingFolder(const ItemStore& store) {
  make_folder(store.folder_);
  std::string name = (store.folder_ / (std::string(kStagingPrefix) + "XXXXXX")).string();
  if (!::mkdtemp(name.data()))
    throw OutputError(store.folder_.string(), std::string("cannot be written to: ") + std::strerror(errno));
  path_ = name;
  folder_ = locked(path_);
}

ItemStore::StagingFolder::~StagingFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (folder_ >= 0) ::close(folder_);
}

Manifest read_manifest(const fs::path& results) {
  const JsonPlace place(results / "manifest.json");
  auto manifest = read_as<Manifest>(read_json(place.file), place);
  manifest.place = place;
  return manifest;
}

void check_same_run(const Manifest& manifest, const std::string& kind, const std::string& study,
                    const std::string& campaign) {
  const auto same = [](const JsonPlace& place, const std::string& found, const std::string& wanted) {
    if (found != wanted)
      place.refuse(
          fmt::format("is \"{}\", and that of summary.json beside it \"{}\": the folder holds "
                      "parts of two runs; run the study again",
                      found, wanted));
  };
  same(manifest.place.at("study").at("kind"), manifest.study.kind, kind);
  same(manifest.place.at("study").at("name"), manifest.study.name, study);
  if (!manifest.campaign.empty() && !campaign.empty())
    same(manifest.place.at("campaign"), manifest.campaign, campaign);
}

std::string unfinished_results(const fs::path& results) {
  if (fs::exists(results / "summary.json") || !fs::exists(results / "manifest.json")) return "";
  const ItemStore store(results);
  const auto keys = read_manifest(results).items;
  std::size_t there = 0, known = 0;
  for (const auto& [id, key] : keys) {
    known += key ? 1 : 0;
    there += key && fs::exists(store.folder(*key)) ? 1 : 0;
  }
  if (known < keys.size()) there = std::min(store.size(), keys.size());  // shards know their own alone
  return fmt::format("is unfinished: {} of {} items are there; `trilat run` as before goes on from them",
                     there, keys.size());
}

std::vector<ResultTake> result_takes(const fs::path& results) {
  const ItemStore store(results);
  const Manifest manifest = read_manifest(results);
  std::vector<ResultTake> takes;
  for (std::size_t t = 0; t < manifest.takes.size(); ++t) {
    const Manifest::Take& take = manifest.takes[t];
    const auto key = manifest.items.find("takes/" + take.id);
    if (key == manifest.items.end())
      manifest.place.at("takes").at(t).at("id").refuse("is of a take that is none of the items");
    takes.push_back({take.id, take.activity, key->second ? store.folder(*key->second) : fs::path()});
    if (key->second && !fs::exists(takes.back().folder))
      throw InputError(takes.back().folder.string(),
                       "is missing: the item of take \"" + take.id + "\"; run the study again");
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
