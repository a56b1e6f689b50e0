// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "recorders/capture.h"

namespace trilat {

// What a running recording shows on stderr: a line over itself on a terminal, now and then elsewhere, and
// what there is to say above it. Written by a thread of its own, so that a terminal that takes nothing holds
// up nobody; what cannot be written is left out. Any thread may call it.
class LiveDisplay {
 public:
  LiveDisplay();
  // Waits a moment for what is still to be shown.
  ~LiveDisplay();
  LiveDisplay(const LiveDisplay&) = delete;
  LiveDisplay& operator=(const LiveDisplay&) = delete;

  // `picture` is drawn over the whole screen first.
  void show(const CaptureStatus& status, std::string picture = {});
  void say(const std::string& text);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

// The line itself.
std::string status_line(const CaptureStatus& status);

}  // namespace trilat
