// SPDX-License-Identifier: MIT
#include "datasets/calibration/opencv_intrinsics.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr const char* kWanted =
    "wanted is an OpenCV file with cameraMatrix and distortionCoefficients, such as calib_ir.yaml";

constexpr std::size_t kMostBytes = 1u << 20;

// The YAML that OpenCV writes: names in the first column, in each a matrix or a list whose numbers stand in
// brackets.
class IntrinsicsFile {
 public:
  explicit IntrinsicsFile(const std::filesystem::path& path) : place_(path.string()) {
    std::istringstream lines(read_file(path, kMostBytes));
    std::string line;
    if (!std::getline(lines, line) || !line.starts_with("%YAML"))
      refuse(fmt::format("is not YAML as OpenCV writes it; {}", kWanted));
    while (std::getline(lines, line)) {
      const bool continues = line.starts_with(' ') || line.starts_with('\t');
      if (!continues && std::isalpha(static_cast<unsigned char>(line[0])) != 0)
        entries_.emplace_back(line.substr(0, line.find(':')), line);
      else if (continues && !entries_.empty())
        entries_.back().second += line;
    }
  }

  [[noreturn]] void refuse(const std::string& problem) const { throw InputError(place_, problem); }

  // The numbers of a matrix, row by row, under one of its names.
  std::vector<double> numbers(std::initializer_list<const char*> names, const char* what) const {
    std::vector<std::string> keys;
    for (const auto& [key, text] : entries_) {
      keys.push_back(key);
      if (std::ranges::find(names, key) != names.end()) return in_brackets(key, text);
    }
    refuse(keys.empty() ? fmt::format("holds no {}; {}", what, kWanted)
                        : fmt::format("holds {} but no {}; {}", fmt::join(keys, ", "), what, kWanted));
  }

 private:
  std::vector<double> in_brackets(const std::string& name, const std::string& text) const {
    const std::size_t begin = text.find('['), end = text.find(']', begin);
    if (begin == std::string::npos || end == std::string::npos)
      refuse(fmt::format("{} holds no numbers in brackets", name));
    std::vector<double> values;
    std::istringstream words(text.substr(begin + 1, end - begin - 1));
    for (std::string word; std::getline(words, word, ',');) {
      const std::size_t first = word.find_first_not_of(" \t\r");
      word = first == std::string::npos ? "" : word.substr(first, word.find_last_not_of(" \t\r") + 1 - first);
      char* rest = nullptr;
      values.push_back(word == ".Nan" ? std::nan("") : std::strtod(word.c_str(), &rest));
      if (word.empty() || (rest && *rest))
        refuse(fmt::format("{} holds something that is not a number", name));
    }
    return values;
  }

  std::string place_;
  std::vector<std::pair<std::string, std::string>> entries_;  // name, and its lines
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

}  // namespace

DepthIntrinsics read_opencv_intrinsics(const std::filesystem::path& path, int width_px, int height_px) {
  const IntrinsicsFile file(path);
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

}  // namespace trilat
