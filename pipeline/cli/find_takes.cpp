// SPDX-License-Identifier: MIT
#include "pipeline/cli/find_takes.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/text_output.h"
#include "datasets/mocap/read_mocap.h"
#include "datasets/rig/calibration.h"
#include "datasets/session/session_reader.h"
#include "pipeline/accuracy/external/external_joints.h"
#include "pipeline/accuracy/proposals.h"
#include "pipeline/cli/kinds.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

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
  if (!std::set<std::string>{".csv", ".trc", ".c3d"}.contains(lower_extension(file))) return false;
  return is_mocap_file(file) && !read_mocap_header(file).assets.empty();
}

// A table beside a recording that is in no format that is read.
void note_unread(const fs::path& file, FoundTakes& found) {
  if (!std::set<std::string>{".csv", ".trc", ".tsv", ".c3d"}.contains(lower_extension(file))) return;
  try {
    if (!is_joint_csv(file)) read_mocap_header(file);
  } catch (const InputError& error) {
    const std::string text = fmt::format("left out, no motion capture: {}", error.what());
    if (std::ranges::find(found.notes, text) == found.notes.end()) found.notes.push_back(text);
  }
}

bool is_trc(const fs::path& file) { return lower_extension(file) == ".trc"; }

// The only motion capture of a recording's name in another folder, as where recordings and motion capture
// have a folder each.
fs::path mocap_elsewhere(const fs::path& session, FoundTakes& found) {
  std::vector<fs::path> named;
  for (const fs::path& file : found.mocap_apart)
    if (file.stem() == session.stem()) named.push_back(file);
  if (named.size() > 1) std::erase_if(named, is_trc);
  if (named.size() != 1) return {};
  std::erase(found.mocap_apart, named.front());
  found.notes.push_back(
      fmt::format("{}: its motion capture is {}, by its name", session.string(), named.front().string()));
  return named.front();
}

// The motion capture beside a recording: of the same name, else the one called mocap, else the only one
// beside the only recording.
fs::path mocap_beside(const fs::path& session, const std::vector<fs::path>& sessions, FoundTakes& found) {
  std::vector<fs::path> all;
  for (const auto& file : fs::directory_iterator(session.parent_path()))
    if (is_mocap(file.path()))
      all.push_back(file.path());
    else
      note_unread(file.path(), found);
  std::ranges::sort(all);
  for (const fs::path& stem : {session.stem(), fs::path("mocap")})
    if (const auto one = std::ranges::find(all, stem, &fs::path::stem); one != all.end()) return *one;
  if (all.empty()) return mocap_elsewhere(session, found);
  // beside OptiTrack's own export a TRC is what another method gave
  if (all.size() > 1) std::erase_if(all, is_trc);
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
        (is_mocap(file.path()) || (lower_extension(file.path()) == ".csv" && is_joint_csv(file.path()))))
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
FoundTake take_of(const SessionReader& reader, const fs::path& session, const TakeSearch& search) {
  const fs::path inside = fs::relative(session, search.folder);
  const std::string stem = session.stem().string();
  const bool has_folder = inside.has_parent_path(), has_name = stem != "session";
  FoundTake found;
  found.take.participant = has_folder ? inside.begin()->string() : stem;
  const std::string activity = reader.header().simulated ? "simulated" : "recorded";
  found.take.activity = has_folder && has_name ? stem : search.activity.empty() ? activity : search.activity;
  fs::path id = has_name ? fs::path(inside).replace_extension() : inside.parent_path();
  found.take.id = fmt::format("{}", fmt::join(std::vector<std::string>(id.begin(), id.end()), "-"));
  found.take.id = plain_id(found.take.id.empty() ? stem : found.take.id);
  found.take.session = session;
  found.sensors = reader.header().sensors.size();
  found.simulated = reader.header().simulated;
  return found;
}

// Recordings that the campaign has already, as canonical paths.
std::set<fs::path> sessions_of(const Campaign& known) {
  std::set<fs::path> sessions;
  for (const Take& take : known.takes) sessions.insert(fs::weakly_canonical(take.session));
  return sessions;
}
std::set<fs::path> calibration_sessions_of(const Campaign& known) {
  std::set<fs::path> sessions;
  if (known.wand) sessions.insert(fs::weakly_canonical(known.wand->session));
  for (const StatedDistances& stated : known.stated_distances)
    sessions.insert(fs::weakly_canonical(stated.session));
  for (const FlatWall& wall : known.walls) sessions.insert(fs::weakly_canonical(wall.session));
  return sessions;
}

// All recordings of takes below the folder; those that are not in the campaign become takes.
std::vector<fs::path> find_sessions(const TakeSearch& search, const Campaign& known, FoundTakes& found) {
  const std::set<fs::path> known_sessions = sessions_of(known), calibrations = calibration_sessions_of(known);
  std::vector<fs::path> sessions;
  for (const fs::path& file : files_below(search.folder, kSessionEndings)) try {
      const SessionReader reader(file);
      const fs::path canonical = fs::weakly_canonical(file);
      const bool is_known = known_sessions.contains(canonical);
      if (calibrations.contains(canonical)) continue;
      if (!is_known && add_calibration_recording(file, found.calibration)) {
        found.notes.push_back(fmt::format(
            "{}: a recording to calibrate by, by its name, and not a take; rename it if it is one",
            file.string()));
        continue;
      }
      sessions.push_back(file);
      if (!is_known) found.takes.push_back(take_of(reader, file, search));
    } catch (const InputError& error) {
      found.unread.emplace_back(error.what());
      found.notes.push_back(fmt::format("left out, no recording: {}", error.what()));
    }
  return sessions;
}

