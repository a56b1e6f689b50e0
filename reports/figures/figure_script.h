// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "reports/figures/figure.h"

namespace trilat {

// What gnuplot (5.4) draws a figure from, for any of its terminals: settings, the data and one plot command.
// Texts are quoted so that nothing in them is a command. Equal figures give equal bytes.
std::string gnuplot_script(const Figure& figure);

}  // namespace trilat
