// SPDX-License-Identifier: MIT
#include "recorders/open_source.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/time.h"
#include "datasets/synthetic/depth/room_scene.h"
#include "recorders/frame_source.h"

namespace trilat {
namespace {

const Eigen::Vector3d kRigCentre_m(0.0, 1.0, 0.0);

// KIND:WHAT,KEY=VALUE,…
struct SourceText {
  std::string place, kind, what;
  std::map<std::string, std::string> settings;

  [[noreturn]] void refuse(const std::string& problem) const { throw InputError(place, problem); }

  std::optional<std::string> take(const std::string& key) {
    const auto found = settings.find(key);
    if (found == settings.end()) return std::nullopt;
    std::string value = found->second;
    settings.erase(found);
    return value;
  }
  double number(const std::string& key, const std::string& text, double least, double most) const {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !(value >= least && value <= most))
      refuse(fmt::format("{} must be a number from {} to {}, is \"{}\"", key, least, most, text));
    return value;
  }
  double take_number(const std::string& key, double otherwise, double least, double most) {
    const auto text = take(key);
    return text ? number(key, *text, least, most) : otherwise;
  }
  void refuse_the_rest(const std::string& known) const {
    if (!settings.empty())
      refuse("a " + kind + " source has no setting \"" + settings.begin()->first + "\"; it has " + known);
  }
};

SourceText parse(const std::string& text, const std::string& place) {
  SourceText result{place, {}, {}, {}};
  const std::size_t colon = text.find(':');
  result.kind = text.substr(0, colon);
  if (colon == std::string::npos) return result;
  std::size_t begin = colon + 1;
  for (bool first = true; begin <= text.size(); first = false) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.find('=');
    if (first)
      result.what = part;
    else if (equals == std::string::npos)
      result.refuse("settings of a source are KEY=VALUE, \"" + part + "\" is not");
    else if (!result.settings.emplace(part.substr(0, equals), part.substr(equals + 1)).second)
      result.refuse("\"" + part.substr(0, equals) + "\" is set twice");
    begin = end + 1;
  }
  return result;
}

double take_speed(SourceText& text) {
  const auto speed = text.take("speed");
  if (!speed) return 1.0;
  return *speed == "max" ? 0.0 : text.number("speed", *speed, 0.01, 1000.0);
}

SyntheticRequest read_synthetic(SourceText text) {
  SyntheticRequest request;
  if (!text.what.empty())
    request.sensors = static_cast<std::size_t>(text.number("the number of sensors", text.what, 1, 16));
  request.seed = static_cast<std::uint64_t>(text.take_number("seed", 1, 0, 1e15));
  request.duration_s = text.take_number("duration", request.duration_s, 0.1, 1e6);
  if (const auto depth = text.take("depth")) {
    constexpr std::array<std::string_view, 3> kDepths{"no", "yes", "wand"};
    const auto* found = std::ranges::find(kDepths, *depth);
    if (found == kDepths.end()) text.refuse("depth must be yes, no or wand, is \"" + *depth + '"');
    request.depth = static_cast<SyntheticRequest::Depth>(found - kDepths.begin());
  }
  request.live.speed = take_speed(text);
  request.live.stamp_arrivals = request.live.speed == 1.0;
  request.live.one_clock = true;
  request.live.origin_ns = kMotionStart.ns;
  text.refuse_the_rest("seed, depth, duration, speed");
  return request;
}

std::unique_ptr<FrameSource> open_synthetic(const SyntheticRequest& request) {
  const SyntheticSetup setup = setup_of(request);
  std::optional<SyntheticDepth> depth;
  if (request.depth != SyntheticRequest::Depth::none) {
    const SceneMotion scene = [motion = setup.motion, wand = setup.wand,
                               room = setup.simulation.room](double time_s) {
      DepthScene result;
      append_room(result, room, kRigCentre_m);
      if (wand)
        append_wand_instant(result, wand->at(time_s), {}, true);
      else
        append_person(result, motion(time_s));
      return result;
    };
    depth = SyntheticDepth{scene, setup.simulation.depth.noise, {}};
  }
  auto source =
      std::make_unique<SyntheticSource>(setup.simulation.sensor, setup.item, setup.motion, setup.sensors,
                                        request.duration_s, default_body_tracker(), std::move(depth));
  constexpr std::size_t kEventsAhead = 64;  // 14 MB of depth, a quarter of a second of four sensors
  return std::make_unique<LiveSource>(std::make_unique<PrefetchSource>(std::move(source), kEventsAhead),
                                      request.live);
}

}  // namespace

