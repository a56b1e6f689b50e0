// SPDX-License-Identifier: MIT
// `trilat init`.
#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/known_names.h"
#include "datasets/base/text_output.h"
#include "datasets/mocap/read_mocap.h"
#include "datasets/session/session_reader.h"
#include "pipeline/accuracy/external/external_joints.h"
#include "pipeline/accuracy/proposals.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

struct InitArguments {
  fs::path folder = ".";
  std::string name, activity = "recorded";
  double start_within_s = 150.0;
  std::string up_axis;       // of the motion capture: y, z, or empty
  fs::path propose_mapping;  // of this motion capture, and nothing else; empty: the folder
  bool force = false;
  bool json = false;
};

// A take and its notes.
struct FoundTake {
  Take take;
  std::size_t sensors = 0;
  bool simulated = false;
  std::string start = {};  // how its mocap's start was found
};

// A name as an id of a take: letters and digits of ASCII, '-' and '.'; '_' for any other character.
std::string plain_id(const std::string& name) {
  constexpr std::size_t kMaxLength = 90;  // of 100, with room for a number behind it
  std::string id;
  for (const char c : name) {
    const bool goes_on = (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;  // of a character of UTF-8
    if (goes_on || id.size() == kMaxLength) continue;
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.';
    id += plain && !(id.empty() && c == '.') ? c : '_';
  }
  return id;
}

// Two names may give one id: "Müller" and "Möller". `taken`: ids that are there already.
void number_equal_ids(std::vector<FoundTake>& takes, std::set<std::string> taken,
                      std::vector<std::string>& notes) {
  for (FoundTake& found : takes) {
    const std::string id = found.take.id;
    for (int number = 2; !taken.insert(found.take.id).second; ++number)
      found.take.id = fmt::format("{}-{}", id, number);
    if (found.take.id != id)
      notes.push_back(fmt::format("{}: is called {}, since another take is {} already",
                                  found.take.session.string(), found.take.id, id));
  }
}

struct Found {
  std::vector<FoundTake> takes;
  std::vector<std::string> notes;
  Campaign calibration = {};  // its wand, stated distances and walls
  JointMapping mapping;       // empty where one is there already, or no take has mocap
};

// The nearest one, from the recording's folder up to the campaign's.
fs::path nearest_file(const std::string& name, fs::path from, const fs::path& top) {
  for (;; from = from.parent_path()) {
    if (fs::exists(from / name)) return from / name;
    if (from == top || from.empty() || from == from.parent_path()) return {};
  }
}

// InputError for one that begins as a motion capture and cannot be read: passed over, its take would be
// evaluated without it.
bool is_mocap(const fs::path& file) {
  if (!std::set<std::string>{".csv", ".trc", ".c3d"}.contains(file.extension().string())) return false;
  return is_mocap_file(file) && !read_mocap_header(file).assets.empty();
}

// A table beside a recording that is in no format that is read.
void note_unread(const fs::path& file, Found& found) {
  if (!std::set<std::string>{".csv", ".trc", ".tsv", ".c3d"}.contains(file.extension().string())) return;
  try {
    if (!is_joint_csv(file)) read_mocap_header(file);
  } catch (const InputError& error) {
    const std::string text = fmt::format("left out, no motion capture: {}", error.what());
    if (std::ranges::find(found.notes, text) == found.notes.end()) found.notes.push_back(text);
  }
}

// The motion capture beside a recording: of the same name, else the one called mocap, else the only one
// beside the only recording.
fs::path mocap_beside(const fs::path& session, const std::vector<fs::path>& sessions, Found& found) {
  std::vector<fs::path> all;
  for (const auto& file : fs::directory_iterator(session.parent_path()))
    if (is_mocap(file.path()))
      all.push_back(file.path());
    else
      note_unread(file.path(), found);
  std::ranges::sort(all);
  for (const fs::path& stem : {session.stem(), fs::path("mocap")})
    if (const auto one = std::ranges::find(all, stem, &fs::path::stem); one != all.end()) return *one;
  if (all.empty()) return {};
  // beside OptiTrack's own export a TRC is what another method gave
  if (all.size() > 1) std::erase_if(all, [](const fs::path& file) { return file.extension() == ".trc"; });
  if (all.size() == 1 && std::ranges::count(sessions, session.parent_path(), &fs::path::parent_path) == 1)
    return all.front();
  found.notes.push_back(fmt::format("{}: which motion capture belongs to it is not clear; call it {}{}",
                                    session.string(), session.stem().string(),
                                    all.front().extension().string()));
  return {};
}

// Joints that other methods gave of the only recording of a folder, with the joints of their names: any other
// TRC, export or CSV of joints beside its motion capture.
std::vector<ExternalJoints> joints_beside(const Take& take, const std::vector<fs::path>& sessions) {
  std::vector<ExternalJoints> joints;
  const fs::path folder = take.session.parent_path();
  if (take.mocap.empty() || std::ranges::count(sessions, folder, &fs::path::parent_path) != 1) return joints;
  std::vector<fs::path> files;
  for (const auto& file : fs::directory_iterator(folder))
    if (file.is_regular_file() && file.path() != take.mocap &&
        (is_mocap(file.path()) || (file.path().extension() == ".csv" && is_joint_csv(file.path()))))
      files.push_back(file.path());
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    joints.push_back({file.stem().string(), file});
    for (const JointMapping::Entry& entry : propose_mapping(read_marker_header(file)).joints)
      joints.back().mapping.push_back({std::string(name_of(entry.joint)), entry.assets});
    if (joints.back().mapping.empty()) joints.pop_back();
  }
  return joints;
}

