// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_take.h"

#include <array>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::size_t kMostListed = 20;

std::string key_of(const MocapAsset& asset) { return std::string(name_of(asset.type)) + ":" + asset.name; }

std::string list_of(const MocapHeader& header, const std::vector<std::size_t>& which) {
  std::string text;
  for (std::size_t i = 0; i < which.size() && i < kMostListed; ++i)
    text += (i ? ", " : "") + key_of(header.assets[which[i]]);
  if (which.size() > kMostListed) text += " and " + std::to_string(which.size() - kMostListed) + " more";
  return text;
}

}  // namespace

std::string_view name_of(AssetType type) {
  static constexpr std::array<std::string_view, 6> kNames{"rigid_body", "rigid_body_marker", "marker",
                                                          "bone",       "bone_marker",       "other"};
  return kNames[static_cast<std::size_t>(type)];
}

std::size_t find_asset(const MocapHeader& header, const std::string& key, const std::string& place) {
  std::vector<std::size_t> found, all;
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    all.push_back(i);
    if (header.assets[i].name == key || key_of(header.assets[i]) == key) found.push_back(i);
  }
  if (found.size() == 1) return found[0];
  if (found.empty())
    throw InputError(place, "names the asset \"" + key + "\", which the export does not hold; it holds " +
                                (all.empty() ? "no assets at all" : list_of(header, all)));
  throw InputError(place, "names the asset \"" + key + "\", which could be " + list_of(header, found) +
                              "; write one of these, or give the assets different names in the export");
}

}  // namespace trilat
