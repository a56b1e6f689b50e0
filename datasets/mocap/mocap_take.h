// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "datasets/base/time.h"
#include "datasets/base/units.h"

namespace trilat {

// What OptiTrack exports: a rigid body's pose, its markers as solved (there even while hidden) and as seen
// (`marker`, missing while hidden), and a skeleton's bones. `other` is a type this program does not know.
enum class AssetType { rigid_body, rigid_body_marker, marker, bone, bone_marker, other };
std::string_view name_of(AssetType type);  // "rigid_body", …

// The key is type and name: Motive uses one name for a marker as solved and as seen. Two assets may still
// share both; then only the id tells them apart. Ids are opaque texts.
struct MocapAsset {
  AssetType type = AssetType::other;
  std::string name;
  std::string id;
  bool has_position = false;
  bool has_rotation = false;
};

struct MocapHeader {
  std::string format;  // "Motive CSV 1.23", "OptiTrack rows 1.1"
  std::string take_name;
  std::string capture_start;      // as printed: local time of unknown zone, in the language of the machine
  std::optional<double> rate_hz;  // of the exported frames; none when only time stamps tell
  std::optional<std::int64_t> stated_frames;
  LengthUnit length_unit = LengthUnit::metre;
  std::string rotation_type;  // "Quaternion" or an order of Euler angles
  std::string coordinate_space;
  bool left_handed = false;  // as exported; what is read has been made right-handed by turning z round
  std::vector<MocapAsset> assets;
};

// One asset in one frame: world, metres; NaN when missing.
struct MocapPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Quaterniond rotation{std::numeric_limits<double>::quiet_NaN(), 0, 0, 0};
  bool has_position() const { return position_m.allFinite(); }
  bool has_rotation() const { return rotation.coeffs().allFinite(); }
};

// One frame. Time is zero at the first frame of the file: (index - first index) / rate where the rate is
// known, since printed times are often rounded; else the printed time.
struct MocapFrame {
  std::int64_t index = 0;
  MocapTime time;
  double printed_time_s = 0.0;
  std::vector<MocapPose> poses;  // by asset
};

// Things in the data that were put up with.
struct MocapAnomalies {
  std::uint64_t repeated_frames = 0;  // index not above the one before; left out
  std::uint64_t rows_with_extra_fields = 0;
  std::uint64_t not_finite_cells = 0;  // NAN, #IND, inf: missing
  bool truncated_last_row = false;     // left out
};

// The asset that `key` means: "name", or "type:name" where a name stands under several types. InputError at
// `place`, listing the candidates or what there is.
std::size_t find_asset(const MocapHeader& header, const std::string& key, const std::string& place);

}  // namespace trilat
