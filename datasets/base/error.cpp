// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"

#include <string>

namespace trilat {

InputError::InputError(std::string place, std::string problem)
    : std::runtime_error(place + ": " + problem), place_(std::move(place)), problem_(std::move(problem)) {}

void check_failed(const char* file, int line, const char* what) {
  const std::string path = file;
  const auto slash = path.find_last_of('/');
  throw InternalError(path.substr(slash == std::string::npos ? 0 : slash + 1) + ":" + std::to_string(line) +
                      ": " + what);
}

}  // namespace trilat
