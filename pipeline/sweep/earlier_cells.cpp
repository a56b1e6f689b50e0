// SPDX-License-Identifier: MIT
#include "pipeline/sweep/earlier_cells.h"

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/items/file_identity.h"
#include "pipeline/sweep/sweep_cell_key.h"

namespace trilat {
namespace {

// `written`: when the items were that belong to the cells.
std::vector<SweepRecord::Reused> cells_in(const std::filesystem::path& folder, const std::string& written,
                                          std::size_t items) {
  std::vector<SweepRecord::Reused> cells;
  for (SweepCell& cell : read_sweep_summary(folder).cells)
    cells.push_back({folder.string(), std::move(cell)});
  if (when_written(folder / "items.json") != written)
    throw InputError(folder.string(), "was replaced while its results were used again; run again");
  if (cells.size() != items)
    throw InputError((folder / "items.json").string(), "does not list the cells of the summary beside it");
  return cells;
}

}  // namespace

std::vector<DoneItem> items_of(const SweepPlan& plan) {
  std::vector<DoneItem> items;
  for (std::size_t c = 0; c < plan.cells(); ++c)
    items.push_back({id_of_cell(plan, c), key_of_cell(plan, c), nullptr});
  return items;
}

EarlierCells::EarlierCells(std::span<const std::filesystem::path> folders) {
  for (const std::filesystem::path& folder : folders) {
    if (!std::filesystem::is_directory(folder))
      throw InputError(folder.string(), "is no folder whose results could be used again");
    std::string written = when_written(folder / "items.json");
    const std::vector<DoneItem> items = read_items(folder).items;
    Earlier& earlier = earlier_.emplace_back(Earlier{folder, std::move(written), items.size(), {}, {}});
    for (std::size_t i = 0; i < items.size(); ++i) earlier.number_of_key.emplace(items[i].key, i);
  }
}

const SweepRecord::Reused* EarlierCells::find(const std::string& key) {
  for (Earlier& earlier : earlier_) {
    const auto found = earlier.number_of_key.find(key);
    if (found == earlier.number_of_key.end()) continue;
    if (earlier.cells.empty()) earlier.cells = cells_in(earlier.folder, earlier.written, earlier.items);
    return &earlier.cells[found->second];
  }
  return nullptr;
}

}  // namespace trilat
