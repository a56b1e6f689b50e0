// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/wait.h>
#include <unistd.h>

#include "datasets/base/files.h"
#include "datasets/session/event_log.h"
#include "datasets/session/session_types.h"

namespace trilat {

inline SessionHeader header_of(std::size_t sensors, bool depth = false) {
  SessionHeader header;
  header.simulated = true;
  for (std::size_t i = 0; i < sensors; ++i) {
    SensorDescription sensor;
    sensor.name = "k" + std::to_string(i);
    sensor.serial = "0000" + std::to_string(i);
    sensor.source = "simulated";
    sensor.has_depth = depth;
    header.sensors.push_back(sensor);
  }
  return header;
}

inline Body body_of(std::uint64_t id, float offset) {
  Body body;
  body.tracking_id = id;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    body.position_m[j] = {offset + static_cast<float>(j), -offset, 2.0f};
    body.tracking_state[j] = static_cast<std::uint8_t>(j % 3);
  }
  body.hand_state = {2, 3};
  return body;
}

inline BodyFrame body_frame_of(std::int64_t i, std::size_t bodies) {
  BodyFrame frame;
  frame.stamp = {i, 1000 + i * 333'333, 5'000'000'000 + i * 33'333'300};
  frame.floor_plane = {0, 1, 0, 1.5f};
  for (std::size_t b = 0; b < bodies; ++b)
    frame.bodies.push_back(body_of((std::uint64_t{1} << 56) + b + 1, static_cast<float>(i)));
  return frame;
}

inline std::vector<std::uint16_t> depth_of(std::uint16_t seed) {
  std::vector<std::uint16_t> depth(kDepthPixels);
  for (std::size_t p = 0; p < depth.size(); ++p)
    depth[p] = static_cast<std::uint16_t>(p % 7 == 0 ? 0 : 2000 + seed + (p * 31) % 50);
  return depth;
}

// A finished session made as a recorder of version 0.4.0 left it when it was killed: under its unfinished
// name, not complete, marked as open for writing, and with the numbers of rows that it said were flushed
// (body frames, bodies, depth frames, clock exchanges, drop counts, notices).
inline std::filesystem::path killed_by_0_4(const std::filesystem::path& session, std::int64_t body_frames,
                                           std::int64_t depth_frames) {
  const std::filesystem::path partial = partial_name(session);
  std::filesystem::rename(session, partial);
  const pid_t child = fork();
  if (child == 0) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    const hid_t file = H5Fopen(partial.c_str(), H5F_ACC_RDWR, access);
    const hid_t complete = H5Aopen(file, "complete", H5P_DEFAULT);
    const std::int64_t no = 0;
    H5Awrite(complete, H5T_NATIVE_INT64, &no);
    H5Aclose(complete);
    const hsize_t rows[]{1, 6}, most[]{H5S_UNLIMITED, 6}, chunk[]{32, 6};
    const std::int64_t flushed[]{body_frames, body_frames, depth_frames, 1000, 1000, 1000};
    const hid_t space = H5Screate_simple(2, rows, most), list = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(list, 2, chunk);
    const hid_t table =
        H5Dcreate2(file, "/sensors/k0/flushed", H5T_STD_I64LE, space, H5P_DEFAULT, list, H5P_DEFAULT);
    const bool ok = H5Dwrite(table, H5T_STD_I64LE, H5S_ALL, H5S_ALL, H5P_DEFAULT, flushed) >= 0;
    H5Dclose(table);
    H5Fclose(file);
    const hid_t again = H5Fopen(partial.c_str(), H5F_ACC_RDWR | H5F_ACC_SWMR_WRITE, access);
    _exit(ok && again >= 0 ? 0 : 1);  // without closing it
  }
  int status = 1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  return partial;
}

// A person of 1.75 m, 2.5 m before the sensor, arms stretched out.
inline Body standing_body() {
  constexpr std::array<std::array<float, 2>, kJointCount> kPlaces_m{
      {{0, 0},         {0, 0.3F},      {0, 0.58F},     {0, 0.74F},      {-0.18F, 0.5F},
       {-0.46F, 0.5F}, {-0.7F, 0.5F},  {-0.78F, 0.5F}, {0.18F, 0.5F},   {0.46F, 0.5F},
       {0.7F, 0.5F},   {0.78F, 0.5F},  {-0.09F, 0},    {-0.11F, -0.4F}, {-0.12F, -0.8F},
       {-0.2F, -0.9F}, {0.09F, 0},     {0.11F, -0.4F}, {0.12F, -0.8F},  {0.2F, -0.9F},
       {0, 0.52F},     {-0.86F, 0.5F}, {-0.8F, 0.55F}, {0.86F, 0.5F},   {0.8F, 0.55F}}};
  Body body{};
  body.tracking_id = 1;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    body.position_m[j] = {kPlaces_m[j][0], kPlaces_m[j][1], 2.5F};
    body.tracking_state[j] = 2;
  }
  for (const Joint foot : {Joint::foot_left, Joint::foot_right})  // towards the sensor, before the ankles
    body.position_m[static_cast<std::size_t>(foot)][2] = 2.38F;
  return body;
}

// Returns the head of a recorder's log, whose `id` differs from log to log.
inline LogHead head_with(SessionHeader session, std::uint64_t id = 7) {
  return {id, 0, 5'000'000'000, 0, "", std::move(session)};
}

}  // namespace trilat
