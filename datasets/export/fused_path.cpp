// SPDX-License-Identifier: MIT
#include "datasets/export/fused_path.h"

#include <cmath>

#include "datasets/export/export_frame.h"
#include "datasets/export/session_trc.h"

namespace trilat {

void write_fused_csv(const FusedPath& path, const std::filesystem::path& output) {
  TextOutput text(output);
  text.add("{}", kFusedCsvHead);
  for (std::size_t i = 0; i < path.instants(); ++i)
    for (std::size_t j = 0; j < path.joints.size(); ++j) {
      const FusedPath::Point& point = path.points[i * path.joints.size() + j];
      text.add("{:.6f},{},{},", path.seconds(i), name_of(path.joints[j]), path.status_names[point.status]);
      if (point.is_usable)
        text.add("{:.6f},{:.6f},{:.6f},", point.position_m.x(), point.position_m.y(), point.position_m.z());
      else
        text.add(",,,");
      if (point.is_usable && std::isfinite(point.sigma_m))
        text.add("{:.6f}\n", point.sigma_m);
      else
        text.add("\n");
    }
  text.publish();
}

void write_fused_trc(const FusedPath& path, const std::filesystem::path& output, bool millimetres) {
  TextOutput text(output);
  add_trc_header(text, output, path.rate_hz, static_cast<std::int64_t>(path.instants()), path.joints,
                 millimetres);
  for (std::size_t i = 0; i < path.instants(); ++i) {
    text.add("{}\t{:.6f}", i + 1, path.seconds(i));
    for (std::size_t j = 0; j < path.joints.size(); ++j) {
      const FusedPath::Point& point = path.points[i * path.joints.size() + j];
      add_trc_marker(text, point.is_usable ? point.position_m.data() : nullptr, millimetres);
    }
    text.add("\n");
  }
  text.publish();
}

}  // namespace trilat