// "p01/walk.h5" is p01's walk; "p01/session.h5", of a participant who has one, has no name of its own.
FoundTake take_of(const SessionReader& reader, const fs::path& session, const InitArguments& arguments) {
  const fs::path inside = fs::relative(session, arguments.folder);
  const std::string stem = session.stem().string();
  const bool has_folder = inside.has_parent_path(), has_name = stem != "session";
  FoundTake found;
  found.take.participant = has_folder ? inside.begin()->string() : stem;
  found.take.activity = has_folder && has_name ? stem : arguments.activity;
  fs::path id = has_name ? fs::path(inside).replace_extension() : inside.parent_path();
  found.take.id = fmt::format("{}", fmt::join(std::vector<std::string>(id.begin(), id.end()), "-"));
  found.take.id = plain_id(found.take.id.empty() ? stem : found.take.id);
  found.take.session = session;
  found.sensors = reader.header().sensors.size();
  found.simulated = reader.header().simulated;
  return found;
}

// `known`: the campaign as it is, whose recordings stay as they are.
Found look_around(const InitArguments& arguments, const Campaign& known) {
  Found found;
  std::vector<fs::path> sessions, new_sessions;
  std::map<fs::path, FoundTake> takes;
  std::set<fs::path> known_sessions;
  std::set<std::string> known_ids;
  for (const Take& take : known.takes) {
    known_sessions.insert(fs::weakly_canonical(take.session));
    known_ids.insert(take.id);
  }
  std::set<fs::path> known_calibration;
  if (known.wand) known_calibration.insert(fs::weakly_canonical(known.wand->session));
  for (const StatedDistances& stated : known.stated_distances)
    known_calibration.insert(fs::weakly_canonical(stated.session));
  for (const FlatWall& wall : known.walls) known_calibration.insert(fs::weakly_canonical(wall.session));
  for (const fs::path& file : files_below(arguments.folder, {".h5"})) try {
      const SessionReader reader(file);
      const fs::path canonical = fs::weakly_canonical(file);
      if (known_calibration.contains(canonical)) continue;
      if (!known_sessions.contains(canonical) && add_calibration_recording(file, found.calibration)) {
        found.notes.push_back(fmt::format(
            "{}: a recording to calibrate by, by its name, and not a take; rename it if it is one",
            file.string()));
        continue;
      }
      takes.emplace(file, take_of(reader, file, arguments));
      sessions.push_back(file);
      if (!known_sessions.contains(fs::weakly_canonical(file))) new_sessions.push_back(file);
    } catch (const InputError& error) {
      found.notes.push_back(fmt::format("left out, no recording: {}", error.what()));
    }
  const Campaign& other = found.calibration;
  if (sessions.empty() && (other.wand || !other.stated_distances.empty() || !other.walls.empty()))
    throw InputError(
        arguments.folder.string(),
        fmt::format("holds recordings to calibrate by, and no take; `trilat run calibration --campaign {} "
                    "-o RESULTS` evaluates them as they are",
                    shell_word(arguments.folder.string())));
  if (sessions.empty())
    throw InputError(arguments.folder.string(),
                     "holds no recording (session.h5); `trilat record` makes one, and python3 -m "
                     "trilat.convert one of somebody else's");
  for (const fs::path& session : new_sessions) {
    Take& take = takes.at(session).take;
    take.calibration = nearest_file("calibration.json", session.parent_path(), arguments.folder);
    if (take.calibration.empty())
      throw InputError(session.string(),
                       fmt::format("has no calibration.json in its folder or above; `trilat calibrate {} "
                                   "--method bodies -o {}` makes one from a walk for all recordings of this "
                                   "rig, docs/how-to/calibrate.md has better ones",
                                   session.string(), (arguments.folder / "calibration.json").string()));
    take.mocap = mocap_beside(session, sessions, found);
    take.joints = joints_beside(take, sessions);
    if (!take.joints.empty()) {
      std::string names;
      for (const ExternalJoints& joints : take.joints) names += (names.empty() ? "" : ", ") + joints.method;
      found.notes.push_back(
          fmt::format("{}: beside it lie joints of {}, which are compared, too: seconds since the "
                      "recording's start, in the calibration's world",
                      session.string(), names));
    }
    if (!take.mocap.empty()) {
      take.mapping = arguments.folder / "mapping.json";
      if (!arguments.up_axis.empty()) take.up_axis = arguments.up_axis == "z" ? UpAxis::z : UpAxis::y;
    }
    found.takes.push_back(takes.at(session));
  }
  number_equal_ids(found.takes, known_ids, found.notes);
  const auto in_top = [&](const fs::path& session) { return session.parent_path() == arguments.folder; };
  if (known.takes.empty() && std::ranges::count_if(sessions, in_top) > 1)
    found.notes.push_back(
        fmt::format("{}: its recordings lie in one folder, so each is taken for another participant, called "
                    "as the file is; if one person made several, give each participant a folder",
                    arguments.folder.string()));
  return found;
}

