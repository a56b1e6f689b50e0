// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/base/units.h"

namespace trilat {

// A far value that stands for missing.
inline constexpr double kFilled = std::numeric_limits<double>::infinity();

// Type of a column, as OptiTrack calls it. A rigid body marker is the solved position, present while the
// marker is hidden; a marker is the measured one, missing while hidden. `other` is a type that is none of
// these and yet has a position.
enum class AssetType { rigid_body, rigid_body_marker, marker, bone, bone_marker, other };

std::string_view name_of(AssetType type);                 // "rigid_body", …
std::string_view motive_name_of(AssetType type);          // "Rigid Body", …
AssetType asset_type_from_motive(std::string_view text);  // any case; else `other`

// End of the take name of a simulated motion capture.
inline constexpr std::string_view kSimulatedTake = " simulated";

// One name may stand under several types, and even twice under one: then only the ID tells them apart. The ID
// is opaque text.
struct MocapAsset {
  AssetType type = AssetType::other;
  std::string name;
  std::string id;
  std::string parent;
  bool has_position = false;  // else the export has its rotations alone
  std::size_t column = 0;     // its first one in the file, counted from 1; 0 where it has none of its own
};

struct MocapHeader {
  std::string format;  // "Motive CSV 1.23", "TRC"
  std::string take_name;
  std::string take_notes;
  std::string capture_start_text;  // local time without zone, as written
  double capture_rate_hz = kNaN;
  double export_rate_hz = kNaN;  // NaN: not stated
  std::optional<std::int64_t> capture_start_frame;
  std::optional<std::int64_t> total_frames_in_take;
  std::optional<std::int64_t> total_exported_frames;
  LengthUnit length_unit = LengthUnit::metre;
  std::string coordinate_space = "Global";
  std::int64_t first_frame = 0;
  std::string taken_as;  // what is read in another way than the header states, a sentence; empty: nothing
  std::vector<MocapAsset> assets;

  // Whether this program simulated it. A recorded take of somebody who simulates a fall has a start time.
  bool is_simulated() const { return take_name.ends_with(kSimulatedTake) && capture_start_text.empty(); }
};

// Oddities a reader lives with. A careful user looks at them; `trilat info` prints them.
struct MocapAnomalies {
  std::int64_t repeated_frames = 0;  // rows dropped because time did not advance
  std::int64_t rows_with_extra_fields = 0;
  std::int64_t not_finite_cells = 0;      // NAN, #IND or infinity in a column: missing
  std::int64_t partial_poses = 0;         // positions dropped: not all components there
  std::int64_t printed_time_differs = 0;  // rows off the frame-derived time by over a frame period
  bool truncated_last_row = false;        // the file ends inside a row, which is not trusted
  // Numbers of frames that the header promises and that are there, where the file ends before; 0 otherwise.
  // Known at the end.
  std::int64_t frames_promised = 0, frames_there = 0;
  double largest_time_error_s = kNaN;  // of the printed times against the delivered ones
};

// How many positions of one asset are no measurement.
struct MissingCounts {
  std::int64_t at_origin = 0;  // exactly (0, 0, 0)
  std::int64_t filled = 0;     // one value that repeats: far from all others, or three equal numbers
  std::int64_t held = 0;       // the last one again, to the last bit, while others move

  std::int64_t sum() const { return at_origin + filled + held; }
};

// A motion capture. World is right-handed, y up, metres. A position that is missing is NaN in all its
// components; in a take as it is written it is infinite where the file has one far value again and again.
struct MocapTake {
  MocapHeader header;
  std::vector<std::int64_t> frame;  // number of each frame, as the file has it
  std::vector<MocapTime> time;      // of each frame, since the first; strictly increasing
  double first_s = 0.0;             // the first frame's time as the file has it; 0 where it has none
  std::vector<std::vector<Eigen::Vector3d>> position_m;  // by asset and frame; empty where it was not wanted
  std::vector<MissingCounts> missing = {};               // by asset, of positions that were taken out
  MocapAnomalies anomalies = {};
  // One sentence for each thing that was read in another way than the file states it.
  std::vector<std::string> taken_as = {};
};

// "rigid_body:Wand", and "#ID" behind it when that alone does not tell it from another asset.
std::string key_of(const MocapHeader& header, std::size_t asset);

// A name without blanks and signs that do not count, ASCII in lower case; what is left of two names is equal
// when they mean the same. Letters of every script are kept, and the signs + and - behind a name, which tell
// sides apart.
std::string plain_name(std::string_view name);

// The asset a person means by "Wand", "rigid_body:Wand", "Wand#ID" or "rigid_body:Wand#ID".
// InputError at `place` when no asset has that key (lists those there are) or several have it (lists them).
std::size_t find_asset(const MocapHeader& header, std::string_view key, const std::string& place);

// The assets whose mean position is a joint. InputError at `place` for one that does not exist, has no
// position, or is a bone whose positions are relative to its parent.
std::vector<std::size_t> assets_of_joint(const MocapHeader& header, const std::vector<std::string>& keys,
                                         const std::string& place);

// Refuses joints that have the same assets, as a copied line of a mapping gives them: the place of one of
// them is then the other's. `assets`: by joint, none of a joint that is not mapped; `place`: of the mapping's
// joints.
void refuse_same_assets(std::span<const std::string> joints, std::span<const std::vector<std::size_t>> assets,
                        const std::string& place);

struct AssetSummary {
  std::int64_t samples = 0;                         // frames in which the asset has a position
  std::int64_t missing = 0;                         // frames in which it has none
  MissingCounts no_measurement;                     // samples that stand for what was not seen
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();  // of its positions, less the mean of all in the frame
};

struct MocapSummary {
  std::int64_t frames = 0;
  std::int64_t index_gaps = 0;       // places where the frame index skips
  std::int64_t skipped_frames = 0;   // indices skipped there
  double duration_s = 0.0;           // from the first frame to the last
  double rate_hz = kNaN;             // as stated; else frames over duration
  std::vector<AssetSummary> assets;  // as in the header
};

// The axis along which the assets' mean positions spread most: that which points up, when it is a person or a
// rig of markers on one. 'x', 'y' or 'z'; nothing when another axis is nearly as long.
struct LikelyUp {
  std::optional<char> axis;
  Eigen::Vector3d spread_m = Eigen::Vector3d::Constant(kNaN);
};
LikelyUp likely_up(const MocapSummary& summary);

// Summary of a take as it is written, with counts of what remove_missing() would take out.
MocapSummary summarize_mocap(MocapTake take);

}  // namespace trilat
