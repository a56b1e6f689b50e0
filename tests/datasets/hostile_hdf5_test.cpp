// SPDX-License-Identifier: MIT
// Files that were made to mislead: sound ones of which one dataset was exchanged.
#include <utility>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/results/stored_take.h"
#include "datasets/session/session_reader.h"
#include "tests/datasets/exchanged_dataset.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string problem_with(const std::filesystem::path& path) {
  return message_of([&] {
    const SessionReader session(path);
    session.body_frames(0, 0, session.counts(0).body_frames);
  });
}

TEST(HostileHdf5, RowsThatTheFileHasNoRoomForAreRefused) {
  for (const hsize_t rows : {hsize_t{1} << 40, hsize_t{1} << 59}) {
    const ScratchFolder folder;
    const auto path = sound_session(folder);
    Creation chunked;
    chunked.chunks(kChunkRows);
    exchange(path, kSequence, rows, chunked);
    EXPECT_THAT(problem_with(path), AllOf(HasSubstr(kSequence), HasSubstr("more than the file holds")));
  }
  const ScratchFolder folder;
  const auto path = sound_session(folder);
  exchange(path, kSequence, hsize_t{1} << 40, Creation());
  EXPECT_THAT(problem_with(path), AllOf(HasSubstr(kSequence), HasSubstr("claims 1099511627776 rows")));
}

TEST(HostileHdf5, ChunksOfGigabytesAreRefused) {
  const ScratchFolder folder;
  const auto path = sound_session(folder);
  Creation creation;
  creation.chunks(hsize_t{1} << 27);
  exchange(path, kSequence, kRows, creation);
  EXPECT_THAT(problem_with(path), AllOf(HasSubstr(kSequence), HasSubstr("chunks of more than 16 MB")));
}

// Of fewer bytes than a checksum there is nothing to take off.
TEST(HostileHdf5, AChunkWithoutRoomForItsChecksumIsDamaged) {
  for (const std::size_t bytes : {0, 1, 3}) {
    std::vector<std::byte> chunk(bytes), raw(8);
    for (const auto compression :
         {ChunkCompression::none, ChunkCompression::blosc, ChunkCompression::deflate})
      EXPECT_FALSE(decode_chunk(chunk, compression, raw)) << bytes;
  }
}

// A Blosc chunk says itself how many bytes it holds, and the filter is told.
TEST(HostileHdf5, ABloscChunkThatLiesAboutItsSizeIsRefused) {
  for (const auto& [bytes, told] : {std::pair<std::size_t, unsigned>{8, 8 * kChunkRows},
                                    {1 << 20, 8 * kChunkRows},
                                    {8 * kChunkRows, 8},
                                    {8 * kChunkRows, 1u << 20},
                                    {8 * kChunkRows, 0}}) {
    const ScratchFolder folder;
    const auto path = sound_session(folder);
    Creation creation;
    creation.chunks(kChunkRows);
    const unsigned values[] = {2, 2, 8, told};
    H5Pset_filter(creation.list, kBloscFilter, H5Z_FLAG_MANDATORY, told == 0 ? 0 : std::size(values), values);
    H5Pset_fletcher32(creation.list);
    const auto chunk = encode_chunk(std::vector<std::byte>(bytes), 8, ChunkCompression::blosc);
    exchange(path, kSequence, kRows, creation, [&](hid_t dataset) {
      for (const hsize_t first : {hsize_t{0}, kChunkRows})
        ASSERT_GE(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, &first, chunk.size(), chunk.data()), 0);
    });
    EXPECT_THAT(problem_with(path), AllOf(HasSubstr(kSequence), HasSubstr("damaged"))) << bytes;
  }
}

