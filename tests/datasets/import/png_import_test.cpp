// SPDX-License-Identifier: MIT
#include <cstdio>

#include <gmock/gmock.h>
#include <png.h>

#include "datasets/import/import_png.h"
#include "tests/datasets/import/import_fixtures.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Picture {
  std::uint32_t width = 512, height = 424;
  int bits = 16, colour = PNG_COLOR_TYPE_GRAY;
};

// Values: pixel number modulo 1000, and 100 more a frame.
void write_png(const std::filesystem::path& path, int frame, const Picture& picture = {}) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, picture.width, picture.height, picture.bits, picture.colour, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  std::vector<png_byte> row(std::size_t{8} * picture.width);
  for (std::uint32_t y = 0; y < picture.height; ++y) {
    for (std::uint32_t x = 0; x < picture.width; ++x) {
      const auto value = static_cast<unsigned>(100 * frame) + (y * picture.width + x) % 1000;
      row[2 * x] = static_cast<png_byte>(value >> 8);
      row[2 * x + 1] = static_cast<png_byte>(value & 0xff);
    }
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

struct Folder {
  ScratchFolder scratch;
  std::filesystem::path path = scratch / "depth";
  explicit Folder(const std::vector<std::string>& names = {"a-0.png", "a-0.25.png", "a-1.png"}) {
    std::filesystem::create_directory(path);
    for (std::size_t i = 0; i < names.size(); ++i) write_png(path / names[i], static_cast<int>(i));
  }
};

std::uint16_t pixel(const Imported& result, std::uint64_t frame, std::size_t at) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  result.session.depth_frame(0, frame, depth_mm);
  return depth_mm[at];
}

std::vector<std::int64_t> times_ms(const Imported& result) {
  std::vector<std::int64_t> times;
  for (const FrameStamp& stamp :
       result.session.stamps(0, FrameStream::depth, 0, result.session.counts(0).depth_frames))
    times.push_back(stamp.arrival_ns / 1'000'000);
  return times;
}

TEST(PngImport, GivesValuesAsTheyAreWrittenAndTimesByTheRate) {
  const Folder folder({"0.png", "1.png", "2.png"});
  const Imported result =
      imported(folder.scratch, "png", {folder.path}, {.rate_hz = 10.0, .depth_unit_mm = 1.0});
  ASSERT_EQ(result.session.counts(0).depth_frames, 3u);
  EXPECT_EQ(pixel(result, 2, 513), 200 + 513);
  EXPECT_THAT(times_ms(result), ElementsAre(0, 100, 200));
}

TEST(PngImport, TakesTimesFromNamesOrFromAFile) {
  const Folder folder;
  const Imported named =
      imported(folder.scratch, "png", {folder.path}, {.depth_unit_mm = 1.0, .time_from_name = true});
  EXPECT_THAT(times_ms(named), ElementsAre(0, 250, 1000));
  std::filesystem::remove(folder.scratch / "session.h5");
  const auto times = text_file(folder.scratch, "times.txt", "5\n5.5\n\n6.125\n");
  const Imported listed =
      imported(folder.scratch, "png", {folder.path}, {.depth_unit_mm = 1.0, .timestamps = times});
  EXPECT_THAT(times_ms(listed), ElementsAre(5000, 5500, 6125));
}

TEST(PngImport, ConvertsOtherUnitsAndRefusesImpossibleOnes) {
  const Folder folder({"0.png"});
  const Imported result =
      imported(folder.scratch, "png", {folder.path}, {.rate_hz = 30.0, .depth_unit_mm = 0.2});
  EXPECT_EQ(pixel(result, 0, 999), 200);
  EXPECT_THAT(import_refusal(folder.scratch, "png", {folder.path}, {.rate_hz = 30.0, .depth_unit_mm = 100.0}),
              HasSubstr("--depth-unit-mm"));
}

