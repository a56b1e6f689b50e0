// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_take.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>

#include "datasets/base/error.h"
#include "datasets/base/words.h"
#include "datasets/mocap/missing_positions.h"

namespace trilat {
namespace {

struct TypeNames {
  std::string_view name;
  std::string_view motive;
};

constexpr std::array<TypeNames, 6> kTypes{{
    {"rigid_body", "Rigid Body"},
    {"rigid_body_marker", "Rigid Body Marker"},
    {"marker", "Marker"},
    {"bone", "Bone"},
    {"bone_marker", "Bone Marker"},
    {"other", "Other"},
}};

constexpr std::size_t kListedAssets = 20;

bool same_text(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::ranges::equal(a, b, {}, lower, lower);
}

std::string typed_name(const MocapAsset& asset) {
  return std::string(name_of(asset.type)) + ":" + asset.name;
}

bool answers_to(const MocapAsset& asset, std::string_view key) {
  const std::string typed = typed_name(asset);
  return key == asset.name || key == typed || key == asset.name + "#" + asset.id ||
         key == typed + "#" + asset.id;
}

std::string list_of(const MocapHeader& header, const std::vector<std::size_t>& assets) {
  std::string text;
  for (std::size_t i = 0; i < assets.size() && i < kListedAssets; ++i)
    text += (i == 0 ? "" : ", ") + key_of(header, assets[i]);
  if (assets.size() > kListedAssets)
    text += " and " + std::to_string(assets.size() - kListedAssets) + " more";
  return text;
}

}  // namespace

std::string_view name_of(AssetType type) { return kTypes[static_cast<std::size_t>(type)].name; }

std::string_view motive_name_of(AssetType type) { return kTypes[static_cast<std::size_t>(type)].motive; }

AssetType asset_type_from_motive(std::string_view text) {
  for (std::size_t i = 0; i < kTypes.size(); ++i)
    if (same_text(text, kTypes[i].motive)) return static_cast<AssetType>(i);
  return AssetType::other;
}

std::string key_of(const MocapHeader& header, std::size_t asset) {
  const MocapAsset& own = header.assets.at(asset);
  const bool twice = std::ranges::count_if(header.assets, [&](const MocapAsset& other) {
                       return other.type == own.type && other.name == own.name;
                     }) > 1;
  return twice ? typed_name(own) + "#" + own.id : typed_name(own);
}

std::string plain_name(std::string_view name) {
  const auto is_ascii_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  name = name.substr(0, name.find_last_not_of(" \t") + 1);
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (is_ascii_letter(c))
      plain += static_cast<char>(c | 0x20);
    else if ((c >= '0' && c <= '9') || (static_cast<unsigned char>(c) & 0x80) != 0 || c == '+' ||
             (c == '-' && i + 1 == name.size()))
      plain += c;
  }
  return plain;
}

std::size_t find_asset(const MocapHeader& header, std::string_view key, const std::string& place) {
  std::vector<std::size_t> all;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    all.push_back(i);
    if (answers_to(header.assets[i], key)) found.push_back(i);
  }
  const std::string asked = "the asset \"" + std::string(key) + "\"";
  if (all.empty()) throw InputError(place, asked + " is not there; the export holds no assets");
  if (found.empty()) {
    std::vector<std::string> names;
    for (const std::size_t i : all) {
      names.push_back(header.assets[i].name);
      names.push_back(key_of(header, i));
    }
    const std::string nearest = nearest_name(key, names);
    throw InputError(place, asked + " is not in the export; there are: " + list_of(header, all) +
                                (nearest.empty() ? "" : "; did you mean \"" + nearest + "\"?"));
  }
  if (found.size() > 1) throw InputError(place, asked + " can mean several: " + list_of(header, found));
  return found.front();
}

