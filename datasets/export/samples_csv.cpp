// SPDX-License-Identifier: MIT
#include "datasets/export/samples_csv.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/text_output.h"
#include "datasets/export/session_export.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlockInstants = 256;

std::string point_text(const double* point_m) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis)
    text += std::isfinite(point_m[axis]) ? fmt::format(",{:.6f}", point_m[axis]) : ",";
  return text;
}

std::int64_t add_block(TextOutput& text, const SamplesHeader& header, const std::string& take,
                       const SampleBlock& block) {
  const std::size_t joints = header.joints.size(), methods = header.methods.size();
  for (std::size_t i = 0; i < block.instants; ++i)
    for (std::size_t j = 0; j < joints; ++j) {
      const std::size_t joint = i * joints + j;
      const std::string front =
          fmt::format("{},{},{}{}", csv_field(take), block.time_ns.at(i), csv_field(header.joints[j]),
                      point_text(&block.truth_m.at(3 * joint)));
      for (std::size_t m = 0; m < methods; ++m) {
        const std::size_t cell = joint * methods + m;
        const std::size_t status = block.status.at(cell);
        text.add("{},{},{}{}\n", front, csv_field(header.methods[m]),
                 status < header.status_names.size() ? header.status_names[status] : "",
                 point_text(&block.estimate_m.at(3 * cell)));
      }
    }
  return static_cast<std::int64_t>(block.instants * joints * methods);
}

}  // namespace

std::int64_t export_samples_csv(const SamplesFile& samples, const std::filesystem::path& output,
                                const std::function<void(double)>& progress) {
  const SamplesHeader& header = samples.header();
  TextOutput text(output);
  text.add("{}", kSamplesCsvHead);
  std::int64_t rows = 0;
  for (std::size_t t = 0; t < header.takes.size(); ++t) {
    const TakeShape& take = header.takes[t];
    for (std::uint64_t first = 0; first < take.instants; first += kBlockInstants)
      rows += add_block(
          text, header, take.id,
          samples.read(t, first, std::min(kBlockInstants, take.instants - first), SampleColumns::positions));
    if (progress) progress(static_cast<double>(t + 1) / static_cast<double>(header.takes.size()));
  }
  text.publish();
  return rows;
}

}  // namespace trilat
