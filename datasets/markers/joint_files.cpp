// SPDX-License-Identifier: MIT
#include "datasets/markers/joint_files.h"

#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"

namespace trilat {
namespace {

// Calls `write(number, frame)` with every frame, of which the first is number 1.
template <class Write>
void for_each_frame(const JointTrack& track, const Write& write) {
  JointFrame frame;
  double first_s = 0.0;
  for (std::int64_t i = 0; i < track.frames; ++i) {
    track.next(frame);
    if (i == 0) first_s = frame.time_s;
    const double periods = (frame.time_s - first_s) * track.rate_hz;
    TRILAT_CHECK(std::abs(periods - static_cast<double>(i)) <= 0.5, "frames follow each other at the rate");
    TRILAT_CHECK(frame.position_m.size() == track.joints.size(), "a frame has a position for each joint");
    TRILAT_CHECK(frame.sigma_m.empty() || frame.sigma_m.size() == track.joints.size(),
                 "a frame has an uncertainty for each joint or none");
    TRILAT_CHECK(frame.status.empty() || frame.status.size() == track.joints.size(),
                 "a frame has a status for each joint or none");
    write(i + 1, frame);
  }
}

double sigma_of(const JointFrame& frame, std::size_t joint) {
  return frame.sigma_m.empty() ? std::nan("") : frame.sigma_m[joint];
}

}  // namespace

std::string trc_header(const std::filesystem::path& path, const std::vector<std::string>& joints,
                       double rate_hz, std::int64_t frames, LengthUnit unit) {
  std::string text = fmt::format(
      "PathFileType\t4\t(X/Y/Z)\t{}\n"
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
      "{:g}\t{:g}\t{}\t{}\t{}\t{:g}\t1\t{}\nFrame#\tTime",
      path.filename().string(), rate_hz, rate_hz, frames, joints.size(),
      unit == LengthUnit::millimetre ? "mm" : "m", rate_hz, frames);
  for (const std::string& joint : joints) text += fmt::format("\t{}\t\t", joint);
  text += "\n\t";
  for (std::size_t j = 1; j <= joints.size(); ++j) text += fmt::format("\tX{}\tY{}\tZ{}", j, j, j);
  return text + "\n\n";
}

void write_trc(const std::filesystem::path& path, const JointTrack& track) {
  TextOutput text(path);
  text.add_bytes(trc_header(path, track.joints, track.rate_hz, track.frames, LengthUnit::millimetre));
  for_each_frame(track, [&](std::int64_t number, const JointFrame& frame) {
    text.add("{}\t{:.6f}", number, frame.time_s);
    for (const Eigen::Vector3d& position_m : frame.position_m)
      if (position_m.allFinite())
        text.add("\t{:.3f}\t{:.3f}\t{:.3f}", 1e3 * position_m.x(), 1e3 * position_m.y(),
                 1e3 * position_m.z());
      else
        text.add("\t\t\t");
    text.add("\n");
  });
  text.publish();
}

void write_joint_csv(const std::filesystem::path& path, const JointTrack& track) {
  TextOutput text(path);
  text.add("{}", kJointCsvHead);
  for_each_frame(track, [&](std::int64_t number, const JointFrame& frame) {
    for (std::size_t j = 0; j < track.joints.size(); ++j) {
      text.add("{},{:.6f},{},{}", number, frame.time_s, csv_field(track.joints[j]),
               frame.status.empty() ? std::string() : csv_field(frame.status[j]));
      for (const double number_m :
           {frame.position_m[j].x(), frame.position_m[j].y(), frame.position_m[j].z(), sigma_of(frame, j)})
        if (std::isfinite(number_m) && frame.position_m[j].allFinite())
          text.add(",{:.6f}", number_m);
        else
          text.add(",");
      text.add("\n");
    }
  });
  text.publish();
}

}  // namespace trilat
