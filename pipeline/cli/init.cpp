// SPDX-License-Identifier: MIT
// `trilat init`.
#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/base/words.h"
#include "datasets/mocap/read_mocap.h"
#include "pipeline/accuracy/proposals.h"
#include "pipeline/cli/find_takes.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

struct InitArguments {
  fs::path folder = ".";
  std::string name, activity;
  double start_within_s = 150.0;
  std::string up_axis;       // of the motion capture: y, z, or empty
  fs::path propose_mapping;  // of this motion capture, and nothing else; empty: the folder
  bool force = false;
  bool json = false;
};

// Takes that were found, and the proposed mapping, which is empty where the folder has a mapping already or
// no take has motion capture.
struct Found : FoundTakes {
  JointMapping mapping;
};

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

// Adds what was found to the campaign and writes it; its names are read again, so that one that cannot be is
// refused.
void write_found(const InitArguments& arguments, const Found& found, Campaign campaign) {
  const Campaign& other = found.calibration;
  if (!campaign.wand) campaign.wand = other.wand;
  campaign.stated_distances.insert(campaign.stated_distances.end(), other.stated_distances.begin(),
                                   other.stated_distances.end());
  campaign.walls.insert(campaign.walls.end(), other.walls.begin(), other.walls.end());
  campaign.simulated |= std::ranges::any_of(found.takes, &FoundTake::simulated);
  for (const FoundTake& f : found.takes) campaign.takes.push_back(f.take);
  if (found.takes.empty() && !other.wand && other.stated_distances.empty() && other.walls.empty()) return;
  write_campaign(arguments.folder, campaign);
  read_campaign(arguments.folder);
}

// Writes mapping.json, and removes it again where the starts cannot be found.
void find_mapping_and_starts(const InitArguments& arguments, Found& found) {
  const fs::path file = arguments.folder / "mapping.json";
  add_mapping(arguments, found);
  if (!found.mapping.joints.empty()) write_mapping(file, found.mapping);
  try {
    find_starts(arguments, found);
  } catch (...) {
    if (!found.mapping.joints.empty()) fs::remove(file);
    throw;
  }
}

void print_found(const InitArguments& arguments, const Found& found, const std::string& folder) {
  for (const auto& [take, sensors, simulated, start] : found.takes)
    fmt::print("{}: {} of {}, {} sensors{}\n", take.id, take.activity, take.participant, sensors,
               take.mocap.empty() ? ", no motion capture: each sensor is predicted from the others"
                                  : fmt::format("; {} {}", take.mocap.filename().string(), start));
  if (!found.mapping.joints.empty())
    fmt::print(
        "mapping.json: {} joints by the names of the first export; look at it: a bone gives its upper joint, "
        "a marker lies on the skin\n",
        found.mapping.joints.size());
  if (std::ranges::any_of(found.takes, [](const FoundTake& f) { return !f.start.empty(); }))
    fmt::print(
        "A start by the motion contains the trackers' lag, some 0.05 s: errors by that lag are not seen.\n");
  for (const std::string& note : found.notes) fmt::print(stderr, "note: {}\n", note);
  fmt::print("next: trilat run {} --campaign {} -o {}\n", shell_word(folder + "/study.json"),
             shell_word(folder), shell_word((folder == "." ? arguments.name : folder) + "-results"));
}

void print_found_json(const Found& found) {
  Json takes = Json::array();
  for (const auto& [take, sensors, simulated, start] : found.takes)
    takes.push_back(
        {{"id", take.id}, {"sensors", sensors}, {"mocap", take.mocap.string()}, {"start", start}});
  fmt::print("{}\n", json_text(Json{{"takes", takes}, {"notes", found.notes}}, 2));
}

int init(const InitArguments& given) {
  InitArguments arguments = given;
  if (!arguments.propose_mapping.empty()) return print_mapping(arguments.propose_mapping);
  if (!fs::is_directory(arguments.folder))
    throw InputError(arguments.folder.string(), "must be the folder that holds the recordings");
  if (arguments.name.empty()) arguments.name = fs::canonical(arguments.folder).filename().string();
  Campaign campaign;
  campaign.name = arguments.name;
  const fs::path file = arguments.folder / "campaign.json";
  if (fs::exists(file) && !arguments.force) campaign = read_campaign(arguments.folder);
  Found found{find_takes({arguments.folder, arguments.activity, arguments.up_axis}, campaign), {}};
  Json paths = Json::array();
  for (const FoundTake& f : found.takes) paths.push_back(f.take.session.string());
  utf8_json_text(paths, 0);  // refuses names before anything is written
  find_mapping_and_starts(arguments, found);
  write_found(arguments, found, campaign);
  write_study(arguments, found);
  if (const std::size_t known = campaign.takes.size(); known > 0)
    found.notes.push_back(fmt::format("{}: has {} takes from before, which stay as they are; {} are new",
                                      file.string(), known, found.takes.size()));
  if (arguments.json)
    print_found_json(found);
  else
    print_found(arguments, found, (given.folder / "").parent_path().string());
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
  verb.add_option("--activity", a.activity,
                  "what is done in recordings that are called session.h5; else recorded, or simulated");
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
