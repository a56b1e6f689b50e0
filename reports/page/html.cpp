// SPDX-License-Identifier: MIT
#include "reports/page/html.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>
#include <openssl/evp.h>
#include <zlib.h>

#include "datasets/base/error.h"
#include "datasets/base/words.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr std::size_t kLong = 40;  // bytes of a text that is broken into lines
constexpr std::size_t kMany = 12;  // columns that a print has to make small

const char* badge_class(TableValue::Mark mark) {
  if (mark == TableValue::Mark::good) return "holds";
  if (mark == TableValue::Mark::bad) return "fails";
  if (mark == TableValue::Mark::contradiction) return "fails against";
  return mark == TableValue::Mark::unsure ? "unsure" : "untested";
}

bool is_long(const Table& table, std::size_t column) {
  return table.columns[column].is_text && std::ranges::any_of(table.rows, [&](const auto& row) {
           return printed(row[column]).size() > kLong;
         });
}

bool is_rest(const Table& table, std::size_t column) {
  return table.first_columns > 0 && column >= table.first_columns;
}

std::string class_of(const Table& table, std::size_t column, bool wraps) {
  std::string names = table.columns[column].is_text ? wraps ? "long" : "" : "n";
  if (is_rest(table, column)) names += names.empty() ? "rest" : " rest";
  return names.empty() ? names : " class=\"" + names + "\"";
}

std::string cell_html(const TableValue& value) {
  const std::string text = printed(value), interval = printed_interval(value);
  std::string html = value.is_verdict() ? verdict_badge(text, value.mark) : html_text(text);
  if (value.mark == TableValue::Mark::best) html = "<strong>" + html + "</strong>";
  if (value.mark == TableValue::Mark::not_distinguished)
    html += " <span title=\"cannot be distinguished from the best\">≈</span>";
  if (!interval.empty()) html += " <small>" + interval + "</small>";
  if (!value.beside.empty()) html += " <small>" + html_text(value.beside) + "</small>";
  return html;
}

std::string cells_html(const Table& table) {
  const std::vector<std::size_t> order = shown_order(table);
  std::vector<std::string> classes;
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    classes.push_back(class_of(table, c, is_long(table, c)));
  std::string html = "<thead><tr>";
  for (const std::size_t c : order)
    html += fmt::format("<th scope=\"col\" tabindex=\"0\" aria-sort=\"none\"{}>{}</th>", classes[c],
                        html_text(header_of(table.columns[c])));
  html += "</tr></thead>\n<tbody>\n";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    html += table.first_rows > 0 && r >= table.first_rows ? "<tr class=\"rest\">" : "<tr>";
    for (const std::size_t c : order) {
      const std::string cell = cell_html(table.rows[r][c]);
      html += c == 0 ? fmt::format("<th scope=\"row\"{}>{}</th>", classes[c], cell)
                     : fmt::format("<td{}>{}</td>", classes[c], cell);
    }
    html += "</tr>\n";
  }
  return html + "</tbody>";
}

std::string links_html(const Table& table) {
  std::string html = "<div class=\"links\">";
  if (table.first_rows > 0 && table.first_rows < table.rows.size())
    html += fmt::format("<button type=\"button\" class=\"more\">Show {}</button>",
                        counted(table.rows.size() - table.first_rows, "more row"));
  else if (table.first_columns > 0 && table.first_columns < table.columns.size())
    html += "<button type=\"button\" class=\"more\">Show intervals and details</button>";
  html += fmt::format("<a href=\"tables/{}.csv\">CSV</a>", html_text(table.id));
  if (latex_of(table)) html += fmt::format("<a href=\"tables/{}.tex\">LaTeX</a>", html_text(table.id));
  return html + "</div>\n";
}

}  // namespace

std::string verdict_badge(const std::string& verdict, TableValue::Mark mark) {
  return fmt::format("<span class=\"v {}\">{}</span>", badge_class(mark), html_text(verdict));
}

std::string html_title(const Table& table) {
  const std::string title = "<strong>" + html_text(table.title) + "</strong>";
  return table.about.empty() ? title : title + " <span>(" + html_text(table.about) + ")</span>";
}

std::string html_of(const Table& table) {
  const std::string title = html_text(table.whole_title());
  std::string notes;
  for (const std::string& note : table.notes) notes += "<li>" + html_text(note) + "</li>\n";
  if (!notes.empty()) notes = "<ul class=\"notes\">" + notes + "</ul>\n";
  return fmt::format(
      "<div class=\"table{}{}\" id=\"table-{}\">\n<p class=\"title\">{}</p>\n{}<div class=\"scroll\" "
      "tabindex=\"0\" role=\"region\" aria-label=\"{}\"><table><caption>{}</caption>\n{}</table></div>\n"
      "{}</div>\n",
      table.first_columns > 0 ? " claims" : "", table.columns.size() > kMany ? " many" : "",
      html_text(table.id), html_title(table), links_html(table), title, title, cells_html(table), notes);
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

std::string svg_source(std::string_view svg) {
  constexpr std::string_view kGroup = "<g ", kEnd = "\n</g>\n";
  std::string source = "data:image/svg+xml,";
  for (std::size_t at = 0; at < svg.size(); ++at) {
    if (svg.substr(at, kGroup.size()) == kGroup) {  // gnuplot writes many groups with nothing in them
      const std::size_t end = svg.find('>', at);
      if (end != std::string_view::npos && svg.substr(end + 1, kEnd.size()) == kEnd) {
        at = end + kEnd.size();
        continue;
      }
    }
    switch (svg[at]) {
      case '%':
        source += "%25";
        break;
      case '#':
        source += "%23";
        break;
      case '\'':
        source += "&#39;";
        break;
      case '&':
        source += "&amp;";
        break;
      case '\n':
      case '\t':
        source += ' ';
        break;
      default:
        source += svg[at];
    }
  }
  return source;
}

std::string base64_of(std::string_view bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3), '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                  reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  return text;
}

}  // namespace trilat