// A chunk whose writer left a filter out holds other bytes than the dataset says.
TEST(HostileHdf5, ADepthFrameWithoutOneOfItsFiltersIsDamaged) {
  const ScratchFolder folder;
  const auto path = sound_session(folder);
  const auto read = [&] { SessionReader(path).stored_depth_frame(0, 0); };
  EXPECT_EQ(message_of(read), "no error");
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, "/sensors/k1/depth/frame_mm", H5P_DEFAULT);
  const std::vector<std::byte> raw(kDepthPixels * 2 + 4);
  const hsize_t first[] = {0, 0, 0};
  ASSERT_GE(H5Dwrite_chunk(dataset, H5P_DEFAULT, 1, first, raw.size(), raw.data()), 0);
  H5Dclose(dataset);
  H5Fclose(file);
  EXPECT_THAT(message_of(read), HasSubstr("the stored data are damaged (row 0)"));
}

TEST(HostileHdf5, RowsInAnotherFileAreNotRead) {
  const ScratchFolder folder;
  const auto path = sound_session(folder);
  write_file(folder / "secret", std::string(8 * kRows, 's'));
  Creation external;
  H5Pset_external(external.list, (folder / "secret").c_str(), 0, 8 * kRows);
  exchange(path, kSequence, kRows, external);
  EXPECT_THAT(problem_with(path), AllOf(HasSubstr(kSequence), HasSubstr("another file")));

  const auto other = sound_session(folder);
  const std::filesystem::path source = folder / "source.h5";
  std::filesystem::copy_file(other, source);
  Creation together;
  const hid_t space = H5Screate_simple(1, &kRows, nullptr);
  ASSERT_GE(H5Pset_virtual(together.list, space, source.c_str(), kSequence.c_str(), space), 0);
  H5Sclose(space);
  exchange(other, kSequence, kRows, together);
  EXPECT_THAT(problem_with(other), AllOf(HasSubstr(kSequence), HasSubstr("another file")));
}

