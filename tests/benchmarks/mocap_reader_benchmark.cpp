// SPDX-License-Identifier: MIT
// Writes an OptiTrack export of about 100 MB, reads it with the streaming reader and with the line-by-line
// reader one would write first, and prints both speeds. The two sums must agree.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <unistd.h>

#include "datasets/mocap/mocap_reader.h"
#include "datasets/mocap/mocap_summary.h"
#include "datasets/mocap/optitrack_csv_writer.h"

namespace {

using namespace trilat;

constexpr int kBodies = 20;
constexpr int kMarkers = 40;
constexpr std::int64_t kFrames = 42'000;
constexpr int kRounds = 5;

MocapHeader header_of_the_take() {
  MocapHeader header;
  header.take_name = "benchmark";
  header.capture_rate_hz = header.export_rate_hz = 120.0;
  header.total_frames_in_take = header.total_exported_frames = kFrames;
  header.length_unit = LengthUnit::millimetre;
  for (int i = 0; i < kBodies + kMarkers; ++i)
    header.assets.push_back({.type = i < kBodies ? AssetType::rigid_body : AssetType::marker,
                             .name = "asset " + std::to_string(i),
                             .id = std::to_string(1000 + i),
                             .parent = {},
                             .has_rotation = i < kBodies,
                             .has_position = true});
  return header;
}

void write_take(const std::filesystem::path& path) {
  const MocapHeader header = header_of_the_take();
  OptitrackCsvWriter writer(path, header);
  MocapFrame frame;
  frame.poses.resize(header.assets.size());
  for (frame.index = 0; frame.index < kFrames; ++frame.index) {
    for (std::size_t i = 0; i < frame.poses.size(); ++i) {
      const double angle_rad = 0.001 * static_cast<double>(frame.index) + static_cast<double>(i);
      frame.poses[i].position_m = {2.0 * std::sin(angle_rad), 1.1 + 0.3 * std::cos(angle_rad),
                                   1.7 * std::cos(2.0 * angle_rad)};
      frame.poses[i].rotation = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
    }
    writer.write(frame);
  }
  writer.finish();
}

double sum_of(const std::filesystem::path& path, const std::vector<std::size_t>& assets) {
  MocapReader reader(path);
  reader.read_only(assets);
  MocapFrame frame;
  double sum_m = 0.0;
  while (reader.next(frame))
    for (const std::size_t asset : assets) sum_m += frame.poses[asset].position_m.sum();
  return sum_m;
}

double naive_sum_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  for (int i = 0; i < 8; ++i) std::getline(file, line);
  double sum_m = 0.0;
  while (std::getline(file, line)) {
    std::stringstream cells(line);
    std::vector<double> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::strtod(cell.c_str(), nullptr));
    for (int body = 0; body < kBodies; ++body)
      for (int axis = 0; axis < 3; ++axis)
        sum_m += 1e-3 * row[static_cast<std::size_t>(2 + 7 * body + 4 + axis)];
    for (std::size_t i = 2 + 7 * kBodies; i < row.size(); ++i) sum_m += 1e-3 * row[i];
  }
  return sum_m;
}

double summary_of(const std::filesystem::path& path) {
  MocapReader reader(path);
  return static_cast<double>(summarize_mocap(reader).frames);
}

template <class Task>
double best_mb_per_s(const char* name, double size_mb, int rounds, Task task) {
  double best_s = 1e9;
  double result = 0.0;
  for (int round = 0; round < rounds; ++round) {
    const auto start = std::chrono::steady_clock::now();
    result = task();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    best_s = std::min(best_s, taken.count());
  }
  std::printf("%-28s %8.1f MB/s  (result %.6f)\n", name, size_mb / best_s, result);
  return size_mb / best_s;
}

}  // namespace

int main() {
  const auto path = std::filesystem::temp_directory_path() /
                    ("mocap_reader_benchmark." + std::to_string(::getpid()) + ".csv");
  const auto start = std::chrono::steady_clock::now();
  write_take(path);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  const double size_mb = static_cast<double>(std::filesystem::file_size(path)) * 1e-6;
  std::printf("%-28s %8.1f MB/s  (%.1f MB)\n", "write", size_mb / taken.count(), size_mb);

  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < kBodies + kMarkers; ++i) all.push_back(i);
  const double ours = best_mb_per_s("read, all columns", size_mb, kRounds, [&] { return sum_of(path, all); });
  best_mb_per_s("read, three assets", size_mb, kRounds, [&] {
    return sum_of(path, {0, kBodies / 2, kBodies});
  });
  best_mb_per_s("read and summarise", size_mb, kRounds, [&] { return summary_of(path); });
  const double naive =
      best_mb_per_s("getline, stringstream, strtod", size_mb, 2, [&] { return naive_sum_of(path); });
  std::printf("ratio to the naive reader    %8.1f\n", ours / naive);
  std::filesystem::remove(path);
  return 0;
}
