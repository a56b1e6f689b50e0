// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"

namespace trilat {

InputError::InputError(std::string place, std::string problem)
    : std::runtime_error(place + ": " + problem), place_(std::move(place)), problem_(std::move(problem)) {}

}  // namespace trilat
