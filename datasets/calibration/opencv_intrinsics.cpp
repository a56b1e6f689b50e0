// SPDX-License-Identifier: MIT
#include "datasets/calibration/opencv_intrinsics.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr const char* kWanted =
    "wanted is an OpenCV file with cameraMatrix and distortionCoefficients, such as calib_ir.yaml";

constexpr std::size_t kMostBytes = 1u << 20;
constexpr int kMostBrackets = 8;  // inside each other

// "name:", a comment, something indented below a name, or nothing.
bool is_line_of_a_map(const std::string& line, bool names_before) {
  const std::size_t first = line.find_first_not_of(" \r");
  if (first == std::string::npos || line[first] == '#') return true;
  if (first > 0) return names_before;
  const std::size_t colon =
      line.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.");
  return line[0] != '-' && line[0] != '.' && colon != std::string::npos && colon > 0 && line[colon] == ':';
}

bool brackets_are_shallow(const std::string& text) {
  int depth = 0;
  for (const char c : text) {
    depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    if (depth > kMostBrackets) return false;
  }
  return true;
}

// OpenCV's parser (4.6) never comes back from some texts with a second document or a name that is not in the
// first column, nor from deep brackets: they must not reach it.
bool is_one_map(const std::string& text) {
  if (text.size() > kMostBytes || !text.starts_with("%YAML") || !brackets_are_shallow(text)) return false;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  for (bool names = false, begins = true; std::getline(lines, line); begins = false) {
    if (begins && line.starts_with("---") && line.find_first_not_of(" \r", 3) == std::string::npos) continue;
    if (!is_line_of_a_map(line, names)) return false;
    names |= !line.empty() && line[0] != ' ' && line[0] != '#' && line[0] != '\r';
  }
  return true;
}

// OpenCV prints every error it throws to stderr; we say it once, ourselves.
class SilentOpenCv {
 public:
  SilentOpenCv()
      : before_(cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; })) {
  }
  ~SilentOpenCv() { cv::redirectError(before_); }
  SilentOpenCv(const SilentOpenCv&) = delete;
  SilentOpenCv& operator=(const SilentOpenCv&) = delete;

 private:
  cv::ErrorCallback before_;
};

class IntrinsicsFile {
 public:
  IntrinsicsFile(const std::filesystem::path& path, const std::string& text) : place_(path.string()) {
    if (text.empty()) refuse(fmt::format("is empty; {}", kWanted));
    if (text.find('\0') != std::string::npos) refuse(fmt::format("is not text; {}", kWanted));
    if (!is_one_map(text)) refuse(fmt::format("is not YAML as OpenCV writes it; {}", kWanted));
    if (!storage_.open(text, cv::FileStorage::READ | cv::FileStorage::MEMORY))
      refuse(fmt::format("cannot be read by OpenCV; {}", kWanted));
  }

  [[noreturn]] void refuse(const std::string& problem) const { throw InputError(place_, problem); }

  // The numbers of a matrix, row by row, under one of its names.
  std::vector<double> numbers(std::initializer_list<const char*> names, const char* what) const {
    for (const char* name : names) {
      const cv::FileNode node = storage_[name];
      if (node.empty()) continue;
      const cv::FileNode data = node.isMap() ? node["data"] : node;
      std::vector<double> values;
      if (data.isSeq())
        for (const cv::FileNode& value : data) {
          if (!value.isInt() && !value.isReal())
            refuse(fmt::format("{} holds something that is no number", name));
          values.push_back(static_cast<double>(value));
        }
      if (values.empty()) refuse(fmt::format("{} holds no numbers", name));
      return values;
    }
    const std::vector<std::string> keys =
        storage_.root().isMap() ? storage_.root().keys() : std::vector<std::string>{};
    refuse(keys.empty() ? fmt::format("holds no {}; {}", what, kWanted)
                        : fmt::format("holds {} but no {}; {}", fmt::join(keys, ", "), what, kWanted));
  }

 private:
  std::string place_;
  cv::FileStorage storage_;
};

void take_camera_matrix(const IntrinsicsFile& file, DepthIntrinsics& in) {
  const std::vector<double> k = file.numbers({"cameraMatrix", "camera_matrix"}, "camera matrix");
  if (k.size() != 9) file.refuse(fmt::format("the camera matrix has {} numbers, not 9", k.size()));
  if (k[1] != 0.0 || k[3] != 0.0 || k[6] != 0.0 || k[7] != 0.0 || k[8] != 1.0)
    file.refuse("the camera matrix is not of the form fx 0 cx, 0 fy cy, 0 0 1");
  in.fx_px = k[0];
  in.cx_px = k[2];
  in.fy_px = k[4];
  in.cy_px = k[5];
}

void take_distortion(const IntrinsicsFile& file, DepthIntrinsics& in) {
  std::vector<double> d =
      file.numbers({"distortionCoefficients", "distortion_coefficients"}, "distortion coefficients");
  if (d.size() != 4 && d.size() != 5 && d.size() != 8 && d.size() != 12 && d.size() != 14)
    file.refuse(fmt::format("has {} distortion coefficients; 5 are right (k1 k2 p1 p2 k3)", d.size()));
  if (std::any_of(d.begin() + std::min<std::ptrdiff_t>(5, std::ssize(d)), d.end(),
                  [](double v) { return v != 0.0; }))
    file.refuse(
        "uses distortion beyond k1 k2 p1 p2 k3, which is not supported; calibrate with five coefficients");
  d.resize(5, 0.0);
  in.k1 = d[0];
  in.k2 = d[1];
  in.p1 = d[2];
  in.p2 = d[3];
  in.k3 = d[4];
}

// A Kinect v2's colour image has 1920 x 1080 pixels.
bool looks_like_colour(const DepthIntrinsics& in) {
  return in.width_px < 1000 && in.fx_px > 900.0 && in.fx_px < 1250.0 && in.cx_px > 0.75 * in.width_px &&
         std::abs(in.cx_px - 960.0) < 200.0 && std::abs(in.cy_px - 540.0) < 120.0;
}

DepthIntrinsics read(const std::filesystem::path& path, int width_px, int height_px) {
  const IntrinsicsFile file(path, read_file(path));
  DepthIntrinsics in;
  in.width_px = width_px;
  in.height_px = height_px;
  take_camera_matrix(file, in);
  take_distortion(file, in);
  if (looks_like_colour(in))
    file.refuse(
        fmt::format("these look like the colour camera's intrinsics (fx {}); the depth camera's are wanted "
                    "(calib_ir.yaml)",
                    static_cast<int>(in.fx_px)));
  if (const std::string problem = implausibility_of(in); !problem.empty()) file.refuse(problem);
  return in;
}

}  // namespace

DepthIntrinsics read_opencv_intrinsics(const std::filesystem::path& path, int width_px, int height_px) {
  const SilentOpenCv silent;
  const InputError not_one(path.string(), fmt::format("is not a file of OpenCV's FileStorage; {}", kWanted));
  try {
    return read(path, width_px, height_px);
  } catch (const cv::Exception&) {
    throw not_one;
  } catch (const std::length_error&) {  // its parser lets these through
    throw not_one;
  } catch (const std::out_of_range&) {
    throw not_one;
  }
}

}  // namespace trilat
