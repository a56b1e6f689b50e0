// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "datasets/import/body_file_reader.h"
#include "datasets/import/import_types.h"

namespace trilat {

// The objects of a file that is one JSON array, each as text, in blocks: the array may be of any length.
class JsonElements {
 public:
  // InputError when the file cannot be opened or does not begin with '['.
  explicit JsonElements(const std::filesystem::path& path);

  // The next object's text; false behind the last. TornRow when the file ends within the array; InputError
  // for an object beyond 1 MiB or anything else than objects.
  bool next(std::string& text);
  // "file.json:line 3, byte 1234", where the object read last begins.
  std::string place() const;
  std::uint64_t bytes_read() const { return byte_; }

 private:
  int get();
  int get_past_blanks();

  std::string path_;
  std::ifstream stream_;
  std::uint64_t byte_ = 0, begin_ = 0;
  std::int64_t line_ = 1, begin_line_ = 1;
  bool ended_ = false, first_ = true;
};

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