std::vector<std::size_t> assets_of_joint(const MocapHeader& header, const std::vector<std::string>& keys,
                                         const std::string& place) {
  std::vector<std::size_t> assets;
  for (const std::string& key : keys) {
    assets.push_back(find_asset(header, key, place));
    const MocapAsset& asset = header.assets[assets.back()];
    if (header.coordinate_space == "Local" &&
        (asset.type == AssetType::bone || asset.type == AssetType::bone_marker))
      throw InputError(place, "names \"" + key +
                                  "\", whose positions are relative to its parent; export again with the "
                                  "coordinate space Global");
    if (!asset.has_position)
      throw InputError(place, "names the asset \"" + key + "\", of which the export holds no position");
    if (std::ranges::count(assets, assets.back()) > 1)
      throw InputError(place, "names the asset \"" + key + "\" twice, in two ways");
  }
  return assets;
}

void refuse_same_assets(std::span<const std::string> joints, std::span<const std::vector<std::size_t>> assets,
                        const std::string& place) {
  std::map<std::set<std::size_t>, std::string> known;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (assets[j].empty()) continue;
    const auto [first, is_new] = known.try_emplace({assets[j].begin(), assets[j].end()}, joints[j]);
    if (!is_new)
      throw InputError(place + joints[j],
                       "names the same assets as " + first->second + ": which of both are they?");
  }
}

namespace {

AssetSummary summary_of(const std::vector<Eigen::Vector3d>& position_m,
                        const std::vector<Eigen::Vector3d>& middle_m) {
  AssetSummary counts;
  for (std::size_t f = 0; f < position_m.size(); ++f) {
    if (!position_m[f].allFinite()) {
      ++counts.missing;
      continue;
    }
    ++counts.samples;
    counts.sum_m += position_m[f] - middle_m[f];
  }
  return counts;
}

// The mean of all assets that are there in a frame.
std::vector<Eigen::Vector3d> middles_of(const MocapTake& take) {
  std::vector<Eigen::Vector3d> middle_m(take.time.size());
  for (std::size_t f = 0; f < middle_m.size(); ++f) {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const std::vector<Eigen::Vector3d>& position_m : take.position_m)
      if (position_m[f].allFinite()) {
        sum_m += position_m[f];
        count += 1.0;
      }
    middle_m[f] = sum_m / count;
  }
  return middle_m;
}

}  // namespace

LikelyUp likely_up(const MocapSummary& summary) {
  constexpr double kTimes = 1.5;  // as long as the next axis
  Eigen::AlignedBox3d box;
  for (const AssetSummary& asset : summary.assets)
    if (asset.samples > 0) box.extend(Eigen::Vector3d(asset.sum_m / static_cast<double>(asset.samples)));
  LikelyUp up;
  if (box.isEmpty()) return up;
  up.spread_m = box.sizes();
  Eigen::Index longest = 0;
  const double most_m = up.spread_m.maxCoeff(&longest);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (axis != longest && !(most_m > kTimes * up.spread_m[axis])) return up;
  up.axis = "xyz"[longest];
  return up;
}

MocapSummary summarize_mocap(MocapTake take) {
  MocapSummary summary;
  summary.frames = std::ssize(take.time);
  for (std::size_t f = 1; f < take.frame.size(); ++f)
    if (const std::int64_t skipped = take.frame[f] - take.frame[f - 1] - 1; skipped > 0) {
      ++summary.index_gaps;
      summary.skipped_frames += skipped;
    }
  if (!take.time.empty()) summary.duration_s = (take.time.back() - take.time.front()).seconds();
  summary.rate_hz = take.header.export_rate_hz;
  if (std::isnan(summary.rate_hz) && summary.duration_s > 0.0)
    summary.rate_hz = static_cast<double>(summary.frames - 1) / summary.duration_s;
  const std::vector<Eigen::Vector3d> middle_m = middles_of(take);
  for (const std::vector<Eigen::Vector3d>& position_m : take.position_m)
    summary.assets.push_back(summary_of(position_m, middle_m));
  const std::vector<MissingCounts> missing = remove_missing(take.time, take.position_m);
  for (std::size_t i = 0; i < missing.size(); ++i) summary.assets[i].no_measurement = missing[i];
  return summary;
}

}  // namespace trilat
