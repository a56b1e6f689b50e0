// SPDX-License-Identifier: MIT
#include <atomic>
#include <thread>

#include <gmock/gmock.h>

#include "datasets/session/session_reader.h"
#include "tests/datasets/exchanged_dataset.h"

namespace trilat {
namespace {

// Whatever the library writes with the filters that are read must come back: as `h5repack` may have left it.
TEST(StoredRows, EveryPipelineThatIsReadGivesWhatTheLibraryWrote) {
  for (int pipeline = 0; pipeline < 16; ++pipeline) {
    const ScratchFolder folder;
    const auto path = sound_session(folder);
    Creation creation;
    creation.chunks(kChunkRows);
    if (pipeline & 1) H5Pset_shuffle(creation.list);
    if (pipeline & 2) H5Pset_deflate(creation.list, 6);
    if (pipeline & 4) H5Pset_fletcher32(creation.list);
    std::vector<std::int64_t> sequence(kRows);
    for (std::size_t i = 0; i < kRows; ++i)
      sequence[i] = static_cast<std::int64_t>(i) * ((pipeline & 8) != 0 ? 0x123456789abcdefLL : 1);
    exchange(path, kSequence, kRows, creation, [&](hid_t dataset) {
      ASSERT_GE(H5Dwrite(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, sequence.data()), 0);
    });
    const SessionReader session(path);
    const auto stamps = session.stamps(0, FrameStream::bodies, 3, kRows - 3);
    for (std::size_t i = 0; i < stamps.size(); ++i)
      ASSERT_EQ(stamps[i].sequence, sequence[i + 3]) << "pipeline " << pipeline;
  }
}

// Searching the wand reads the stamps of one sensor on all threads.
TEST(StoredRows, ThreadsThatReadTheSameTableGetTheirOwnRows) {
  const ScratchFolder folder;
  SessionHeader header;
  header.sensors.resize(1);
  header.sensors[0].name = "k1";
  SessionWriter writer(folder / "session.h5", header);
  constexpr std::int64_t kFrames = 30'000, kThreads = 3, kShare = kFrames / kThreads, kBlock = 100;
  for (std::int64_t i = 0; i < kFrames; ++i)
    writer.add_body_frame(0, {{i, 333'333 * i, 33'333'300 * i}, {}, {}});
  writer.finish();

  const SessionReader session(folder / "session.h5");
  std::atomic<std::int64_t> wrong{0};
  const auto read_block = [&](std::int64_t first) {
    const auto stamps = session.stamps(0, FrameStream::bodies, static_cast<std::uint64_t>(first), kBlock);
    for (std::int64_t i = 0; i < kBlock; ++i)
      wrong += stamps[static_cast<std::size_t>(i)].sequence != first + i;
  };
  const auto read_share = [&](std::int64_t thread) {  // which lies in chunks of its own, nearly
    for (int pass = 0; pass < 40; ++pass)
      for (std::int64_t first = thread * kShare; first < (thread + 1) * kShare; first += kBlock)
        wrong += message_of([&] { read_block(first); }) != "no error";
  };
  {
    std::vector<std::jthread> threads;
    for (std::int64_t t = 0; t < kThreads; ++t) threads.emplace_back(read_share, t);
  }
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace trilat
