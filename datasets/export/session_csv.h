// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "datasets/export/export_frame.h"

namespace trilat {

inline constexpr const char* kSessionCsvHead =
    "sensor,sequence,device_ticks,arrival_ns,time_s,tracking_id,joint,state,x_m,y_m,z_m,qx,qy,qz,qw\n";

// One row a frame, body and joint, all sensors one after the other. Returns the number of rows.
std::int64_t export_session_csv(const SessionReader& session, const std::filesystem::path& output,
                                const ExportOptions& options);

}  // namespace trilat
