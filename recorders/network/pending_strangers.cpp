// SPDX-License-Identifier: MIT
#include "recorders/network/pending_strangers.h"

#include <algorithm>

#include "recorders/network/link/socket_link.h"

namespace trilat {

PendingStrangers::PendingStrangers(std::size_t limit, std::size_t limit_an_address)
    : limit_(limit), limit_an_address_(limit_an_address) {}

std::shared_ptr<Stranger> PendingStrangers::add(const std::string& from, std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  make_room(from);
  removed_.wait_for(lock, at_most, [&] { return strangers_.size() < 2 * limit_; });
  auto stranger = std::make_shared<Stranger>();
  stranger->from = from;
  strangers_.push_back(stranger);
  return stranger;
}

void PendingStrangers::make_room(const std::string& from) {
  const auto count = [&](const auto& counts) {
    return static_cast<std::size_t>(std::ranges::count_if(strangers_, counts));
  };
  const auto stays = [](const auto& each) { return !each->evicted; };
  const auto stays_from_there = [&](const auto& each) { return !each->evicted && each->from == from; };
  const bool many_from_there = !is_loopback({from, 0}) && count(stays_from_there) >= limit_an_address_;
  if (!many_from_there && count(stays) < limit_) return;
  const auto oldest = many_from_there ? std::ranges::find_if(strangers_, stays_from_there)
                                      : std::ranges::find_if(strangers_, stays);
  if (oldest != strangers_.end()) (*oldest)->evicted = true;
}

void PendingStrangers::remove(const std::shared_ptr<Stranger>& stranger) {
  const std::lock_guard lock(mutex_);
  std::erase(strangers_, stranger);
  removed_.notify_all();
}

}  // namespace trilat
