// SPDX-License-Identifier: MIT
#include "pipeline/items/item_store.h"

#include "datasets/base/build_id.h"
#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "pipeline/items/file_identity.h"

namespace trilat {

std::string key_of_item(const Json& settings) {
  return hash_of_text(json_text(Json{{"build", build_id()}, {"settings", settings}}, -1));
}

Json json_of(const ItemTally& tally) {
  return {{"computed", tally.computed}, {"continued", tally.continued}, {"reused", tally.reused}};
}

ItemStore::ItemStore(const std::filesystem::path& folder, std::span<const std::filesystem::path> reuse)
    : folder_(folder), journal_(folder) {
  for (const std::filesystem::path& earlier : reuse) {
    if (!std::filesystem::is_directory(earlier))
      throw InputError(earlier.string(), "is no folder whose results could be used again");
    Earlier known{earlier, when_written(earlier / "items.json"), false, {}};
    for (DoneItem& item : read_items(earlier).items) {
      std::string id = item.id;
      known.items[id] = std::move(item);
    }
    earlier_.push_back(std::move(known));
  }
}

std::optional<ItemStore::Found> ItemStore::find(const std::string& id, const std::string& key,
                                                const Usable& usable) {
  if (auto outcome = journal_.find(id, key)) {
    Found found{std::move(*outcome), folder_};
    if (!usable || usable(found)) {
      const std::lock_guard lock(mutex_);
      tally_.continued.push_back(id);
      return found;
    }
  }
  journal_.forget(id);  // before its files are made anew
  for (Earlier& known : earlier_) {
    const auto item = known.items.find(id);
    if (item == known.items.end() || item->second.key != key) continue;
    Found found{item->second.outcome, known.folder};
    if (usable && !usable(found)) continue;
    const std::lock_guard lock(mutex_);
    known.used = true;
    tally_.reused.push_back(id);
    return found;
  }
  return std::nullopt;
}

void ItemStore::add(const std::string& id, const std::string& key, const Json& outcome) {
  journal_.add({id, key, outcome});
  const std::lock_guard lock(mutex_);
  tally_.computed.push_back(id);
}

void ItemStore::check_earlier() const {
  const std::lock_guard lock(mutex_);
  for (const Earlier& known : earlier_)
    if (known.used && when_written(known.folder / "items.json") != known.written)
      throw InputError(known.folder.string(), "was replaced while its results were used again; run again");
}

ItemTally ItemStore::tally() const {
  const std::lock_guard lock(mutex_);
  return tally_;
}

}  // namespace trilat
