// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/document.h"
#include "datasets/base/files.h"
#include "datasets/rig/skeleton.h"

namespace trilat {

// The axis that points up in a ground truth's world. In our world it is y; TRC files often have z.
enum class UpAxis : std::uint8_t { y, z };
template <>
inline constexpr std::array words<UpAxis>{"y", "z"};
// The key "up_axis" of an object that may have one.
void visit_up_axis(auto& f, auto& axis, const char* meaning) {
  f.removed("up_axis", "auto", "leave the key out for y, or state \"z\"");
  f("up_axis", axis, opt(meaning));
}
// Refusal of a take that does not state its axis and whose person stands along z.
inline constexpr const char* kStandsAlongZ =
    "holds a person who stands along z, and y is taken as up: state \"up_axis\": \"z\" in the take, or \"y\" "
    "where that is right (trilat compare: --up z)";

// A point of a right-handed world with z up, in one with y up: a quarter turn about x.
inline Eigen::Vector3d y_up_from_z_up(const Eigen::Vector3d& point) {
  return {point.x(), point.z(), -point.y()};
}

// Along which axis a person stands: from the lowest joints that are known to the highest, in the mean.
class UpAxisEstimator {
 public:
  static constexpr std::size_t kLevels = 5;  // head, shoulders, hips, knees, feet
  // Points that are not finite, and arms, say nothing.
  void add(Joint joint, const Eigen::Vector3d& point_m);
  // Axis along which the person stands; nothing when neither is within 37 degrees, as of a person who lies,
  // or too little is known.
  std::optional<UpAxis> axis() const;

 private:
  struct Level {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double count = 0.0;
  };
  std::array<Level, kLevels> levels_;
};

// A point by name, and the assets of a file whose mean it is.
struct NamedPoint {
  std::string name;
  std::vector<std::string> assets;
};
// In a document an object: each name with its list of assets.
struct NamedPoints : std::vector<NamedPoint> {
  using std::vector<NamedPoint>::vector;
  void read(const Json& json, const JsonPlace& place, const About& about);
  Json json() const;
  static Json schema(const About& about);
};

// Which OptiTrack assets are which joint: the joint is the mean of the assets' positions. An asset is written
// as "name" or, where a name stands under two types, "type:name" (types: rigid_body, rigid_body_marker,
// marker, bone, bone_marker).
struct JointMapping {
  struct Entry {
    Joint joint;
    std::vector<std::string> assets;
  };
  struct Entries : std::vector<Entry> {
    using std::vector<Entry>::vector;
    void read(const Json& json, const JsonPlace& place, const About& about);
    Json json() const;
    static Json schema(const About& about);
  };
  Entries joints;

  static void fields(auto& self, auto&& f) {
    f.format("trilat.mapping");
    f("joints", self.joints,
      need("Joints, each with the assets whose mean it is; it is there only while all of them are"));
  }
};

// mapping.json, format 1: {"joints": {"head": ["head_1", …], …}}. Unknown joints are refused with those
// known.
JointMapping read_mapping(const std::filesystem::path& path);
std::string mapping_text(const JointMapping& mapping);
// Reads the mapping of a take without a session, whose points may have any name.
NamedPoints read_points(const std::filesystem::path& path);
void write_mapping(const std::filesystem::path& path, const JointMapping& mapping);

// Joints that another method or system gave of a take: a TRC, an OptiTrack CSV, or a CSV with the columns of
// `trilat fuse`. `method` names their rows in the tables. Times are seconds since the recording's start, or,
// without a session, of the mocap's clock; by motion where they have a clock of their own.
struct ExternalJoints {
  std::string method;
  std::filesystem::path file;
  NamedPoints mapping = {};  // empty: by the names in the file
  bool clock_by_motion = false;