// Proposes one where there is none. InputError when the export's names do not tell the joints.
void add_mapping(const InitArguments& arguments, Found& found) {
  const fs::path file = arguments.folder / "mapping.json";
  const auto with_mocap =
      std::ranges::find_if(found.takes, [](const FoundTake& f) { return !f.take.mocap.empty(); });
  if (fs::exists(file) || with_mocap == found.takes.end()) return;
  const fs::path mocap = with_mocap->take.mocap;
  found.mapping = propose_mapping(read_mocap_header(mocap));
  if (!found.mapping.joints.empty()) return;
  throw InputError(mocap.string(),
                   "has no names that tell which joint is which; write " + file.string() +
                       " (docs/how-to/own_recordings.md; `trilat info` lists the names) and ask again");
}

// States "up_axis": "z" in the take where its person stands along z.
MocapStart start_of(Take& take, const InitArguments& arguments) {
  try {
    return find_mocap_start(take, arguments.start_within_s, {stop_requested, {}});
  } catch (const InputError& error) {
    if (error.problem() != kStandsAlongZ) throw;
    take.up_axis = UpAxis::z;
    return find_mocap_start(take, arguments.start_within_s, {stop_requested, {}});
  }
}

void find_starts(const InitArguments& arguments, Found& found) {
  Progress progress("finding when the motion capture starts");
  for (std::size_t k = 0; k < found.takes.size(); ++k) {
    progress.set(static_cast<double>(k) / static_cast<double>(found.takes.size()));
    Take& take = found.takes[k].take;
    if (take.mocap.empty()) continue;
    const MocapStart start = start_of(take, arguments);
    if (start.status == "found") {
      take.mocap_start_host_ns = start.host_ns;
      const bool before = start.after_recording_s < 0.0;
      const double after = before ? -1.0 : 1.0;
      found.takes[k].start = fmt::format("starts {:.3f} s {} the recording ({:.3f} to {:.3f}), by the motion",
                                         after * start.after_recording_s, before ? "before" : "after",
                                         after * (before ? start.high_s : start.low_s),
                                         after * (before ? start.low_s : start.high_s));
    } else {
      take.mocap.clear();
      take.mapping.clear();
      const std::string advice =
          start.status == "ambiguous"
              ? "state with --start-within-s how far apart both began at most"
              : "or give \"mocap\", \"mapping\" and \"mocap_start_host_ns\" in campaign.json by hand";
      found.notes.push_back(fmt::format(
          "{}: its motion capture is left out, since the motion does not show when it starts ({}): {}; {}",
          take.id, start.status, start.cause, advice));
    }
  }
}

