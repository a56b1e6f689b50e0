// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recorders/frame_source.h"
#include "recorders/network/link/wire.h"

namespace trilat {

// Everything an agent has taken from its source and the recording machine has not yet acknowledged, numbered
// in the order of arrival. Where it would grow beyond its limit the oldest frames go, and every loss is
// counted once it is certain: what was sent before it had to go may have arrived. One thread at a time.
class ResendRing {
 public:
  // Without `may_drop` the limit is one that whoever pushes has to mind, by full().
  ResendRing(std::size_t sensors, std::size_t limit_bytes, bool may_drop);

  // Drops from the front what there is no room for; what was added last always stays. A depth frame that came
  // in pieces is left out and counted as lost at the source.
  void push(SourceEvent event);
  // Nothing more will be pushed: the last message says so, and why the source broke where it did.
  void push_bye(std::string problem = {}) {
    bye_problem_ = std::move(problem);
    bye_pending_ = true;
  }

  // Pixels that are to be compressed: the oldest event that nobody has fetched yet.
  std::optional<std::pair<std::uint64_t, DepthFrame>> fetch_pixels();
  // Does nothing where the event has been dropped in the meantime.
  void put_compressed(std::uint64_t number, EncodedDepthFrame frame);
  // Likewise; these pixels could not be compressed and are lost.
  void lose_pixels(std::uint64_t number);

  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  // The next message on this connection, null when there is none that is ready.
  Bytes next_to_send();
  void acknowledge(std::uint64_t next_number);
  // A new connection, whose other side has everything before this number: sends the rest again.
  void resume(std::uint64_t next_number);

  // The other side is gone for good: forgets what it lacks and counts anew, for another one. Returns how many
  // frames it lacked, as far as is known.
  std::uint64_t start_over();

  bool empty() const { return items_.empty() && !bye_pending_; }
  bool full() const { return bytes_ >= limit_bytes_; }
  std::size_t bytes() const { return bytes_; }
  std::uint64_t end_number() const { return next_number_; }  // behind the last message
  std::uint64_t lost_frames() const;                         // those that are certain

 private:
  struct DropTotals {};
  struct Bye {};
  struct Fetched {};  // its pixels are being compressed
  struct Item {
    std::uint64_t number = 0;
    std::size_t sensor = 0;
    std::variant<Bytes, DepthFrame, Fetched, DropTotals, Bye> content;
    std::size_t bytes = 0;
    bool frame = false;
    bool offered = false;  // to a connection, this or an earlier one
  };
  struct Totals {
    std::int64_t before_ring = 0;
    std::int64_t torn = 0;
    std::int64_t earlier = 0;  // of these two, before it started over
    std::int64_t in_ring = 0;
    std::optional<std::uint64_t> item;  // that will tell them, not yet offered
  };

  void add(Item item);
  void shrink();
  void drop(std::deque<Item>::iterator item);
  void count_lost(std::size_t sensor);
  void tell_totals(std::size_t sensor);
  std::deque<Item>::iterator find(std::uint64_t number);
  Bytes content_of(Item& item);

  std::size_t limit_bytes_;
  bool may_drop_;
  std::size_t bytes_ = 0;
  bool bye_pending_ = false;  // wanted, but behind what is still to be sent
  std::string bye_problem_;
  std::uint64_t next_number_ = 0;
  std::uint64_t cursor_ = 0;     // the first number not offered to this connection
  std::uint64_t unfetched_ = 0;  // pixels before this number have been fetched
  std::deque<Item> items_;
  std::vector<Totals> totals_;
  std::deque<std::pair<std::uint64_t, std::size_t>>
      uncertain_;  // number and sensor of what was offered, then dropped
};

}  // namespace trilat
