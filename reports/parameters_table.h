// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/declared_parameters.h"
#include "reports/table.h"

namespace trilat {

// What the simulation of one or several studies assumes, with sources.
Table parameters_table(const std::vector<DeclaredParameter>& parameters, const std::string& studies);

}  // namespace trilat