  static void fields(auto& self, auto&& f) {
    f("method", self.method, need("Name of its rows in the tables"));
    f("file", self.file,
      need("TRC, OptiTrack CSV, or a CSV with time_s, joint, x_m, y_m, z_m (blank: missing)"));
    if (f.writes_if(!self.mapping.empty()))
      f("mapping", self.mapping,
        opt("Mapping of joints to the file's names; without it they are known by their names"));
    if (f.writes_if(self.clock_by_motion))
      f.named("clock", self.clock_by_motion, {"stated", "motion"},
              opt("Clock of its times. stated: seconds since the recording's first instant, or without a "
                  "session those of the motion capture; motion: found by the motion"));
  }
};

// One recorded take: a session, the calibration of its sensors, the OptiTrack export and what is what in it;
// `mocap` and `mapping` are empty where there is no export, `session` and `calibration` where all joints are
// brought. Paths are absolute or relative to the current directory once read.
struct Take {
  std::string id;
  std::string participant;
  std::string activity;
  std::filesystem::path session;
  std::filesystem::path calibration;
  std::filesystem::path mocap;
  std::filesystem::path mapping;
  // Mocap time of an instant = host time - this: the host clock's reading at the mocap's first frame, in ns.
  std::int64_t mocap_start_host_ns = 0;
  std::optional<UpAxis> up_axis = {};  // of the mocap's world; not stated: y
  std::vector<ExternalJoints> joints{};

  static void fields(Take& self, Fields& f);
  void check(const JsonPlace& place) const;
};

inline constexpr double kWandBallRadius_m = 0.075;
inline constexpr Range kBallRadius_m{0.01, 0.3};

// A recording of a wand that was held still at many places, and OptiTrack's export of it; a wand without an
// export gives poses in a frame of its own.
struct CampaignWand {
  std::filesystem::path session;
  std::filesystem::path mocap = {};
  std::string asset = {};  // whose position is the ball's centre
  std::int64_t mocap_start_host_ns = 0;
  double ball_radius_m = kWandBallRadius_m;

  static void fields(CampaignWand& self, Fields& f);
};

// A recording of a ball at places whose distance from a sensor was measured, as with a laser meter;
// `places` is a CSV that states them.
struct StatedDistances {
  std::filesystem::path session;
  std::filesystem::path places;
  double ball_radius_m = kWandBallRadius_m;

  static void fields(auto& self, auto&& f) {
    f("session", self.session, need("Recording in which the ball is held still at these places"));
    f("places", self.places,
      need("CSV with from_s and to_s (seconds since the first depth frame, while the ball is held), sensor, "
           "distance_m to the ball's centre, and angle_deg from the lens' axis where it is known"));
    f("ball_radius_m", self.ball_radius_m, opt("Radius of the ball", kBallRadius_m));
  }
};

// A recording of a flat wall that fills the sensors' images, and its distance from them where it was
// measured.
struct FlatWall {
  std::filesystem::path session;
  std::optional<double> distance_m = {};

  static void fields(auto& self, auto&& f) {
    f("session", self.session, need("Recording of a flat wall that fills the images"));
    f("distance_m", self.distance_m, opt("Distance from the sensors, where it was measured", {0.3, 8.0}));
  }
};

// A folder of takes, described by its campaign.json (format 1), where paths are relative to the folder.
struct Campaign {
  std::string name;
  bool simulated = false;
  std::vector<Take> takes;
  std::filesystem::path folder{};       // where it was read from
  std::filesystem::path calibration{};  // of all takes, where the user gave one instead of their own
  std::optional<CampaignWand> wand{};
  std::vector<StatedDistances> stated_distances{};
  std::vector<FlatWall> walls{};

  static void fields(auto& self, auto&& f) {
    f.format("trilat.campaign");
    f("name", self.name, need("Name of the campaign"));
    f("simulated", self.simulated, opt("Whether anything in it is simulated; every table says so"));
    f("takes", self.takes, need("Takes that were recorded").items(1));
    f("wand", self.wand, opt("Recording of a wand to calibrate with"));
    if (f.writes_if(!self.stated_distances.empty()))
      f("stated_distances", self.stated_distances, opt("Recordings of a ball at measured distances"));
    if (f.writes_if(!self.walls.empty())) f("walls", self.walls, opt("Recordings of a flat wall"));
  }
  void check(const JsonPlace& place) const;
};

// `path` is the folder or its campaign.json. Take ids must be unique and usable as names.
Campaign read_campaign(const std::filesystem::path& path);
Campaign parse_campaign(const Json& json, const std::filesystem::path& file);

// Sentences on names that look like one and count as two: participants and activities that differ in case,
// blanks or punctuation alone, as "p01" and "P-01". Punctuation between digits tells names apart.
std::vector<std::string> suspicious_names(const Campaign& campaign);
// Writes paths relative to `folder`, whatever they are.
void write_campaign(const std::filesystem::path& folder, Campaign campaign);

}  // namespace trilat