TEST(PngImport, TheNoteSaysHowMuchLiesBeyondWhatTheSensorCanMeasure) {
  const Folder folder({"0.png"});
  const Imported near =
      imported(folder.scratch, "png", {folder.path}, {.rate_hz = 30.0, .depth_unit_mm = 1.0});
  // 217,088 pixels count from 0 to 999: every thousandth is 0, and 1 to 499 are too near
  EXPECT_THAT(near.session.header().note,
              HasSubstr("Of 216870 values that are not 0, 108370 (50.0 %) lie outside the 0.5 to 8 m"));
  std::filesystem::remove(folder.scratch / "session.h5");
  const Imported far =
      imported(folder.scratch, "png", {folder.path}, {.rate_hz = 30.0, .depth_unit_mm = 47.0});
  EXPECT_THAT(far.report.note, HasSubstr("up to 47.0 m: are these depth images"));
}

TEST(PngImport, NeverGuessesUnitOrTime) {
  const Folder folder;
  EXPECT_THAT(import_refusal(folder.scratch, "png", {folder.path}, {.rate_hz = 30.0}),
              HasSubstr("--depth-unit-mm"));
  EXPECT_THAT(import_refusal(folder.scratch, "png", {folder.path}, {.depth_unit_mm = 1.0}),
              HasSubstr("all missing"));
  EXPECT_THAT(import_refusal(folder.scratch, "png", {folder.path},
                             {.rate_hz = 30.0, .depth_unit_mm = 1.0, .time_from_name = true}),
              HasSubstr("only one"));
}

TEST(PngImport, RefusesOtherImages) {
  const std::vector<Picture> others{
      {.width = 640, .height = 480}, {.bits = 8}, {.colour = PNG_COLOR_TYPE_RGB}};
  for (const Picture& picture : others) {
    const Folder folder({"0.png"});
    write_png(folder.path / "1.png", 0, picture);
    EXPECT_THAT(import_refusal(folder.scratch, "png", {folder.path}, {.rate_hz = 30.0, .depth_unit_mm = 1.0}),
                testing::AllOf(HasSubstr("1.png"), HasSubstr("512 x 424")));
  }
}

TEST(PngImport, ADamagedImageIsCountedAndLeavesAGap) {
  const Folder folder({"0.png", "1.png", "2.png"});
  std::filesystem::resize_file(folder.path / "1.png", 700);
  const Imported result =
      imported(folder.scratch, "png", {folder.path}, {.rate_hz = 30.0, .depth_unit_mm = 1.0});
  EXPECT_EQ(result.session.counts(0).depth_frames, 2u);
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1);
  EXPECT_EQ(result.report.sensors[0].gap_frames, 1);
}

TEST(PngImport, RefusesTimesThatDoNotFit) {
  const Folder folder;
  const auto refusal = [&](const std::string& times) {
    return import_refusal(
        folder.scratch, "png", {folder.path},
        {.depth_unit_mm = 1.0, .timestamps = text_file(folder.scratch, "times.txt", times)});
  };
  EXPECT_THAT(refusal("1\n2\n"), HasSubstr("2 times for 3 images"));
  EXPECT_THAT(refusal("1\nNaN\n3\n"), HasSubstr("times.txt:2"));
  EXPECT_THAT(refusal("1\n2\n1e300\n"), HasSubstr("times.txt:3"));
  const Folder empty(std::vector<std::string>{});
  EXPECT_THAT(import_refusal(empty.scratch, "png", {empty.path}, {.rate_hz = 30.0, .depth_unit_mm = 1.0}),
              HasSubstr("no .png"));
}

TEST(PngImport, FindsTheLastNumberOfAName) {
  EXPECT_EQ(last_number_in("depth-12.25"), 12.25);
  EXPECT_EQ(last_number_in("2.5_depth"), 2.5);
  EXPECT_EQ(last_number_in("a1b22"), 22.0);
  EXPECT_EQ(last_number_in("a.7"), 7.0);
  EXPECT_EQ(last_number_in("depth"), std::nullopt);
  EXPECT_EQ(last_number_in("1.2.3"), std::nullopt);
}

}  // namespace
}  // namespace trilat
