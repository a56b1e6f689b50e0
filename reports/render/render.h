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
// A longtable that needs the packages booktabs and longtable and nothing else.
std::string latex_of(const Table& table);
// A document that holds the given tables, remarks after them, and compiles as it is.
std::string latex_document(const std::vector<Table>& tables, const std::vector<std::string>& remarks = {});

}  // namespace trilat
