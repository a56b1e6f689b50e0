// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "datasets/import/body_file_reader.h"
#include "datasets/import/import_types.h"
#include "datasets/import/json_elements.h"

namespace trilat {

// recorded_skeleton.json of Kinectron, which records what node-kinect2 hands over: an array with an object
// for each body and frame. Bodies of the same time belong to one frame. Positions in metres, pixels as shares
// of the depth image; no tracking states.
class NodeKinect2Reader : public BodyFileReader {
 public:
  // Times count from `origin_ms` of the calendar clock; nothing: from the file's own beginning, whenever that
  // was.
  NodeKinect2Reader(const std::filesystem::path& path, std::optional<std::int64_t> origin_ms);
  bool next(FileFrame& frame) override;
  std::string place() const override { return place_; }
  std::uint64_t bytes_read() const override { return elements_.bytes_read(); }

 private:
  struct Element {
    std::string place{};
    std::int64_t ticks = 0;
    std::optional<Body> body{};  // nothing when it is not tracked
    JointPixels depth_px{};
  };
  bool next_element(Element& element);
  bool take(Element& element);
  bool belongs(const Element& element, const FileFrame& frame) const;

  JsonElements elements_;
  std::optional<std::int64_t> origin_ms_;
  std::string text_;
  std::string place_;
  std::optional<Element> ahead_{};
  std::optional<TornRow> torn_{};
};

// When the first body that says so was recorded from, in milliseconds since 1970; nothing when none does.
std::optional<std::int64_t> node_kinect2_start_ms(const std::filesystem::path& path);

}  // namespace trilat
