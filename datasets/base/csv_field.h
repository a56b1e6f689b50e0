// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace trilat {

// A field of a CSV file as RFC 4180 has it: between quotes where a comma, a quote or the end of a line stands
// in it, with quotes doubled. Everything that writes CSV writes texts with it.
std::string csv_field(std::string_view text);
// The same, always between quotes.
std::string csv_quoted(std::string_view text);

}  // namespace trilat
