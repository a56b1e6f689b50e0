// SPDX-License-Identifier: MIT
#include "datasets/results/item_journal.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <unistd.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr std::size_t kMostJournalBytes = std::size_t{1} << 30;

Json json_of(const DoneItem& item) { return {{"id", item.id}, {"key", item.key}, {"outcome", item.outcome}}; }

// A line is the hash of the rest of it, a space, and the item; one without a key says that it is forgotten.
std::string line_of(const DoneItem& item) {
  const std::string text = json_text(json_of(item), -1);
  return hash_of_text(text) + ' ' + text + '\n';
}

DoneItem read_item(JsonObject object) {
  DoneItem item{object.text("id"), object.text("key"), object.value("outcome")};
  object.finish();
  return item;
}

std::optional<DoneItem> read_line(const std::string& line, const std::string& place) {
  const std::size_t space = line.find(' ');
  if (space == std::string::npos) return std::nullopt;
  const std::string text = line.substr(space + 1);
  if (line.substr(0, space) != hash_of_text(text)) return std::nullopt;
  const Json json = parse_json(text, place);
  return read_item(JsonObject(json, place, ""));
}

std::map<std::string, DoneItem> read_journal(const std::filesystem::path& path) {
  std::map<std::string, DoneItem> items;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (auto item = read_line(line, path.string())) {
      std::string id = item->id;
      if (item->key.empty())
        items.erase(id);
      else
        items[id] = std::move(*item);
    }
  return items;
}

}  // namespace

ItemJournal::ItemJournal(const std::filesystem::path& folder) : path_(folder / kFile) {
  items_ = read_journal(path_);
  std::string text;  // without what is torn, so that nothing is appended to half a line
  for (const auto& [id, item] : items_) text += line_of(item);
  write_file(path_, text);
  file_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file_ < 0) throw OutputError(path_.string(), std::string("cannot be opened: ") + std::strerror(errno));
}

ItemJournal::~ItemJournal() {
  if (file_ >= 0) ::close(file_);
}

std::optional<Json> ItemJournal::find(const std::string& id, const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = items_.find(id);
  if (found == items_.end() || found->second.key != key) return std::nullopt;
  return found->second.outcome;
}

void ItemJournal::add(const DoneItem& item) {
  const std::lock_guard lock(mutex_);
  append(item);
  items_[item.id] = item;
}

void ItemJournal::forget(const std::string& id) {
  const std::lock_guard lock(mutex_);
  if (!items_.contains(id)) return;
  append({id, "", nullptr});
  items_.erase(id);
}

void ItemJournal::append(const DoneItem& item) {
  const std::string line = line_of(item);
  for (std::string_view rest = line; !rest.empty();) {
    const ssize_t count = ::write(file_, rest.data(), rest.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0)
      throw OutputError(path_.string(), std::string("cannot be written: ") + std::strerror(errno));
    rest.remove_prefix(static_cast<std::size_t>(count));
  }
  if (::fdatasync(file_) != 0)
    throw OutputError(path_.string(), std::string("cannot be synced to disk: ") + std::strerror(errno));
}

void write_items(const std::filesystem::path& folder, std::span<const DoneItem> items,
                 const std::string& key) {
  std::string text = json_text({{"format", "trilat.items"}, {"version", 1}, {"key", key}}, -1);
  text.back() = ',';  // an item a line
  text += "\"items\":[";
  const char* before = "\n";
  for (const DoneItem& item : items) {
    text += before + json_text(json_of(item), -1);
    before = ",\n";
  }
  write_file(folder / "items.json", text + "\n]}\n");
}

std::string read_items_key(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "items.json";
  std::ifstream file(path);
  std::string head;
  if (!std::getline(file, head)) return {};
  const Json json = parse_json(head + "]}", path.string());
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.items", 1);
  return object.text("key");
}

DoneItems read_items(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "items.json";
  DoneItems done;
  if (!std::filesystem::exists(path)) return done;
  const Json json = parse_json(read_file(path, kMostJournalBytes), path.string());
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.items", 1);
  done.key = object.text("key");
  for (JsonObject& entry : object.objects("items")) done.items.push_back(read_item(entry));
  object.finish();
  return done;
}

}  // namespace trilat
