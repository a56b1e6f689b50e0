// SPDX-License-Identifier: MIT
#include "pipeline/gate/other_work.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

namespace trilat {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double own_s() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
}

// Of all processors together, all but idle and waiting; 0 when it cannot be read.
double machine_s() {
  std::ifstream file("/proc/stat");
  std::string name;
  double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, irq = 0, soft_irq = 0, stolen = 0;
  if (!(file >> name >> user >> nice >> system >> idle >> waiting >> irq >> soft_irq >> stolen)) return 0.0;
  return (user + nice + system + irq + soft_irq + stolen) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

OtherWork::OtherWork() : start_s_(now_s()), busy_s_(machine_s() - own_s()) {}

double OtherWork::processors() const {
  const double elapsed_s = now_s() - start_s_;
  return elapsed_s > 0.0 ? std::max(0.0, (machine_s() - own_s() - busy_s_) / elapsed_s) : 0.0;
}

}  // namespace trilat
