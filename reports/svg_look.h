// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace trilat {

// What a page shows a dark picture by: the picture's address with this behind it.
inline constexpr const char* kDarkFragment = "#dark";

// A picture as gnuplot drew it, with two rules more: under kDarkFragment paper, ink and lines are those of a
// dark page while the colours of methods stay; and what belongs to an entry of the legend without being named
// in it (medians of boxes, intervals) goes when the entry is switched off.
std::string svg_with_rules(std::string svg);

}  // namespace trilat
