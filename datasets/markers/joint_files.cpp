// SPDX-License-Identifier: MIT
#include "datasets/markers/joint_files.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/markers/c3d_parameters.h"

namespace trilat {
namespace {

constexpr std::size_t kMostC3dJoints = 255;
constexpr std::int64_t kHighestC3dWord = 65'535;
constexpr double kLargestResidual_mm = 255.0;
constexpr float kRealPoints = -1.0f;  // a negative scale says so; its size is the residual's unit

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

// Little-endian bytes, as an Intel processor has them.
template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
static_assert(std::endian::native == std::endian::little);

void append_word(std::string& bytes, std::int64_t value) {
  append(bytes, static_cast<std::uint16_t>(std::min(value, kHighestC3dWord)));
}

// A group (negative) or a parameter of the group with that id, whose content is type, dimensions and data.
void append_entry(std::string& section, int group, std::string_view name, std::string_view content) {
  append(section, static_cast<char>(name.size()));
  append(section, static_cast<char>(group));
  section += name;
  append_word(section, static_cast<std::int64_t>(2 + content.size() + 1));
  section += content;
  section += '\0';  // no description
}

std::string words(const std::vector<std::int64_t>& values) {
  std::string content{2, static_cast<char>(values.size() > 1)};
  if (values.size() > 1) append(content, static_cast<char>(values.size()));
  for (const std::int64_t value : values) append_word(content, value);
  return content;
}

std::string real(float value) {
  std::string content{4, 0};
  append(content, value);
  return content;
}

std::string texts(const std::vector<std::string>& values) {
  std::size_t length = 1;
  for (const std::string& value : values) length = std::max(length, std::min<std::size_t>(value.size(), 255));
  std::string content{-1, 2, static_cast<char>(length), static_cast<char>(values.size())};
  for (std::string value : values) {
    value.resize(length, ' ');
    content += value;
  }
  return content;
}

std::string c3d_parameters(const JointTrack& track, std::int64_t data_block) {
  enum Group { point = 1, analog = 2, trial = 3 };
  std::string section{1, 0x50, static_cast<char>(data_block - 2), static_cast<char>(C3dProcessor::intel)};
  append_entry(section, -point, "POINT", "");
  append_entry(section, point, "USED", words({static_cast<std::int64_t>(track.joints.size())}));
  append_entry(section, point, "SCALE", real(kRealPoints));
  append_entry(section, point, "RATE", real(static_cast<float>(track.rate_hz)));
  append_entry(section, point, "DATA_START", words({data_block}));
  append_entry(section, point, "FRAMES", words({track.frames}));
  append_entry(section, point, "UNITS", texts({"mm"}));
  append_entry(section, point, "LABELS", texts(track.joints));
  append_entry(section, -analog, "ANALOG", "");
  append_entry(section, analog, "USED", words({0}));
  append_entry(section, -trial, "TRIAL", "");
  append_entry(section, trial, "ACTUAL_START_FIELD", words({1, 0}));
  append_entry(section, trial, "ACTUAL_END_FIELD", words({track.frames & 0xffff, track.frames >> 16}));
  return section + std::string(2, '\0');
}

std::string c3d_header(const JointTrack& track, std::int64_t data_block) {
  std::string header{2, 0x50};
  append_word(header, static_cast<std::int64_t>(track.joints.size()));
  append_word(header, 0);  // analog samples
  append_word(header, 1);
  append_word(header, track.frames);
  append_word(header, 0);  // longest gap that was filled
  append(header, kRealPoints);
  append_word(header, data_block);
  append_word(header, 0);
  append(header, static_cast<float>(track.rate_hz));
  header.resize(kC3dBlock);
  return header;
}

void append_point(std::string& bytes, const Eigen::Vector3d& position_m, double sigma_m) {
  const bool missing = !position_m.allFinite();
  for (const double x_m : position_m) append(bytes, missing ? 0.0f : static_cast<float>(1e3 * x_m));
  const double residual_mm =
      std::isfinite(sigma_m) ? std::clamp(std::round(1e3 * sigma_m), 1.0, kLargestResidual_mm) : 0.0;
  append(bytes, missing ? -1.0f : static_cast<float>(residual_mm));
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

void write_c3d(const std::filesystem::path& path, const JointTrack& track) {
  TRILAT_CHECK(track.joints.size() <= kMostC3dJoints, "a C3D file holds the joints' names");
  // The size does not depend on the block, which is a number of fixed length.
  const std::size_t blocks = (c3d_parameters(track, 2).size() + kC3dBlock - 1) / kC3dBlock;
  const auto data_block = static_cast<std::int64_t>(2 + blocks);
  std::string parameters = c3d_parameters(track, data_block);
  parameters.resize(kC3dBlock * blocks);
  TextOutput bytes(path);
  bytes.add_bytes(c3d_header(track, data_block) + parameters);
  std::string row;
  for_each_frame(track, [&](std::int64_t, const JointFrame& frame) {
    row.clear();
    for (std::size_t j = 0; j < track.joints.size(); ++j)
      append_point(row, frame.position_m[j], sigma_of(frame, j));
    bytes.add_bytes(row);
  });
  const std::size_t rest = 16 * track.joints.size() * static_cast<std::size_t>(track.frames) % kC3dBlock;
  if (rest > 0) bytes.add_bytes(std::string(kC3dBlock - rest, '\0'));
  bytes.publish();
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
