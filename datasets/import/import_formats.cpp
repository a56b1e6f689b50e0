// SPDX-License-Identifier: MIT
#include "datasets/import/import_formats.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/import/import_body_files.h"
#include "datasets/import/import_png.h"
#include "datasets/import/import_xef.h"
#include "datasets/import/joint_row_reader.h"
#include "datasets/import/kimore_reader.h"
#include "datasets/import/node_kinect2_reader.h"
#include "datasets/import/ntu_reader.h"

namespace trilat {
namespace {

using Files = std::vector<std::filesystem::path>;

void need_one(const Files& files, const std::string& why) {
  if (files.size() != 1)
    throw InputError(files.empty() ? "FILE" : files[1].string(), files.empty() ? "is missing" : why);
}

void refuse_rate(const ImportOptions& options) {
  if (options.rate_hz) throw InputError("--rate-hz", "is not for this format, whose files have time stamps");
}

// One file of JointRowReader.
ImportReport import_joint_rows(const char* name, const char* assumed, const JointRowFormat& rows,
                               const Files& files, const std::filesystem::path& output,
                               const ImportOptions& options) {
  need_one(files, "is a second file; these files share no clock, so each becomes a session of its own");
  refuse_rate(options);
  const BodyFileFormat format{name, 30.0, assumed, "", [&rows](const std::filesystem::path& path) {
                                return std::make_unique<JointRowReader>(path, rows);
                              }};
  return import_body_files(format, {{"k1", files[0]}}, output, options);
}

ImportReport import_labanotation(const Files& files, const std::filesystem::path& output,
                                 const ImportOptions& options) {
  return import_joint_rows("labanotation",
                           "The file holds no body id (1 is written), no orientations and no hand states "
                           "(zeros).",
                           kLabanotationRows, files, output, options);
}

ImportReport import_umons_taichi(const Files& files, const std::filesystem::path& output,
                                 const ImportOptions& options) {
  return import_joint_rows("umons-taichi",
                           "The file holds no tracking states (every joint is called tracked, inferred ones "
                           "too), no body id (1 is written), no orientations and no hand states (zeros). "
                           "This importer has not yet been run on a real file.",
                           kUmonsTaichiRows, files, output, options);
}

std::string calendar_time(std::int64_t epoch_ms) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(static_cast<std::time_t>(epoch_ms / 1000)),
                     epoch_ms % 1000);
}

ImportReport import_node_kinect2(const Files& files, const std::filesystem::path& output,
                                 const ImportOptions& options) {
  refuse_rate(options);
  std::vector<SensorFile> sensors;
  std::optional<std::int64_t> start_ms;
  for (const auto& file : files) {
    sensors.push_back({"k" + std::to_string(sensors.size() + 1), file});
    const auto start_of_file_ms = node_kinect2_start_ms(file);
    if (!start_of_file_ms && files.size() > 1)
      throw InputError(file.string(),
                       "does not say when it began (record_startime), so it shares no clock with the others; "
                       "import it alone");
    if (start_of_file_ms) start_ms = std::min(start_ms.value_or(*start_of_file_ms), *start_of_file_ms);
  }
  if (files.empty()) throw InputError("FILE", "is missing");
  const BodyFileFormat format{
      "node-kinect2", 30.0,
      "The files hold no tracking states: every joint of a tracked body is called tracked, inferred ones "
      "too. Times are the recording computer's, in milliseconds, of when the program got the frame." +
          std::string(start_ms ? ""
                               : " The file does not say when it began (record_startime): times count "
                                 "from an unknown beginning."),
      start_ms ? calendar_time(*start_ms) : "", [start_ms](const std::filesystem::path& path) {
        return std::make_unique<NodeKinect2Reader>(path, start_ms);
      }};
  return import_body_files(format, sensors, output, options);
}

