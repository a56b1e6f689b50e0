// SPDX-License-Identifier: MIT
#include "reports/page/html.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <openssl/evp.h>
#include <zlib.h>

#include "datasets/base/error.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr std::size_t kFewRows = 9;  // of a table that needs no filter
constexpr std::size_t kLong = 40;    // bytes of a text that is broken into lines
constexpr std::size_t kMany = 12;    // columns that a print has to make small

const char* badge_class(const std::string& verdict) {
  if (verdict.starts_with("holds") || verdict == "better") return "holds";
  if (verdict == "does not hold" || verdict == "worse") return "fails";
  if (verdict == "contradicts itself") return "fails against";
  return verdict == "undecided" ? "unsure" : "untested";
}

bool is_long(const Table& table, std::size_t column) {
  return table.columns[column].is_text && std::ranges::any_of(table.rows, [&](const auto& row) {
           return printed(row[column]).size() > kLong;
         });
}

// The number as CSV has it, and its interval, when that is not what is printed.
std::string raw_attribute(const TableColumn& column, const TableValue& value, const std::string& text) {
  if (!value.number) return {};
  const auto number = [](double v) { return std::isfinite(v) ? fmt::format("{}", v) : std::string(); };
  const std::string raw = number(*value.number);
  if (column.has_interval)
    return fmt::format(" data-v=\"{}\" data-ends=\"{},{}\"", raw, number(value.low), number(value.high));
  return raw.empty() || (raw == text && value.beside.empty()) ? "" : " data-v=\"" + raw + "\"";
}

std::string cell_html(const TableColumn& column, const TableValue& value, const char* tag, bool wraps) {
  const std::string text = printed(value), interval = printed_interval(value);
  std::string more;
  if (value.mark == TableValue::Mark::like_best)
    more += " <span title=\"not told apart from the best\">≈</span>";
  if (!interval.empty()) more += " <small>" + interval + "</small>";
  if (!value.beside.empty()) more += " <small class=\"beside\">" + html_text(value.beside) + "</small>";
  const bool is_verdict =
      column.is_text &&
      (column.key == "verdict" || (column.key == "differs" && (text == "better" || text == "worse")));
  const std::string shown = is_verdict ? verdict_badge(text) : html_text(text);
  return fmt::format("<{}{}{}>{}{}</{}>", tag,
                     !column.is_text ? " class=\"n\""
                     : wraps         ? " class=\"long\""
                                     : "",
                     raw_attribute(column, value, text),
                     value.mark == TableValue::Mark::best ? "<strong>" + shown + "</strong>" : shown, more,
                     std::string(tag).substr(0, 2));
}

std::string head_html(const Table& table) {
  std::string html = "<thead><tr>";
  for (const TableColumn& column : table.columns)
    html += fmt::format(
        "<th scope=\"col\" aria-sort=\"none\" data-key=\"{}\"{}{}><button type=\"button\">{}</button></th>",
        html_text(column.key),
        column.has_interval ? fmt::format(" data-ends=\"{},{}\"", html_text(column.key_of_end("from")),
                                          html_text(column.key_of_end("to")))
                            : "",
        column.is_text ? "" : " class=\"n\"", html_text(header_of(column)));
  return html + "</tr></thead>\n";
}

std::string body_html(const Table& table) {
  std::vector<bool> wraps;
  for (std::size_t c = 0; c < table.columns.size(); ++c) wraps.push_back(is_long(table, c));
  std::string html = "<tbody>\n";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const auto& row = table.rows[r];
    html += table.first_rows > 0 && r >= table.first_rows ? "<tr class=\"rest\">" : "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c)
      html += cell_html(table.columns[c], row[c], c == 0 ? "th scope=\"row\"" : "td", wraps[c]);
    html += "</tr>\n";
  }
  return html + "</tbody>";
}

std::string bar_html(const Table& table, const std::string& commands) {
  std::string html = "<div class=\"bar\">";
  if (table.first_rows > 0 && table.first_rows < table.rows.size())
    html += fmt::format("<button type=\"button\" class=\"rest script\">Show {} more rows</button>",
                        table.rows.size() - table.first_rows);
  else if (table.rows.size() >= kFewRows)
    html += fmt::format(
        "<input class=\"script\" type=\"search\" placeholder=\"Filter rows\" aria-label=\"Filter rows of "
        "this table\"><span class=\"shown\" role=\"status\">{} rows</span>",
        table.rows.size());
  html += fmt::format(
      "<a href=\"tables/{0}.csv\">CSV</a><a href=\"tables/{0}.tex\">LaTeX</a><button type=\"button\" "
      "class=\"copy script\">Copy CSV</button>",
      html_text(table.id));
  if (!commands.empty())
    html += "<details class=\"script how\"><summary>Command</summary><pre>" + html_text(commands) +
            "</pre></details>";
  return html + "</div>\n";
}

}  // namespace

std::string verdict_badge(const std::string& verdict) {
  return fmt::format("<span class=\"v {}\">{}</span>", badge_class(verdict), html_text(verdict));
}

std::string html_title(const std::string& title) {
  const auto bracket = title.find(" (");
  if (bracket == std::string::npos) return "<strong>" + html_text(title) + "</strong>";
  return "<strong>" + html_text(title.substr(0, bracket)) + "</strong> <span>" +
         html_text(title.substr(bracket + 1)) + "</span>";
}

std::string html_of(const Table& table, const std::string& commands) {
  const std::string id = html_text(table.id);
  std::string html = fmt::format(
      "<div class=\"table{}{}\" id=\"table-{}\">\n<p class=\"title\">{}</p>\n{}<div class=\"scroll\" "
      "tabindex=\"0\" role=\"region\" aria-label=\"{}\"><table><caption>{}</caption>\n",
      table.id == "paper/claims" ? " claims" : "", table.columns.size() > kMany ? " many" : "", id,
      html_title(table.title), bar_html(table, commands), html_text(table.title), html_text(table.title));
  html += head_html(table) + body_html(table) + "</table></div>\n";
  if (!table.notes.empty()) {
    html += "<ul class=\"notes\">";
    for (const std::string& note : table.notes) html += "<li>" + html_text(note) + "</li>\n";
    html += "</ul>\n";
  }
  return html + "</div>\n";
}

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

std::string html_list(const char* kind, const std::vector<std::string>& sentences) {
  std::string html;
  for (const std::string& sentence : sentences) html += "<li>" + html_sentence(sentence) + "</li>\n";
  return html.empty() ? html : fmt::format("<ul class=\"{}\">\n{}</ul>\n", kind, html);
}

std::string deflated(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  const int code = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                             reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_BEST_COMPRESSION);
  TRILAT_CHECK(code == Z_OK, "a buffer of compressBound() is large enough");
  packed.resize(size);
  return packed;
}

std::string base64_of(std::string_view bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3), '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                  reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  return text;
}

}  // namespace trilat
