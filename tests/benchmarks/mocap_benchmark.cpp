// SPDX-License-Identifier: MIT
// Reads a made export of Motive: ours into arrays, the same bytes with fread alone, and numpy.loadtxt, which
// one would write first (a process of its own, less its start; without numpy it is left out). MB/s of the
// file.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/mocap/mocap_writer.h"
#include "datasets/mocap/read_mocap.h"

namespace {

using namespace trilat;
namespace fs = std::filesystem;

constexpr int kMarkers = 40, kRounds = 3;
constexpr std::int64_t kFrames = 36'000;  // five minutes at 120 Hz

fs::path made_export() {
  MocapHeader header;
  header.take_name = "made";
  header.capture_rate_hz = header.export_rate_hz = 120.0;
  for (int m = 0; m < kMarkers; ++m)
    header.assets.push_back({AssetType::marker, "m" + std::to_string(m), std::to_string(m), "", true});
  const fs::path path = fs::temp_directory_path() / "trilat_mocap_benchmark.csv";
  OptitrackCsvWriter writer(path, header);
  std::vector<Eigen::Vector3d> position_m(kMarkers);
  for (std::int64_t f = 0; f < kFrames; ++f) {
    for (int m = 0; m < kMarkers; ++m) {
      const double turn = 0.01 * static_cast<double>(f) + m;
      position_m[static_cast<std::size_t>(m)] = {std::sin(turn), 1.0 + 0.1 * std::cos(3.0 * turn),
                                                 std::cos(turn)};
    }
    writer.write(f, position_m);
  }
  writer.finish();
  return path;
}

double seconds_of(const auto& work) {
  double best_s = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best_s =
        std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best_s;
}

}  // namespace

int main() {
  const fs::path path = made_export();
  const double megabytes = 1e-6 * static_cast<double>(fs::file_size(path));
  std::size_t frames = 0;
  const double ours_s = seconds_of([&] { frames = read_mocap(path).time.size(); });
  const double raw_s = seconds_of([&] {
    std::vector<char> block(1 << 20);
    std::FILE* file = std::fopen(path.c_str(), "rb");
    while (std::fread(block.data(), 1, block.size(), file) > 0) {
    }
    std::fclose(file);
  });
  const char* const named = std::getenv("TRILAT_PYTHON");
  const std::string python = std::string(named ? named : "python3") + " -c \"import numpy, sys; ";
  const std::string load =
      python + "numpy.loadtxt(sys.argv[1], delimiter=',', skiprows=8)\" " + path.string();
  std::printf("%.0f MB, %zu frames of %d markers: ours %.0f MB/s, a raw read %.0f MB/s (%.1f times)\n",
              megabytes, frames, kMarkers, megabytes / ours_s, megabytes / raw_s, ours_s / raw_s);
  if (std::system((python + "\" > /dev/null 2>&1").c_str()) == 0) {
    const double start_s = seconds_of([&] { (void)std::system((python + "\"").c_str()); });
    const double numpy_s = seconds_of([&] { (void)std::system(load.c_str()); }) - start_s;
    std::printf("numpy.loadtxt %.0f MB/s: ours is %.1f times as fast\n", megabytes / numpy_s,
                numpy_s / ours_s);
  }
  fs::remove(path);
}
