// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "datasets/results/table.h"

namespace trilat {

// A table with its notes and links to its files beside the page, whose script sorts it and shows the rest.
std::string html_of(const Table& table);

// A verdict as a coloured word.
std::string verdict_badge(const std::string& verdict, TableValue::Mark mark);

// A title's first part, and the brackets at its end more softly.
std::string html_title(const Table& table);

// Escaped for HTML text and attributes in double quotes; control characters become spaces.
std::string html_text(std::string_view text);

// A sentence in which **bold** and `code` are marked up as in Markdown.
std::string html_sentence(std::string_view text);

// A list of sentences; empty without any.
std::string html_list(const char* style, const std::vector<std::string>& sentences);

// A picture as the source of an image, for attributes in single quotes.
std::string svg_source(std::string_view svg);
// zlib, as DecompressionStream("deflate") of a browser reads it.
std::string deflated(std::string_view bytes);
// RFC 4648, with padding.
std::string base64_of(std::string_view bytes);

}  // namespace trilat
