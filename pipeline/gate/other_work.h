// SPDX-License-Identifier: MIT
#pragma once

namespace trilat {

// What other programs do on this machine while something is timed.
class OtherWork {
 public:
  OtherWork();
  // How many processors they have kept busy since, on average; 0 where the system does not tell.
  double processors() const;

 private:
  double start_s_ = 0.0, busy_s_ = 0.0;
};

}  // namespace trilat
