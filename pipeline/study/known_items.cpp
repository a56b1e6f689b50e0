// SPDX-License-Identifier: MIT
#include "pipeline/study/known_items.h"

#include <algorithm>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/study/hash_cache.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// The item in its folder below `output`, when it is there, whole and of that key. What cannot be read was
// torn when the machine failed.
std::optional<Outcome> whole_item(const fs::path& output, const std::string& id, const std::string& key) {
  const fs::path folder = item_folder(output, id);
  try {
    const std::optional<StoredItem> stored = stored_item(folder);
    if (!stored || stored->key != key || !damaged_file(*stored, folder).empty()) return std::nullopt;
    return Outcome{key, folder, {}};
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// Outcomes by key; none of results that are damaged.
std::map<std::string, Json> gathered_outcomes(const fs::path& output) {
  std::map<std::string, Json> outcomes;
  try {
    if (is_damaged(output, read_items_head(output))) return {};
    for (DoneItem& item : read_items(output)) outcomes[item.key] = std::move(item.outcome);
    return outcomes;
  } catch (const InputError&) {
    return {};
  }
}

// The file of an output that is written anew whenever its items are.
std::string when_listed(const fs::path& output) {
  const fs::path list = output / "items.json";
  return when_written(fs::exists(list) ? list : output / "run.json");
}

}  // namespace

KnownItems::KnownItems(const Study& study, const fs::path& folder, std::span<const fs::path> reuse,
                       bool is_whole)
    : study_(study), folder_(folder), is_whole_(is_whole) {
  for (const fs::path& output : reuse) {
    if (!fs::is_directory(output))
      throw InputError(output.string(), "is no folder whose results could be used again");
    const std::string written = when_listed(output);
    earlier_.push_back({output, written, false, gathered_outcomes(output)});
  }
}

std::optional<KnownItems::Found> KnownItems::find(const std::string& id, const std::string& key) {
  if (!key.empty()) {
    if (auto here = whole_item(folder_, id, key)) return Found{std::move(*here), true};
    for (Earlier& earlier : earlier_)
      if (auto found = find_in(earlier, id, key)) {
        fs::remove_all(item_folder(folder_, id));
        const std::lock_guard lock(mutex_);
        earlier.used = true;
        return Found{std::move(*found), false};
      }
  }
  fs::remove_all(item_folder(folder_, id));
  return std::nullopt;
}

std::optional<Outcome> KnownItems::find_in(const Earlier& earlier, const std::string& id,
                                           const std::string& key) const {
  if (auto whole = whole_item(earlier.folder, id, key)) return whole;
  const auto item = earlier.gathered.find(key);
  if (item == earlier.gathered.end()) return std::nullopt;
  const bool has_files = std::ranges::all_of(
      study_.gathers, [&](const std::string& name) { return fs::exists(earlier.folder / name); });
  if (!has_files || !(is_whole_ || study_.gathers.empty())) return std::nullopt;
  return Outcome{key, earlier.folder, item->second};
}

Outcome KnownItems::bring_here(const std::string& id, const Outcome& found, const fs::path& aside) const {
  const fs::path here = item_folder(folder_, id);
  if (found.folder == here) return found;
  make_folder(aside);
  if (!found.gathered) {
    const std::optional<StoredItem> stored = stored_item(found.folder);
    TRILAT_CHECK(stored.has_value(), "an item was found because it is stored");
    for (const auto& [name, bytes] : stored->bytes) link_or_copy(found.folder / name, aside / name);
  }
  put_item(aside, folder_, {id, found.key, found.json()});
  return {found.key, here, {}};
}

void KnownItems::check_earlier() const {
  for (const Earlier& earlier : earlier_)
    if (earlier.used && when_listed(earlier.folder) != earlier.written)
      throw InputError(earlier.folder.string(), "was replaced while its results were used again; run again");
}

void link_or_copy(const fs::path& from, const fs::path& to) {
  constexpr std::uintmax_t kSmallBytes = 1 << 20;  // as documents are that somebody may edit
  std::error_code error;
  const bool links = fs::file_size(from, error) > kSmallBytes;
  if (links) fs::create_hard_link(from, to, error);
  if (!links || error) fs::copy_file(from, to, error);
  if (error)
    throw OutputError(to.string(),
                      "cannot be linked or copied from " + from.string() + ": " + error.message());
}

bool holds_results(const fs::path& output, const std::string& key) {
  // items are there when they could not be removed at the end: then all is put in place again
  if (key.empty() || fs::exists(output / kItemsFolder)) return false;
  try {
    const ItemsHead head = read_items_head(output);
    return head.key == key && has_all_files(output, head) && !is_damaged(output, head);
  } catch (const InputError&) {
    return false;
  }
}

Outcomes outcomes_of(std::span<const FoundPart> parts) {
  Outcomes outcomes;
  for (const PartItem& item : parts.front().part.items) {
    const fs::path& part = parts[item.shard - 1].folder;
    const fs::path folder = item_folder(part, item.id);
    const std::optional<StoredItem> stored = stored_item(folder);
    if (!stored) throw InputError(part.string(), "does not hold its item " + item.id);
    if (const fs::path file = damaged_file(*stored, folder); !file.empty())
      throw InputError(
          file.string(),
          "is missing or has another size than its part says; remove the part and run its shard again");
    outcomes[item.id] = {stored->key, folder, {}};
  }
  return outcomes;
}

}  // namespace trilat
