// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "datasets/export/export_frame.h"

namespace trilat {

// One row a frame, body and joint, all sensors one after the other. Returns the number of rows.
std::int64_t export_session_csv(const SessionReader& session, const std::filesystem::path& output,
                                const ExportOptions& options);

}  // namespace trilat
