// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/error.h"

namespace trilat {

// Bad input may be refused; whatever else is thrown is a finding.
template <class Work>
void tolerate_bad_input(const Work& work) {
  try {
    work();
  } catch (const InputError&) {
  }
}

}  // namespace trilat
