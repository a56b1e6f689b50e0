// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace trilat {

// Escaped for HTML text and attributes in double quotes; control characters become spaces.
std::string html_text(std::string_view text);

// A sentence in which **bold** and `code` are marked up as in Markdown.
std::string html_sentence(std::string_view text);

// RFC 4648, with padding.
std::string base64_of(std::string_view bytes);

}  // namespace trilat
