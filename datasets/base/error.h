// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

// TRILAT_CHECK(condition, "what must hold"): always on, throws InternalError with the source line.
// For our own mistakes only; what comes from outside is refused with InputError.
#define TRILAT_CHECK(condition, what)                                   \
  do {                                                                  \
    if (!(condition)) ::trilat::check_failed(__FILE__, __LINE__, what); \
  } while (false)

namespace trilat {

// A text of a file as messages may show it: control characters but line ends and tabs as \xNN.
std::string printable(std::string_view text);

// The outside world is wrong: a file, a setting, a device. `place` is where a person has to look
// (`take.csv:17`, `/methods/0/name`, `session.h5:/sensors/k1`), `problem` what is there and what would be
// right. Caught per work item by the runner and in main, where it becomes exit code 2.
class InputError : public std::runtime_error {
 public:
  InputError(std::string place, std::string problem);
  const std::string& place() const { return place_; }
  const std::string& problem() const { return problem_; }

 private:
  std::string place_;
  std::string problem_;
};

// Output that cannot be written (a full disk, a folder without permission): unlike other bad input
// it stops all of the work, not one item of it.
class OutputError : public InputError {
 public:
  using InputError::InputError;
};

// We are wrong: a broken promise inside the program. Becomes exit code 70.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

// A person pressed Ctrl-C or the process was asked to end; what is finished has been kept.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

[[noreturn]] void check_failed(const char* file, int line, const char* what);

}  // namespace trilat
