// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hdf5.h>

#include "datasets/session/session_writer.h"
#include "tests/support/scratch.h"

namespace trilat {

inline constexpr hsize_t kRows = 40;
inline constexpr hsize_t kChunkRows = 32;
inline const std::string kSequence = "/sensors/k1/body_frames/sequence";

inline std::filesystem::path sound_session(const ScratchFolder& folder) {
  SessionHeader header;
  header.sensors.resize(1);
  header.sensors[0].name = "k1";
  header.sensors[0].has_depth = true;
  SessionWriter writer(folder / "session.h5", header);
  const std::vector<std::uint16_t> depth_mm(kDepthPixels, 1000);
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(kRows); ++i) {
    writer.add_body_frame(0, {{i, 333'333 * i, 33'333'300 * i}, {}, {Body{.tracking_id = 7}}});
    writer.add_clock_exchange(0, {i, i, i, i});
  }
  writer.add_depth_frame(0, encode_depth_frame({0, 0, 0}, depth_mm, ChunkCompression::blosc));
  writer.finish();
  return folder / "session.h5";
}

struct Creation {
  hid_t list = H5Pcreate(H5P_DATASET_CREATE);
  Creation() = default;
  Creation(const Creation&) = delete;
  Creation& operator=(const Creation&) = delete;
  ~Creation() { H5Pclose(list); }
  void chunks(hsize_t rows) { H5Pset_chunk(list, 1, &rows); }
};

// Exchanges a dataset of `path` for one of int64 with so many rows; `fill` may write into it.
inline void exchange(const std::filesystem::path& path, const std::string& name, hsize_t rows,
                     const Creation& creation, const std::function<void(hid_t)>& fill = {}) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  ASSERT_GE(H5Ldelete(file, name.c_str(), H5P_DEFAULT), 0);
  const hsize_t most = H5Pget_layout(creation.list) == H5D_CHUNKED ? H5S_UNLIMITED : rows;
  const hid_t space = H5Screate_simple(1, &rows, &most);
  const hid_t dataset =
      H5Dcreate2(file, name.c_str(), H5T_STD_I64LE, space, H5P_DEFAULT, creation.list, H5P_DEFAULT);
  ASSERT_GE(dataset, 0);
  if (fill) fill(dataset);
  H5Dclose(dataset);
  H5Sclose(space);
  ASSERT_GE(H5Fclose(file), 0);
}

}  // namespace trilat
