// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace trilat {

// citation.bib: this program in its version, and the paper whose tables stand beside ours.
std::string citation_bibtex();

}  // namespace trilat
