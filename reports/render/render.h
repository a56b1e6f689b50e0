// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "reports/tables/table.h"

namespace trilat {

// A value as Markdown and LaTeX print it; NaN becomes a dash.
std::string printed(const TableValue& value);

std::string markdown_of(const Table& table);
// RFC 4180 with full precision; NaN is an empty field.
std::string csv_of(const Table& table);

}  // namespace trilat
