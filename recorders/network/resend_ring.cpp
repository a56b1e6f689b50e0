// SPDX-License-Identifier: MIT
#include "recorders/network/resend_ring.h"

#include <algorithm>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::size_t kItemBytes = 128;  // what an item costs beside its content

}  // namespace

ResendRing::ResendRing(std::size_t sensors, std::size_t limit_bytes, bool may_drop)
    : limit_bytes_(limit_bytes), may_drop_(may_drop), totals_(sensors) {}

void ResendRing::push(SourceEvent event) {
  TRILAT_CHECK(event.sensor < totals_.size(), "an event belongs to a sensor of its source");
  if (std::holds_alternative<ClockExchange>(event.data)) return;  // between other clocks than ours
  if (const auto* count = std::get_if<DropCount>(&event.data)) {
    totals_[event.sensor].before_ring = count->at_source + count->in_queue;
    return tell_totals(event.sensor);
  }
  if (is_torn(event)) {
    ++totals_[event.sensor].torn;
    return tell_totals(event.sensor);
  }
  Item item{next_number_, event.sensor, Bye{}};
  item.frame = !std::holds_alternative<SourceNotice>(event.data);
  const auto as_message = [&](auto data) {
    const EventMessage message{item.number, static_cast<std::uint32_t>(item.sensor), std::move(data)};
    item.content = std::make_shared<const std::vector<std::byte>>(encode_message(message));
  };
  if (auto* pixels = std::get_if<DepthFrame>(&event.data))
    item.content = std::move(*pixels);
  else if (auto* depth = std::get_if<EncodedDepthFrame>(&event.data))
    as_message(std::move(*depth));
  else if (auto* body = std::get_if<BodyFrame>(&event.data))
    as_message(std::move(*body));
  else
    as_message(std::get<SourceNotice>(event.data));
  add(std::move(item));
  shrink();
}

void ResendRing::add(Item item) {
  item.bytes = kItemBytes;
  if (const auto* pixels = std::get_if<DepthFrame>(&item.content)) item.bytes += pixels->depth_mm.size() * 2;
  if (const auto* bytes = std::get_if<Bytes>(&item.content)) item.bytes += (*bytes)->size();
  bytes_ += item.bytes;
  ++next_number_;
  items_.push_back(std::move(item));
}

void ResendRing::shrink() {
  const std::uint64_t newest = items_.back().number;
  while (may_drop_ && bytes_ > limit_bytes_) {
    const auto oldest = std::ranges::find_if(items_, &Item::frame);
    if (oldest == items_.end() || oldest->number == newest) return;
    const std::size_t sensor = oldest->sensor;
    const bool offered = oldest->offered;
    if (offered) uncertain_.emplace_back(oldest->number, sensor);
    drop(oldest);
    if (!offered) count_lost(sensor);
  }
}

void ResendRing::drop(std::deque<Item>::iterator item) {
  bytes_ -= item->bytes;
  items_.erase(item);
}

void ResendRing::count_lost(std::size_t sensor) {
  ++totals_[sensor].in_ring;
  tell_totals(sensor);
}

void ResendRing::tell_totals(std::size_t sensor) {
  if (totals_[sensor].item) return;
  totals_[sensor].item = next_number_;
  add({next_number_, sensor, DropTotals{}});
}

std::deque<ResendRing::Item>::iterator ResendRing::find(std::uint64_t number) {
  return std::ranges::lower_bound(items_, number, {}, &Item::number);
}

std::optional<std::pair<std::uint64_t, DepthFrame>> ResendRing::fetch_pixels() {
  for (auto item = find(unfetched_); item != items_.end(); ++item) {
    unfetched_ = item->number + 1;
    auto* pixels = std::get_if<DepthFrame>(&item->content);
    if (!pixels) continue;
    std::pair<std::uint64_t, DepthFrame> fetched{item->number, std::move(*pixels)};
    item->content = Fetched{};
    return fetched;
  }
  return std::nullopt;
}

void ResendRing::put_compressed(std::uint64_t number, EncodedDepthFrame frame) {
  const auto item = find(number);
  if (item == items_.end() || item->number != number) return;
  const EventMessage message{number, static_cast<std::uint32_t>(item->sensor), std::move(frame)};
  Bytes bytes = std::make_shared<const std::vector<std::byte>>(encode_message(message));
  bytes_ -= item->bytes;
  item->bytes = kItemBytes + bytes->size();
  item->content = std::move(bytes);
  bytes_ += item->bytes;
}

void ResendRing::lose_pixels(std::uint64_t number) {
  const auto item = find(number);
  if (item == items_.end() || item->number != number) return;
  const std::size_t sensor = item->sensor;
  drop(item);
  count_lost(sensor);
}

ResendRing::Bytes ResendRing::content_of(Item& item) {
  if (const auto* bytes = std::get_if<Bytes>(&item.content)) return *bytes;
  if (std::holds_alternative<Bye>(item.content))
    return std::make_shared<const std::vector<std::byte>>(
        encode_message(ByeMessage{item.number, bye_problem_}));
  if (!std::holds_alternative<DropTotals>(item.content)) return nullptr;
  Totals& totals = totals_[item.sensor];
  if (totals.item == item.number) totals.item.reset();
  const EventMessage message{item.number, static_cast<std::uint32_t>(item.sensor),
                             DropCount{0, totals.before_ring + totals.torn - totals.earlier, totals.in_ring}};
  return std::make_shared<const std::vector<std::byte>>(encode_message(message));
}

ResendRing::Bytes ResendRing::next_to_send() {
  if (bye_pending_ && find(cursor_) == items_.end()) {
    bye_pending_ = false;
    add({next_number_, 0, Bye{}});
  }
  const auto item = find(cursor_);
  if (item == items_.end()) return nullptr;
  Bytes bytes = content_of(*item);
  if (!bytes) return nullptr;
  item->offered = true;
  cursor_ = item->number + 1;
  return bytes;
}

void ResendRing::acknowledge(std::uint64_t next_number) {
  while (!items_.empty() && items_.front().number < next_number) {
    const Item& item = items_.front();
    if (std::optional<std::uint64_t>& told = totals_.at(item.sensor).item; told == item.number) told.reset();
    drop(items_.begin());
  }
  while (!uncertain_.empty() && uncertain_.front().first < next_number) uncertain_.pop_front();
}

void ResendRing::resume(std::uint64_t next_number) {
  acknowledge(next_number);
  cursor_ = std::min(next_number, next_number_);
  if (!items_.empty() && std::holds_alternative<Bye>(items_.back().content)) {
    drop(items_.end() - 1);
    bye_pending_ = true;
  }
  for (const auto& [number, sensor] : std::exchange(uncertain_, {})) count_lost(sensor);
}

std::uint64_t ResendRing::start_over() {
  const auto lost =
      static_cast<std::uint64_t>(std::ranges::count_if(items_, &Item::frame)) + uncertain_.size();
  items_.clear();
  uncertain_.clear();
  bytes_ = 0;
  cursor_ = unfetched_ = next_number_;
  for (Totals& totals : totals_) {
    totals.earlier = totals.before_ring + totals.torn;
    totals.in_ring = 0;
    totals.item.reset();
  }
  return lost;
}

std::uint64_t ResendRing::lost_frames() const {
  std::uint64_t lost = 0;
  for (const Totals& totals : totals_) lost += static_cast<std::uint64_t>(totals.in_ring);
  return lost;
}

}  // namespace trilat