// Motion capture in folders without a recording.
std::vector<fs::path> mocap_apart_from(const std::vector<fs::path>& sessions, const fs::path& folder) {
  std::vector<fs::path> apart;
  for (const fs::path& file : files_below(folder, {".csv", ".trc"})) try {
      const bool is_beside = std::ranges::count(sessions, file.parent_path(), &fs::path::parent_path) > 0;
      if (!is_beside && is_mocap(file)) apart.push_back(file);
    } catch (const InputError&) {  // no recording asks for it
    }
  return apart;
}

[[noreturn]] void refuse_without_sessions(const fs::path& folder, const FoundTakes& found) {
  const Campaign& calibration = found.calibration;
  if (!found.unread.empty())
    throw InputError(folder.string(), "holds no recording that can be read: " + found.unread.front());
  if (calibration.wand || !calibration.stated_distances.empty() || !calibration.walls.empty())
    throw InputError(
        folder.string(),
        fmt::format("holds recordings to calibrate by, and no take; `trilat run calibration --campaign {} "
                    "-o RESULTS` evaluates them as they are",
                    shell_word(folder.string())));
  throw InputError(folder.string(),
                   "holds no recording (session.h5); `trilat record` makes one, and python3 -m "
                   "trilat.convert one of somebody else's");
}

// The calibrations by other names below a folder, as a text that says what to do; empty without any.
std::string other_calibrations(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::path& file : files_below(folder, {".json"})) try {
      read_calibration(file);
      names.push_back(fs::relative(file, folder).string());
    } catch (const InputError&) {
    }
  if (names.empty()) return {};
  return fmt::format("{} {}: call the one of this rig calibration.json", fmt::join(names, " and "),
                     names.size() == 1 ? "is a calibration" : "are calibrations");
}

// Adds to a take what lies beside its recording.
void add_files_beside(Take& take, const TakeSearch& search, const std::vector<fs::path>& sessions,
                      FoundTakes& found) {
  const std::string session = take.session.string();
  take.calibration = nearest_file("calibration.json", take.session.parent_path(), search.folder);
  if (take.calibration.empty())
    if (const std::string others = other_calibrations(search.folder); !others.empty())
      throw InputError(session, "has no calibration.json in its folder or above; " + others);
  if (take.calibration.empty())
    throw InputError(session,
                     fmt::format("has no calibration.json in its folder or above; `trilat calibrate {} "
                                 "--method bodies -o {}` makes one from a walk for all recordings of this "
                                 "rig, docs/how-to/calibrate.md has better ones",
                                 session, (search.folder / "calibration.json").string()));
  take.mocap = mocap_beside(take.session, sessions, found);
  take.joints = joints_beside(take, sessions);
  if (!take.joints.empty()) {
    std::vector<std::string> names;
    for (const ExternalJoints& joints : take.joints) names.push_back(joints.method);
    found.notes.push_back(
        fmt::format("{}: beside it lie joints of {}, which are compared, too: seconds since the "
                    "recording's start, in the calibration's world",
                    session, fmt::join(names, ", ")));
  }
  if (take.mocap.empty()) return;
  take.mapping = search.folder / "mapping.json";
  if (!search.up_axis.empty()) take.up_axis = search.up_axis == "z" ? UpAxis::z : UpAxis::y;
}

}  // namespace

FoundTakes find_takes(const TakeSearch& search, const Campaign& known) {
  FoundTakes found;
  const std::vector<fs::path> sessions = find_sessions(search, known, found);
  if (sessions.empty()) refuse_without_sessions(search.folder, found);
  found.mocap_apart = mocap_apart_from(sessions, search.folder);
  for (FoundTake& one : found.takes) add_files_beside(one.take, search, sessions, found);
  for (const Take& take : known.takes)
    std::erase_if(found.mocap_apart, [&](const fs::path& file) {
      return fs::weakly_canonical(file) == fs::weakly_canonical(take.mocap);
    });
  if (!found.mocap_apart.empty())
    found.notes.push_back(fmt::format(
        "{}{}: motion capture of no recording; put it beside its recording, or give it the recording's name",
        found.mocap_apart.front().string(),
        found.mocap_apart.size() == 1 ? "" : fmt::format(" and {} more", found.mocap_apart.size() - 1)));
  std::set<std::string> known_ids;
  for (const Take& take : known.takes) known_ids.insert(take.id);
  number_equal_ids(found.takes, known_ids, found.notes);
  const auto participant_of = [](const FoundTake& one) { return one.take.participant; };
  std::set<std::string> participants;
  std::ranges::transform(found.takes, std::inserter(participants, participants.end()), participant_of);
  if (known.takes.empty() && found.takes.size() > 1 && participants.size() == 1)
    found.notes.push_back(fmt::format(
        "{}: all recordings lie in {}, so one participant made them; if several people did, give each a "
        "folder",
        search.folder.string(), *participants.begin()));
  const auto in_top = [&](const fs::path& session) { return session.parent_path() == search.folder; };
  if (known.takes.empty() && std::ranges::count_if(sessions, in_top) > 1)
    found.notes.push_back(
        fmt::format("{}: its recordings lie in one folder, so each is taken for another participant, called "
                    "as the file is; if one person made several, give each participant a folder",
                    search.folder.string()));
  return found;
}

}  // namespace trilat