// All sensors share the clock of the machine that they are simulated on, as sensors that are plugged into it.
SyntheticSetup setup_of(const SyntheticRequest& request) {
  SyntheticSetup setup;
  setup.simulation.seed = request.seed;
  setup.simulation.sensor.dropped_share = 0.0;
  const std::vector<double> heights_m = setup.simulation.rig.heights_m;
  setup.simulation.rig.heights_m.resize(request.sensors);
  for (std::size_t s = 0; s < request.sensors; ++s)
    setup.simulation.rig.heights_m[s] = heights_m[s % heights_m.size()];
  setup.item = {request.seed, 0, 0};
  const Person person =
      draw_person(request.seed, 0, setup.simulation.stature.mean_m, setup.simulation.stature.half_range_m);
  setup.motion = generated_motion(person, Activity::walking);
  if (request.depth == SyntheticRequest::Depth::wand) {
    setup.wand.emplace(WandMotionSpec{}, request.seed, kRigCentre_m, person);
    setup.motion = [wand = *setup.wand](double time_s) {
      const WandInstant instant = wand.at(time_s);
      return instant.is_held ? instant.person : SkeletonPose();
    };
  }
  for (const SensorPose& pose : rig_poses(setup.simulation.rig, kRigCentre_m)) {
    setup.sensors.push_back(draw_sensor(setup.simulation.sensor, setup.item, setup.sensors.size(), pose));
    setup.sensors.back().agent_from_host = {kMotionStart, {kMotionStart.ns}, 0.0};
  }
  return setup;
}

std::optional<SyntheticRequest> synthetic_request(const std::string& text) {
  const SourceText parsed = parse(text, "--source");
  if (parsed.kind != "synthetic") return std::nullopt;
  return read_synthetic(parsed);
}

std::unique_ptr<FrameSource> open_source(const std::string& text, const std::string& place, SourceUse use) {
  const SourceText parsed = parse(text, place);
  if (use == SourceUse::agent && parsed.settings.count("speed") > 0 && parsed.settings.at("speed") != "1")
    parsed.refuse("an agent's source has real speed only; leave \"speed\" out");
  if (parsed.kind == "synthetic") return open_synthetic(read_synthetic(parsed));
  if (parsed.kind == "kinect")
    parsed.refuse("the Kinect SDK is on Windows only: there `trilat-agent.exe run` sends what it delivers");
  parsed.refuse("there is no source \"" + parsed.kind + "\"; there is synthetic:4");
}

std::string source_help() {
  return "synthetic:N (N virtual Kinects; with ,seed=1 ,depth=yes|no|wand ,duration=SECONDS ,speed=FACTOR or "
         ",speed=max)";
}

PrefetchSource::PrefetchSource(std::unique_ptr<FrameSource> inner, std::size_t events_ahead)
    : inner_(std::move(inner)), events_ahead_(events_ahead), thread_([this] { fetch(); }) {}

PrefetchSource::~PrefetchSource() {
  stop();
  thread_.join();
}

void PrefetchSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  inner_->stop();
  changed_.notify_all();
}

void PrefetchSource::fetch() {
  std::exception_ptr failure;
  try {
    while (auto event = inner_->next()) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopped_ || events_.size() < events_ahead_; });
      if (stopped_) break;
      events_.push_back(std::move(*event));
      changed_.notify_all();
    }
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  failure_ = failure;
  ended_ = true;
  changed_.notify_all();
}

std::optional<SourceEvent> PrefetchSource::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stopped_ || ended_ || !events_.empty(); });
  if (stopped_) return std::nullopt;
  if (events_.empty()) {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return std::nullopt;
  }
  SourceEvent event = std::move(events_.front());
  events_.pop_front();
  changed_.notify_all();
  return event;
}

namespace {

FrameStamp* stamp_of(SourceEvent& event) {
  if (auto* frame = std::get_if<BodyFrame>(&event.data)) return &frame->stamp;
  if (auto* frame = std::get_if<DepthFrame>(&event.data)) return &frame->stamp;
  return nullptr;
}

}  // namespace