// Alignments of the studies that init writes.
enum Placing { kNoMocap, kInMocapWorld, kInOtherWorld };
const std::array<std::vector<std::string>, 3> kAlignments{
    {{"none"}, {"none", "joint_offset", "rigid"}, {"rigid"}}};

Json made_study(const std::string& name, Placing placing, bool has_three_sensors) {
  Json methods = Json::array();
  if (has_three_sensors)
    for (const char* method : {"linear", "geometric", "nonlinear"}) methods.push_back({{"method", method}});
  for (const char* method : {"single", "mean", "median", "range_bearing", "rts", "window"})
    methods.push_back({{"method", method}});
  return {{"format", "trilat.study"},
          {"version", 1},
          {"kind", "accuracy"},
          {"name", name},
          {"alignments", kAlignments.at(placing)},
          {"reference", has_three_sensors ? "nonlinear" : "mean"},
          {"methods", methods}};
}

Json study_of(const InitArguments& arguments, const Found& found) {
  const auto with_mocap = [](const FoundTake& f) { return !f.take.mocap.empty(); };
  const bool all_three = std::ranges::all_of(found.takes, [](const FoundTake& f) { return f.sensors >= 3; });
  const bool all_placed = std::ranges::all_of(
      found.takes, [&](const FoundTake& f) { return !with_mocap(f) || is_in_mocap_world(f.take); });
  return made_study(arguments.name,
                    std::ranges::none_of(found.takes, with_mocap) ? kNoMocap
                    : all_placed                                  ? kInMocapWorld
                                                                  : kInOtherWorld,
                    all_three);
}

// Whether a study is one that init writes, so that it was not edited.
bool is_made(const Json& study) {
  const std::string name = study.is_object() && study.contains("name") && study["name"].is_string()
                               ? study["name"].get<std::string>()
                               : "";
  for (const Placing placing : {kNoMocap, kInMocapWorld, kInOtherWorld})
    for (const bool has_three_sensors : {false, true})
      if (study == made_study(name, placing, has_three_sensors)) return true;
  return false;
}

// Keeps a study that somebody has edited.
void write_study(const InitArguments& arguments, Found& found) {
  const fs::path file = arguments.folder / "study.json";
  if (found.takes.empty() && fs::exists(file)) return;
  if (!fs::exists(file) || is_made(parse_json(read_file(file), file.string())))
    write_file(file, json_text(study_of(arguments, found), 2) + "\n");
  else
    found.notes.push_back(file.string() +
                          ": differs from what init writes, and is kept; delete it for a new one");
}

// Prints mapping.json, and on stderr which joints are not in it.
int print_mapping(const std::filesystem::path& file) {
  const JointMapping mapping = propose_mapping(read_mocap_header(file));
  if (mapping.joints.empty())
    throw InputError(file.string(),
                     "has no names that tell which joint is which; write mapping.json by hand "
                     "(docs/how-to/own_recordings.md)");
  fmt::print("{}\n", mapping_text(mapping));
  std::vector<std::string> left = joint_names();
  for (const auto& entry : mapping.joints) std::erase(left, name_of(entry.joint));
  fmt::print(stderr,
             "{} joints by their names; look at them: a bone gives its upper joint, a marker lies on the "
             "skin. Without a name that is known: {}\n",
             mapping.joints.size(), join_names(left));
  return kDone;
}

