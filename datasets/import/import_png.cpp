// SPDX-License-Identifier: MIT
#include "datasets/import/import_png.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>

#include <fmt/format.h>
#include <png.h>

#include "datasets/base/error.h"
#include "datasets/import/import_session.h"
#include "datasets/import/import_types.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/line_reader.h"
#include "datasets/session/session_types.h"

namespace trilat {

namespace {

constexpr double kTicksPerSecond = 1e9 / static_cast<double>(kImportTickNs);
constexpr double kSurveyShare = 0.4;  // of the work: every image is read twice
constexpr std::uint16_t kNearest_mm = 500, kFarthest_mm = 8000;
constexpr double kLatest_s = 5e8;  // what a session's clocks can hold

struct Image {
  std::filesystem::path path;
  double time_s = 0.0;
};

std::vector<Image> images_of(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder))
    throw InputError(folder.string(), "is no folder of depth images");
  std::vector<Image> images;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".png") images.push_back({entry.path()});
  if (images.empty()) throw InputError(folder.string(), "holds no .png");
  std::sort(images.begin(), images.end(), [](const Image& a, const Image& b) { return a.path < b.path; });
  return images;
}

void check_time(double time_s, const std::string& place) {
  if (!(std::abs(time_s) < kLatest_s))
    throw InputError(
        place,
        fmt::format("has the time {} s, beyond 15 years; times count from the recording's begin, in seconds",
                    time_s));
}

std::vector<double> read_times(const std::filesystem::path& path) {
  LineReader lines(path, 1u << 16);
  std::vector<double> times_s;
  for (std::string_view line; lines.next(line);) {
    if (line.empty()) continue;
    double time_s = 0.0;
    if (parse_cell(line, time_s) != CellKind::number)
      throw InputError(lines.place(), "is no number; one time in seconds a line is expected");
    check_time(time_s, lines.place());
    times_s.push_back(time_s);
  }
  return times_s;
}

void take_times(std::vector<Image>& images, const ImportOptions& options) {
  if (options.rate_hz) {
    for (std::size_t i = 0; i < images.size(); ++i)
      images[i].time_s = static_cast<double>(i) / *options.rate_hz;
  } else if (options.time_from_name) {
    for (Image& image : images) {
      const auto time_s = last_number_in(image.path.stem().string());
      if (!time_s)
        throw InputError(image.path.string(), "has no number in its name, and --time-from-name is given");
      check_time(*time_s, image.path.string());
      image.time_s = *time_s;
    }
    std::stable_sort(images.begin(), images.end(),
                     [](const Image& a, const Image& b) { return a.time_s < b.time_s; });
  } else {
    const std::vector<double> times_s = read_times(options.timestamps);
    if (times_s.size() != images.size())
      throw InputError(options.timestamps.string(),
                       fmt::format("holds {} times for {} images", times_s.size(), images.size()));
    for (std::size_t i = 0; i < images.size(); ++i) images[i].time_s = times_s[i];
  }
}

void need_options(const ImportOptions& options) {
  if (!options.depth_unit_mm)
    throw InputError(
        "--depth-unit-mm",
        "is missing: what a value of 1 means is not in the images (1 for Kinect v2 and NTU, 0.2 for TUM)");
  const int ways = options.rate_hz.has_value() + options.time_from_name + !options.timestamps.empty();
  if (ways != 1)
    throw InputError("--rate-hz, --timestamps, --time-from-name",
                     ways == 0 ? "are all missing: one must say when the images were made"
                               : "say when the images were made; only one of them can");
}

void to_millimetres(std::span<std::uint16_t> values, double unit_mm, const std::string& place) {
  if (unit_mm == 1.0) return;
  for (std::uint16_t& value : values) {
    const double depth_mm = std::round(unit_mm * value);
    if (depth_mm > std::numeric_limits<std::uint16_t>::max())
      throw InputError(
          place, fmt::format("has a depth of {:.0f} mm; is --depth-unit-mm {:g} right?", depth_mm, unit_mm));
    value = static_cast<std::uint16_t>(depth_mm);
  }
}

void read_image(const Image& image, const ImportOptions& options, std::span<std::uint16_t> depth_mm) {
  read_depth_png(image.path, depth_mm);
  to_millimetres(depth_mm, *options.depth_unit_mm, image.path.string());
}

// How much of the images a Kinect v2 cannot have measured: infrared pictures look like depth images, too.
std::string note_on_depths(const std::vector<Image>& images, const ImportOptions& options) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  std::int64_t values = 0, outside = 0;
  std::uint16_t most_mm = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    try {
      read_image(images[i], options, depth_mm);
    } catch (const TornRow&) {
      continue;  // is counted when the session is written
    }
    for (const std::uint16_t d : depth_mm) {
      values += d != 0;
      outside += d != 0 && (d < kNearest_mm || d > kFarthest_mm);
      most_mm = std::max(most_mm, d);
    }
    if (options.progress)
      options.progress(kSurveyShare * static_cast<double>(i + 1) / static_cast<double>(images.size()));
  }
  if (outside == 0) return " All depths are ones that the sensor can measure.";
  return fmt::format(
      " Of {} values that are not 0, {} ({:.1f} %) lie outside the 0.5 to 8 m that the sensor can measure, "
      "up "
      "to {:.1f} m: are these depth images, and is --depth-unit-mm right?",
      values, outside, 100.0 * static_cast<double>(outside) / static_cast<double>(values), 1e-3 * most_mm);
}

