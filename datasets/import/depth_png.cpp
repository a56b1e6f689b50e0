// SPDX-License-Identifier: MIT
#include "datasets/import/depth_png.h"

#include <array>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string>

#include <fmt/format.h>
#include <png.h>

#include "datasets/base/check.h"
#include "datasets/base/error.h"
#include "datasets/import/import_types.h"
#include "datasets/session/session_types.h"

namespace trilat {
namespace {

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