int init(const InitArguments& given) {
  InitArguments arguments = given;
  if (!arguments.propose_mapping.empty()) return print_mapping(arguments.propose_mapping);
  if (!fs::is_directory(arguments.folder))
    throw InputError(arguments.folder.string(), "must be the folder that holds the recordings");
  if (arguments.name.empty()) arguments.name = fs::canonical(arguments.folder).filename().string();
  Campaign campaign;
  campaign.name = arguments.name;
  if (fs::exists(arguments.folder / "campaign.json") && !arguments.force)
    campaign = read_campaign(arguments.folder);
  const std::size_t known = campaign.takes.size();
  Found found = look_around(arguments, campaign);
  Json paths = Json::array();
  for (const FoundTake& f : found.takes) paths.push_back(f.take.session.string());
  utf8_json_text(paths, 0);  // before anything is written
  add_mapping(arguments, found);
  const fs::path mapping = arguments.folder / "mapping.json";
  if (!found.mapping.joints.empty()) write_mapping(mapping, found.mapping);
  try {
    find_starts(arguments, found);
  } catch (...) {
    if (!found.mapping.joints.empty()) fs::remove(mapping);  // nothing is left of what did not work out
    throw;
  }
  const Campaign& other = found.calibration;
  if (!campaign.wand) campaign.wand = other.wand;
  campaign.stated_distances.insert(campaign.stated_distances.end(), other.stated_distances.begin(),
                                   other.stated_distances.end());
  campaign.walls.insert(campaign.walls.end(), other.walls.begin(), other.walls.end());
  campaign.simulated |= std::ranges::any_of(found.takes, &FoundTake::simulated);
  for (const FoundTake& f : found.takes) campaign.takes.push_back(f.take);
  if (!found.takes.empty() || other.wand || !other.stated_distances.empty() || !other.walls.empty()) {
    write_campaign(arguments.folder, campaign);
    read_campaign(arguments.folder);  // says what of the names cannot be
  }
  write_study(arguments, found);
  if (known > 0)
    found.notes.push_back(fmt::format("{}: has {} takes from before, which stay as they are; {} are new",
                                      (arguments.folder / "campaign.json").string(), known,
                                      found.takes.size()));
  Json takes = Json::array();
  for (const auto& [take, sensors, simulated, start] : found.takes)
    takes.push_back(
        {{"id", take.id}, {"sensors", sensors}, {"mocap", take.mocap.string()}, {"start", start}});
  if (arguments.json) {
    fmt::print("{}\n", json_text(Json{{"takes", takes}, {"notes", found.notes}}, 2));
    return kDone;
  }
  for (const auto& [take, sensors, simulated, start] : found.takes)
    fmt::print("{}: {} of {}, {} sensors{}\n", take.id, take.activity, take.participant, sensors,
               take.mocap.empty() ? ", no motion capture: each sensor is predicted from the others"
                                  : fmt::format("; {} {}", take.mocap.filename().string(), start));
  if (!found.mapping.joints.empty()) {
    fmt::print(
        "mapping.json: {} joints by the names of the first export; look at it: a bone gives its upper joint, "
        "a marker lies on the skin\n",
        found.mapping.joints.size());
  }
  if (std::ranges::any_of(found.takes, [](const FoundTake& f) { return !f.start.empty(); }))
    fmt::print(
        "A start by the motion contains the trackers' lag, some 0.05 s: errors by that lag are not seen.\n");
  for (const std::string& note : found.notes) fmt::print(stderr, "note: {}\n", note);
  const std::string folder = (given.folder / "").parent_path().string();
  fmt::print("next: trilat run {} --campaign {} -o {}\n", shell_word(folder + "/study.json"),
             shell_word(folder), shell_word((folder == "." ? arguments.name : folder) + "-results"));
  return kDone;
}

}  // namespace

void add_init(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<InitArguments>(
      app, code, "init",
      "a folder of own recordings -> campaign.json, mapping.json and study.json, with what the motion tells",
      init);
  verb.add_option("folder", a.folder, "with recordings, calibration.json and motion capture beside them")
      ->capture_default_str();
  verb.add_option("--name", a.name, "of the campaign; else the folder's");
  verb.add_option("--activity", a.activity, "what is done in recordings that are called session.h5")
      ->capture_default_str();
  verb.add_option("--start-within-s", a.start_within_s,
                  "how far apart a recording and its motion capture began at most")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  verb.add_option("--up-axis", a.up_axis,
                  "of the motion capture's world; else y, or z where the person stands along it")
      ->check(CLI::IsMember({"y", "z"}));
  verb.add_option("--propose-mapping", a.propose_mapping,
                  "of this motion capture alone: print a mapping.json by the names of bones and markers");
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