// Several files are the cameras of one recording.
std::vector<SensorFile> ntu_sensors(const Files& files) {
  if (files.size() == 1) {
    const auto name = ntu_name_of(files[0]);
    return {{name ? name->camera : "C001", files[0]}};
  }
  std::vector<SensorFile> sensors;
  std::set<std::string> cameras;
  const auto first = ntu_name_of(files.at(0));
  for (const auto& file : files) {
    const auto name = ntu_name_of(file);
    if (!name)
      throw InputError(file.string(),
                       "has no name such as S001C002P003R002A013.skeleton, which says the camera");
    if (name->recording != first->recording)
      throw InputError(file.string(), "is of another recording than " + files[0].filename().string() +
                                          "; the files of a session differ in the camera C… only");
    if (!cameras.insert(name->camera).second)
      throw InputError(file.string(), "is a second file of camera " + name->camera);
    sensors.push_back({name->camera, file});
  }
  return sensors;
}

ImportReport import_ntu(const Files& files, const std::filesystem::path& output,
                        const ImportOptions& options) {
  if (files.empty()) throw InputError("FILE", "is missing");
  const double rate_hz = options.rate_hz.value_or(30.0);
  const BodyFileFormat format{"ntu", rate_hz,
                              "The files hold no time stamps: frame number / rate is the time, and the same "
                              "frame number of several cameras the same moment.",
                              "", [rate_hz](const std::filesystem::path& path) {
                                return std::make_unique<NtuReader>(path, rate_hz);
                              }};
  return import_body_files(format, ntu_sensors(files), output, options);
}

ImportReport import_kimore(const Files& files, const std::filesystem::path& output,
                           const ImportOptions& options) {
  need_one(files, "is a second recording; they share no clock, so each becomes a session of its own");
  const KimoreFiles found = kimore_files_of(files[0]);
  if (!found.time.empty()) refuse_rate(options);
  if (found.time.empty() && !options.rate_hz)
    throw InputError("--rate-hz", "is missing: there is no TimeStamp*.csv beside " + found.position.string());
  const std::string times =
      found.time.empty()
          ? fmt::format(" There are no time stamps: row / {:g} Hz is the time.", *options.rate_hz)
          : "";
  const std::string orientations = found.orientation.empty() ? " There are no orientations (zeros)."
                                                             : " Orientations are taken as x, y, z, w.";
  const BodyFileFormat format{"kimore", 30.0,
                              "The files hold no body id (1 is written) and no hand states (zeros)." +
                                  orientations + times +
                                  " This importer has not yet been run on a real file.",
                              "", [&](const std::filesystem::path&) {
                                return std::make_unique<KimoreReader>(found, options.rate_hz.value_or(30.0));
                              }};
  return import_body_files(format, {{"k1", files[0]}}, output, options);
}

constexpr std::array kFormats{
    ImportFormat{"kimore",
                 "folder with an exercise's JointPosition, TimeStamp and JointOrientation csv of the KIMORE "
                 "data set, or the JointPosition csv alone with --rate-hz (not yet run on a real file)",
                 import_kimore},
    ImportFormat{"labanotation", "body csv of Microsoft's LabanotationSuite", import_labanotation},
    ImportFormat{
        "node-kinect2",
        "recorded_skeleton.json of Kinectron or node-kinect2; several files: sensors of one computer's clock",
        import_node_kinect2},
    ImportFormat{"ntu", ".skeleton of NTU RGB+D; several files: the cameras of one recording", import_ntu},
    ImportFormat{"png",
                 "folder of depth images: 16-bit grey PNG, 512 x 424; needs --depth-unit-mm and one of "
                 "--rate-hz, --timestamps, --time-from-name",
                 import_png},
    ImportFormat{
        "umons-taichi",
        "Kinect text file of the UMONS-TAICHI data set: milliseconds and 25 joints a line (not yet run "
        "on a real file)",
        import_umons_taichi},
    ImportFormat{"xef",
                 "Kinect Studio's .xef, plain or archived: depth and bodies (not yet run on a real file)",
                 import_xef},
};

}  // namespace

std::span<const ImportFormat> import_formats() { return kFormats; }

ImportReport import_recording(const std::string& format, const std::vector<std::filesystem::path>& files,
                              const std::filesystem::path& output, const ImportOptions& options) {
  std::string known;
  for (const ImportFormat& f : kFormats) {
    if (f.name == format) return f.import(files, output, options);
    known += (known.empty() ? "" : ", ") + std::string(f.name);
  }
  throw InputError("FORMAT", "\"" + format + "\" is not known; there are " + known);
}

}  // namespace trilat