TEST(HostileHdf5, LinksOutOfTheFileAndByNameAreNotFollowed) {
  const ScratchFolder folder;
  const auto source = sound_session(folder);
  std::filesystem::copy_file(source, folder / "other.h5");
  for (const bool external : {false, true}) {
    const auto path = sound_session(folder);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const std::string moved = "/sensors/k1/body_frames/moved";
    H5Lmove(file, kSequence.c_str(), file, moved.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (external)
      H5Lcreate_external((folder / "other.h5").c_str(), kSequence.c_str(), file, kSequence.c_str(),
                         H5P_DEFAULT, H5P_DEFAULT);
    else
      H5Lcreate_soft(moved.c_str(), file, kSequence.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    ASSERT_GE(H5Fclose(file), 0);
    EXPECT_THAT(problem_with(path), AllOf(HasSubstr(kSequence), HasSubstr("is missing"))) << external;
  }
}

TEST(HostileHdf5, AGroupThatHoldsItselfIsRefused) {
  const ScratchFolder folder;
  const auto path = sound_session(folder);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Lcreate_hard(file, "/sensors", file, "/sensors/loop", H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Fclose(file), 0);
  EXPECT_THAT(problem_with(path), HasSubstr("/sensors/loop@serial"));
}

TEST(HostileHdf5, NoFileMakesTheProgramLoadCode) {
  const ScratchFolder folder;
  const auto path = sound_session(folder);
  Creation creation;
  creation.chunks(kChunkRows);
  constexpr H5Z_filter_t kSomebodysFilter = 40'000;
  H5Pset_filter(creation.list, kSomebodysFilter, H5Z_FLAG_OPTIONAL, 0, nullptr);
  exchange(path, kSequence, kRows, creation);
  EXPECT_THAT(problem_with(path), AllOf(HasSubstr(kSequence), HasSubstr("uses filters that are not read")));
  unsigned plugins = 1;
  ASSERT_GE(H5PLget_loading_state(&plugins), 0);
  EXPECT_EQ(plugins, 0u);
}

TEST(HostileHdf5, OtherTypesAndRanksAreRefused) {
  for (const char* name : {"/sensors/k1/body_frames/body_count", "/sensors/k1/clock_exchanges_ns"}) {
    const ScratchFolder folder;
    const auto path = sound_session(folder);
    Creation chunked;
    chunked.chunks(kChunkRows);
    exchange(path, name, kRows, chunked);
    EXPECT_THAT(problem_with(path), AllOf(HasSubstr(name), HasSubstr(" is wanted, ")));
  }
}

TEST(HostileHdf5, WhatIsWantedAndWhatIsThereIsSaidWithTypeAndShape) {
  const ScratchFolder folder;
  H5File file = H5File::create(folder / "some.h5");
  file.create_table("numbers", H5Type::f32, {25, 3}, {}, 2);
  file.create_group("parts");
  const auto asked = [&](const char* name, H5Type type, const std::vector<std::uint64_t>& shape) {
    return message_of([&] { static_cast<void>(file.table(name, type, shape)); });
  };
  EXPECT_EQ(asked("numbers", H5Type::f32, {25, 3}), "no error");
  EXPECT_THAT(asked("numbers", H5Type::i64, {25, 3}),
              HasSubstr("some.h5:/numbers: int64 (N, 25, 3) is wanted, float32 (N, 25, 3) is there"));
  EXPECT_THAT(asked("numbers", H5Type::f32, {4}),
              HasSubstr("float32 (N, 4) is wanted, float32 (N, 25, 3) is there"));
  EXPECT_THAT(asked("parts", H5Type::u8, {}), HasSubstr("some.h5:/parts: is not a dataset"));
  EXPECT_THAT(asked("absent", H5Type::u8, {}), HasSubstr("some.h5:/absent: is missing"));
}

TEST(HostileHdf5, AnAttributeOfManyMegabytesIsRefused) {
  const ScratchFolder folder;
  const auto path = sound_session(folder);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Adelete(file, "note");
  const hsize_t count = 4000;
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate_simple(1, &count, nullptr);
  H5Tset_size(type, 1000);
  const hid_t attribute = H5Acreate2(file, "note", type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
  ASSERT_GE(H5Fclose(file), 0);
  EXPECT_THAT(problem_with(path), AllOf(HasSubstr("note"), HasSubstr("a kind or size")));
}

TEST(HostileHdf5, SamplesThatWouldFillTheMemoryAreRefused) {
  const ScratchFolder folder;
  StoredTake::create(folder / "take.h5", {"a", "walking", 5, {"head"}, {"linear"}, {"mocap"}, {"converged"}})
      .finish();
  const hid_t file = H5Fopen((folder / "take.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hsize_t count = 4000;
  for (const char* name : {"methods", "joints"}) {
    const hid_t space = H5Screate_simple(1, &count, nullptr), type = H5Tcopy(H5T_C_S1);
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    H5Tset_cset(type, H5T_CSET_UTF8);
    H5Adelete(file, name);
    const hid_t texts = H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    ASSERT_GE(H5Awrite(texts, type, std::string(count, 'm').c_str()), 0);
    H5Aclose(texts);
    H5Tclose(type);
    H5Sclose(space);
  }
  ASSERT_GE(H5Fclose(file), 0);
  EXPECT_THAT(message_of([&] { StoredTake::open(folder / "take.h5"); }),
              HasSubstr("4000 joints x 4000 methods"));
}

TEST(HostileHdf5, SamplesWithMoreRowsThanBytesAreRefused) {
  const ScratchFolder folder;
  StoredTake::create(folder / "take.h5", {"a", "walking", 5, {"head"}, {"linear"}, {"mocap"}, {"converged"}})
      .finish();
  exchange(folder / "take.h5", "/samples/0/time_ns", hsize_t{1} << 40, Creation());
  EXPECT_THAT(message_of([&] { StoredTake::open(folder / "take.h5"); }),
              AllOf(HasSubstr("time_ns"), HasSubstr("claims")));
}

}  // namespace
}  // namespace trilat
