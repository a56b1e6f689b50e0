// SPDX-License-Identifier: MIT
#include "reports/page/html_text.h"

#include <cstdint>

namespace trilat {

std::string html_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += static_cast<unsigned char>(c) < 0x20 && c != '\n' ? ' ' : c;
  }
  return result;
}

std::string html_sentence(std::string_view text) {
  std::string result;
  bool code = false, bold = false;
  std::size_t begin = 0;
  const auto flush = [&](std::size_t end) { result += html_text(text.substr(begin, end - begin)); };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool stars = !code && text.substr(i, 2) == "**";
    if (text[i] != '`' && !stars) continue;
    flush(i);
    if (stars) {
      result += bold ? "</strong>" : "<strong>";
      bold = !bold;
      ++i;
    } else {
      result += code ? "</code>" : "<code>";
      code = !code;
    }
    begin = i + 1;
  }
  flush(text.size());
  if (code) result += "</code>";
  if (bold) result += "</strong>";
  return result;
}

std::string base64_of(std::string_view bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

}  // namespace trilat