LiveSource::LiveSource(std::unique_ptr<FrameSource> inner, const LiveOptions& options)
    : inner_(std::move(inner)),
      options_(options),
      first_arrival_ns_(inner_->header().sensors.size()),
      lost_(first_arrival_ns_.size(), 0),
      last_lost_(first_arrival_ns_.size(), -1) {}

std::int64_t LiveSource::start() {
  if (!start_ns_) {
    look_ahead();  // what is due first is made before the clock starts
    start_ns_ = host_now_ns();
  }
  return *start_ns_;
}

void LiveSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  stop_changed_.notify_all();
  inner_->stop();
}

std::int64_t LiveSource::due_ns(const SourceEvent& event) {
  auto& first = first_arrival_ns_.at(event.sensor);
  if (const auto* exchange = std::get_if<ClockExchange>(&event.data))
    return exchange->t4_ns - options_.origin_ns;
  if (const FrameStamp* stamp = stamp_of(const_cast<SourceEvent&>(event))) {
    // arrivals may be on a clock of another machine, whose first frame comes near the start
    if (!first) first = stamp->arrival_ns;
    return options_.one_clock ? stamp->arrival_ns - options_.origin_ns : stamp->arrival_ns - *first;
  }
  return 0;
}

bool LiveSource::wait_until(std::int64_t host_ns) {
  std::unique_lock lock(mutex_);
  stop_changed_.wait_for(lock, std::chrono::nanoseconds(host_ns - host_now_ns()), [&] { return stopped_; });
  return !stopped_;
}

void LiveSource::move_to_now(SourceEvent& event) const {
  const std::int64_t by_ns = *start_ns_ - options_.origin_ns;
  if (FrameStamp* stamp = stamp_of(event))
    stamp->arrival_ns = options_.stamp_arrivals ? host_now_ns() : stamp->arrival_ns + by_ns;
  if (auto* e = std::get_if<ClockExchange>(&event.data))
    for (std::int64_t* t : {&e->t1_ns, &e->t2_ns, &e->t3_ns, &e->t4_ns}) *t += by_ns;
  if (auto* count = std::get_if<DropCount>(&event.data)) count->host_ns += by_ns;
}

void LiveSource::look_ahead() {
  // bodies, depth and an exchange of every sensor, for two frame numbers
  const std::size_t events_ahead = 6 * header().sensors.size();
  while (ahead_.size() < events_ahead) {
    std::optional<SourceEvent> event = inner_->next();
    if (!event) return;
    // an exchange with the clock of a simulated machine says nothing about stamps of this one
    if (options_.stamp_arrivals && std::holds_alternative<ClockExchange>(event->data)) continue;
    const std::int64_t due = due_ns(*event);
    ahead_.emplace(due, std::move(*event));
  }
}

std::optional<std::pair<std::int64_t, SourceEvent>> LiveSource::earliest() {
  look_ahead();
  if (ahead_.empty()) return std::nullopt;
  auto node = ahead_.extract(ahead_.begin());
  return std::pair{node.key(), std::move(node.mapped())};
}

bool LiveSource::too_late(const SourceEvent& event, std::int64_t due_host_ns) const {
  constexpr std::int64_t kLate_ns = 200'000'000;  // six frames
  return options_.stamp_arrivals && stamp_of(const_cast<SourceEvent&>(event)) &&
         host_now_ns() - due_host_ns > kLate_ns;
}

// A frame whose bodies and depth are both lost is lost once.
SourceEvent LiveSource::lost(const SourceEvent& event) {
  const std::size_t s = event.sensor;
  const std::int64_t number = stamp_of(const_cast<SourceEvent&>(event))->sequence;
  if (number != last_lost_[s]) ++lost_[s];
  last_lost_[s] = number;
  return {s, DropCount{host_now_ns(), lost_[s], 0}};
}

std::optional<SourceEvent> LiveSource::next() {
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return std::nullopt;
  }
  const std::int64_t start_ns = start();
  auto first = earliest();
  if (!first) return std::nullopt;
  auto& [due, event] = *first;
  const std::int64_t due_host_ns =
      options_.speed > 0.0 ? start_ns + static_cast<std::int64_t>(static_cast<double>(due) / options_.speed)
                           : 0;
  if (options_.speed > 0.0 && !wait_until(due_host_ns)) return std::nullopt;
  if (too_late(event, due_host_ns)) return lost(event);
  move_to_now(event);
  return std::move(event);
}

}  // namespace trilat
