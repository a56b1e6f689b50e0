// SPDX-License-Identifier: MIT
#include "datasets/import/node_kinect2_reader.h"

#include <cerrno>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/strict_json.h"
#include "datasets/import/import_types.h"
#include "datasets/import/joint_cells.h"

namespace trilat {

namespace {

constexpr std::int64_t kTicksPerMs = 1'000'000 / kImportTickNs;
constexpr double kLatestMs = 1e14;  // year 5138

const Json& member(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) throw TornRow{fmt::format("has no \"{}\"", key)};
  return *found;
}

double number_of(const Json& object, const char* key) {
  const Json& value = member(object, key);
  if (!value.is_number()) throw TornRow{fmt::format("has no number in \"{}\"", key)};
  return value.get<double>();
}

std::uint64_t id_of(const Json& object) {
  const Json& value = member(object, "trackingId");
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (!value.is_string()) throw TornRow{"has a trackingId that is neither text nor a whole number"};
  return id_in(value.get_ref<const std::string&>(), "the trackingId");
}

std::uint8_t hand_state_of(const Json& object, const char* key) {
  const double state = number_of(object, key);
  if (!(state >= 0.0 && state <= 4.0) || state != std::floor(state))
    throw TornRow{fmt::format("has {} as {}, which goes from 0 to 4", state, key)};
  return static_cast<std::uint8_t>(state);
}

std::int64_t ticks_of(const Json& object, const std::optional<std::int64_t>& origin_ms) {
  double time_ms = number_of(object, "record_timestamp");
  if (origin_ms) time_ms += number_of(object, "record_startime") - static_cast<double>(*origin_ms);
  if (!(std::abs(time_ms) < kLatestMs)) throw TornRow{"has a time beyond all clocks"};
  return std::llround(time_ms * static_cast<double>(kTicksPerMs));
}

void read_joint(const Json& joint, std::size_t j, Body& body, JointPixels& depth_px) {
  static constexpr std::array kPosition{"cameraX", "cameraY", "cameraZ"};
  static constexpr std::array kOrientation{"orientationX", "orientationY", "orientationZ", "orientationW"};
  if (!joint.is_object()) throw TornRow{"has a joint that is no object"};
  for (std::size_t axis = 0; axis < 3; ++axis)
    body.position_m[j][axis] = static_cast<float>(number_of(joint, kPosition[axis]));
  for (std::size_t axis = 0; axis < 4; ++axis)
    body.orientation_xyzw[j][axis] = static_cast<float>(number_of(joint, kOrientation[axis]));
  depth_px[j] = {kDepthWidth * number_of(joint, "depthX"), kDepthHeight * number_of(joint, "depthY")};
  body.tracking_state[j] = static_cast<std::uint8_t>(TrackingState::tracked);
}

constexpr std::size_t kLongestElement = 1u << 20;
constexpr int kEnd = std::char_traits<char>::eof();

}  // namespace

NodeKinect2Reader::NodeKinect2Reader(const std::filesystem::path& path, std::optional<std::int64_t> origin_ms)
    : elements_(path), origin_ms_(origin_ms), place_(elements_.place()) {}

bool NodeKinect2Reader::next_element(Element& element) {
  element = {};
  const bool found = elements_.next(text_);
  if (!found) return false;
  Json object;
  try {
    object = parse_json(text_, "");
  } catch (const InputError& error) {
    throw TornRow{"cannot be parsed: " + error.problem()};
  }
  element.place = elements_.place();
  element.ticks = ticks_of(object, origin_ms_);
  const Json& tracked = member(object, "tracked");
  if (!tracked.is_boolean()) throw TornRow{"has no true or false in \"tracked\""};
  if (!tracked.get<bool>()) return true;
  const Json& joints = member(object, "joints");
  if (!joints.is_array() || joints.size() != kJointCount)
    throw TornRow{"has another number of joints than 25"};
  Body body;
  body.tracking_id = id_of(object);
  body.hand_state = {hand_state_of(object, "leftHandState"), hand_state_of(object, "rightHandState")};
  for (std::size_t j = 0; j < kJointCount; ++j) read_joint(joints[j], j, body, element.depth_px);
  element.body = body;
  return true;
}

