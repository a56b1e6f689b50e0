// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/figure.h"
#include "datasets/results/table.h"

namespace trilat {

// Adds what the paper prints to a table and a figure that say that its numbers belong beside: of Table III by
// group, which is a column's key or a panel, and method.
void add_printed(Table& table, bool simulated);
void add_printed(Figure& figure);

}  // namespace trilat
