// SPDX-License-Identifier: MIT
#include "pipeline/items/item_store.h"

#include "datasets/base/build_id.h"
#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"

namespace trilat {

std::string key_of_item(const Json& settings) {
  return hash_of_text(json_text(Json{{"build", build_id()}, {"settings", settings}}, -1));
}

ItemStore::ItemStore(const std::filesystem::path& folder, std::span<const std::filesystem::path> reuse)
    : folder_(folder), journal_(folder) {
  for (const std::filesystem::path& earlier : reuse) {
    if (!std::filesystem::is_directory(earlier))
      throw InputError(earlier.string(), "is no folder whose results could be used again");
    Earlier known{earlier, {}};
    for (DoneItem& item : read_items(earlier).items) {
      std::string id = item.id;
      known.items[id] = std::move(item);
    }
    earlier_.push_back(std::move(known));
  }
}

std::optional<ItemStore::Found> ItemStore::find(
    const std::string& id, const std::string& key,
    const std::function<bool(const std::filesystem::path&)>& usable) {
  if (auto outcome = journal_.find(id, key); outcome && (!usable || usable(folder_))) {
    const std::lock_guard lock(mutex_);
    tally_.continued.push_back(id);
    return Found{std::move(*outcome), folder_};
  }
  for (const Earlier& known : earlier_) {
    const auto item = known.items.find(id);
    if (item == known.items.end() || item->second.key != key) continue;
    if (usable && !usable(known.folder)) continue;
    const std::lock_guard lock(mutex_);
    tally_.reused.push_back(id);
    return Found{item->second.outcome, known.folder};
  }
  return std::nullopt;
}

void ItemStore::add(const std::string& id, const std::string& key, const Json& outcome) {
  journal_.add({id, key, outcome});
  const std::lock_guard lock(mutex_);
  tally_.computed.push_back(id);
}

ItemTally ItemStore::tally() const {
  const std::lock_guard lock(mutex_);
  return tally_;
}

}  // namespace trilat