SessionHeader header_of(const ImportOptions& options) {
  SensorDescription sensor;
  sensor.name = "k1";
  sensor.source = "import png";
  sensor.tick_ns = kImportTickNs;
  sensor.nominal_rate_hz = options.rate_hz.value_or(30.0);
  sensor.has_depth = true;
  SessionHeader header;
  header.note =
      fmt::format("Values count {:g} mm each; times are {}. Intrinsics: those of a typical Kinect v2.",
                  *options.depth_unit_mm,
                  options.rate_hz          ? "the image's number / rate"
                  : options.time_from_name ? "the last number of each name, in seconds"
                                           : "those of " + options.timestamps.filename().string());
  header.sensors.push_back(sensor);
  return header;
}

using Rows = std::array<png_bytep, kDepthHeight>;

// The library reports by a jump over our frames: functions that call it hold nothing that has a destructor.
struct PngFile {
  std::FILE* file = nullptr;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::array<char, 128> problem{};

  explicit PngFile(const std::filesystem::path& path) : file(std::fopen(path.c_str(), "rb")) {
    if (!file) throw InputError(path.string(), std::string("cannot be opened: ") + std::strerror(errno));
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    info = png ? png_create_info_struct(png) : nullptr;
  }
  ~PngFile() {
    png_destroy_read_struct(&png, &info, nullptr);
    std::fclose(file);
  }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  [[noreturn]] static void on_error(png_structp png, png_const_charp message) {
    auto* self = static_cast<PngFile*>(png_get_error_ptr(png));
    std::strncpy(self->problem.data(), message, self->problem.size() - 1);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
};

bool read_header(PngFile& file) {
  if (setjmp(png_jmpbuf(file.png))) return false;
  png_init_io(file.png, file.file);
  png_read_info(file.png, file.info);
  return true;
}

// PNG is big-endian.
bool read_rows(PngFile& file, Rows& rows) {
  if (setjmp(png_jmpbuf(file.png))) return false;
  png_set_swap(file.png);
  png_set_interlace_handling(file.png);
  png_read_update_info(file.png, file.info);
  png_read_image(file.png, rows.data());
  png_read_end(file.png, nullptr);
  return true;
}

}  // namespace

std::optional<double> last_number_in(std::string_view stem) {
  const auto digits = std::string_view("0123456789");
  const auto last = stem.find_last_of(digits);
  if (last == std::string_view::npos) return {};
  auto begin = stem.substr(0, last + 1).find_last_not_of("0123456789.") + 1;  // npos + 1 is the beginning
  begin = stem.find_first_of(digits, begin);
  double value = 0.0;
  if (parse_cell(stem.substr(begin, last + 1 - begin), value) != CellKind::number) return {};
  return value;
}

ImportReport import_png(const std::vector<std::filesystem::path>& files, const std::filesystem::path& output,
                        const ImportOptions& options) {
  if (files.size() != 1)
    throw InputError(files.empty() ? "FOLDER" : files[1].string(),
                     files.empty() ? "is missing" : "is a second folder; a folder is a sensor and a session");
  need_options(options);
  std::vector<Image> images = images_of(files[0]);
  take_times(images, options);
  SessionHeader header = header_of(options);
  header.note += note_on_depths(images, options);
  ImportSession session(output, header, options.compression);
  session.report(0).file = files[0].string();
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string place = images[i].path.string();
    try {
      read_image(images[i], options, depth_mm);
      session.add_depth(0, std::llround(kTicksPerSecond * images[i].time_s), {}, depth_mm, place);
    } catch (const TornRow& row) {
      count_torn(session.report(0).left_out, place, row);
    }
    if (options.progress)
      options.progress(kSurveyShare + (1.0 - kSurveyShare) * static_cast<double>(i + 1) /
                                          static_cast<double>(images.size()));
  }
  return session.finish();
}

void read_depth_png(const std::filesystem::path& path, std::span<std::uint16_t> values) {
  TRILAT_CHECK(values.size() == kDepthPixels, "a depth image has 512 x 424 pixels");
  PngFile file(path);
  if (!file.info) throw InputError(path.string(), "cannot be read: there is not enough memory");
  if (!read_header(file)) throw TornRow{fmt::format("cannot be read: {}", file.problem.data())};
  const auto width = png_get_image_width(file.png, file.info),
             height = png_get_image_height(file.png, file.info);
  const int bits = png_get_bit_depth(file.png, file.info);
  const bool grey = png_get_color_type(file.png, file.info) == PNG_COLOR_TYPE_GRAY;
  if (width != kDepthWidth || height != kDepthHeight || bits != 16 || !grey)
    throw InputError(path.string(),
                     fmt::format("is {} x {} with {} bits, {}; depth images of a Kinect v2 are 512 x 424 "
                                 "with 16 bits, grey",
                                 width, height, bits, grey ? "grey" : "not grey"));
  Rows rows;
  for (std::size_t r = 0; r < rows.size(); ++r)
    rows[r] = reinterpret_cast<png_bytep>(&values[r * std::size_t{kDepthWidth}]);
  if (!read_rows(file, rows)) throw TornRow{fmt::format("cannot be read: {}", file.problem.data())};
}

}  // namespace trilat
