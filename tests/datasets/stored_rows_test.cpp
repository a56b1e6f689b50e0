// SPDX-License-Identifier: MIT
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

}  // namespace
}  // namespace trilat