// The element that was looked at before, or the next; what was torn then is torn now.
bool NodeKinect2Reader::take(Element& element) {
  if (torn_) {
    const TornRow row = *torn_;
    torn_.reset();
    place_ = elements_.place();
    throw row;
  }
  if (ahead_) {
    element = *ahead_;
    ahead_.reset();
    place_ = element.place;
    return true;
  }
  try {
    const bool found = next_element(element);
    place_ = elements_.place();
    return found;
  } catch (const TornRow&) {
    place_ = elements_.place();
    throw;
  }
}

// Whether the element belongs to the frame: a body of the same time that is not in it yet.
bool NodeKinect2Reader::belongs(const Element& element, const FileFrame& frame) const {
  if (element.ticks != frame.ticks || frame.bodies.size() >= kMaxBodies) return false;
  for (const Body& body : frame.bodies)
    if (element.body && body.tracking_id == element.body->tracking_id) return false;
  return true;
}

bool NodeKinect2Reader::next(FileFrame& frame) {
  frame = {};
  Element element;
  if (!take(element)) return false;
  frame.ticks = element.ticks;
  while (true) {
    if (element.body) {
      frame.bodies.push_back(*element.body);
      frame.depth_px.push_back(element.depth_px);
    }
    try {
      if (!next_element(element)) return true;
    } catch (const TornRow& row) {
      torn_ = row;
      return true;
    }
    if (belongs(element, frame)) continue;
    ahead_ = element;
    return true;
  }
}

std::optional<std::int64_t> node_kinect2_start_ms(const std::filesystem::path& path) {
  JsonElements elements(path);
  std::string text;
  while (true) {
    try {
      if (!elements.next(text)) return {};
      const double start_ms = number_of(parse_json(text, ""), "record_startime");
      if (std::abs(start_ms) < kLatestMs) return std::llround(start_ms);
    } catch (const TornRow&) {
    } catch (const InputError&) {
      return {};
    }
  }
}

JsonElements::JsonElements(const std::filesystem::path& path)
    : path_(path.string()), stream_(path, std::ios::binary) {
  if (!stream_) throw InputError(path_, std::string("cannot be opened: ") + std::strerror(errno));
  const int c = get_past_blanks();
  if (c != '[') throw InputError(place(), "does not begin with '['; a JSON array of bodies is expected");
}

std::string JsonElements::place() const {
  return path_ + ":" + std::to_string(begin_line_) + " (byte " + std::to_string(begin_) + ")";
}

int JsonElements::get() {
  const int c = stream_.rdbuf()->sbumpc();
  if (c == kEnd) return c;
  ++byte_;
  if (c == '\n') ++line_;
  return c;
}

int JsonElements::get_past_blanks() {
  int c = get();
  while (c == ' ' || c == '\n' || c == '\r' || c == '\t') c = get();
  begin_ = byte_ > 0 ? byte_ - 1 : 0;
  begin_line_ = line_;
  return c;
}

bool JsonElements::next(std::string& text) {
  if (ended_) return false;
  int c = get_past_blanks();
  if (!first_ && c == ',') c = get_past_blanks();
  first_ = false;
  ended_ = c != '{';
  if (c == ']') return false;
  if (c == kEnd) throw TornRow{"is where the file ends, before the array is closed"};
  if (c != '{') throw InputError(place(), "is no object; an array of bodies is expected");
  text.clear();
  int depth = 0;
  bool quoted = false, escaped = false;
  for (; c != kEnd; c = get()) {
    if (text.size() >= kLongestElement)
      throw InputError(place(), "is longer than 1 MiB; a body is much shorter");
    text += static_cast<char>(c);
    if (quoted) {
      if (!escaped && c == '"') quoted = false;
      escaped = !escaped && c == '\\';
      continue;
    }
    quoted = c == '"';
    if (c == '{') ++depth;
    if (c == '}' && --depth == 0) return true;
  }
  ended_ = true;
  throw TornRow{"is an object in which the file ends"};
}

}  // namespace trilat
