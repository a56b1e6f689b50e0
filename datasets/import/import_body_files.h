// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/import/body_file_reader.h"
#include "datasets/import/import_types.h"

namespace trilat {

// Sums of the straight line pixel = offset + slope * ratio.
struct LineSums {
  double count = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  void add(double ratio, double pixel);
};

struct FittedIntrinsics {
  DepthIntrinsics intrinsics;
  double rms_px = 0.0;  // of both image axes together
};

// The depth camera from joints whose positions and pixels a file both has: column = cx + fx X/Z and
// row = cy - fy Y/Z, by least squares, without distortion.
class IntrinsicsFit {
 public:
  void add(const Body& body, const JointPixels& depth_px);
  // Nothing with fewer than 200 joints, with too little of the image covered, with more than 1 px left over,
  // or when no Kinect is like that.
  std::optional<FittedIntrinsics> solve() const;

 private:
  LineSums column_, row_;
};

// A kind of body file: how it is opened, and what has to be assumed of it.
struct BodyFileFormat {
  std::string name;
  double nominal_rate_hz = 30.0;
  std::string assumed;      // a sentence for the session's note
  std::string started_utc;  // free text, empty when the files do not say
  std::function<std::unique_ptr<BodyFileReader>(const std::filesystem::path&)> open;
};

// A file and the sensor it comes from.
struct SensorFile {
  std::string sensor;
  std::filesystem::path path;
};

// One reading of a file from end to end.
struct BodyFileSurvey {
  std::int64_t frames = 0;
  LeftOut left_out{};
  std::optional<FittedIntrinsics> fitted{};
};

// InputError when the file holds no frame at all.
BodyFileSurvey survey_body_file(BodyFileReader& reader, const std::string& name,
                                const std::function<void(std::uint64_t bytes)>& progress = {});

// Reads every file twice, first to see that it can be meant and which camera it was, then into the session.
// An import that fails leaves nothing behind.
ImportReport import_body_files(const BodyFileFormat& format, const std::vector<SensorFile>& files,
                               const std::filesystem::path& output, const ImportOptions& options);

}  // namespace trilat
