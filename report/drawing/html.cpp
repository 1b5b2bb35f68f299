#include "report/drawing/html.h"

#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "core/shown_text.h"
#include "io/xml_text.h"

namespace kappamu::report {

namespace {

std::string opening(std::string_view tag, const Attributes& attributes) {
  std::string result = "<";
  result.append(tag);
  for (const auto& [name, value] : attributes)
    result.append(" ")
        .append(name)
        .append("=\"")
        .append(io::xml_escaped(shown_text(value)))
        .append("\"");
  return result;
}

std::string formatted(const char* format, int digits, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, digits, value);
  return buffer.data();
}

}  // namespace

Html raw(std::string markup) {
  Html html;
  html.markup_ = std::move(markup);
  return html;
}

Html text(std::string_view plain) {
  return raw(io::xml_escaped(shown_text(plain)));
}

Html element(std::string_view tag, const Attributes& attributes, const Html& content) {
  std::string result = opening(tag, attributes);
  result.append(">").append(content.markup()).append("</").append(tag).append(">\n");
  return raw(std::move(result));
}

Html empty_element(std::string_view tag, const Attributes& attributes) {
  return raw(opening(tag, attributes) + "/>\n");
}

Html paragraph(std::string_view plain) {
  return element("p", text(plain));
}

Html note(std::string_view plain) {
  return element("p", {{"class", "note"}}, text(plain));
}

std::string anchor(std::string_view title) {
  std::string result;
  for (const char letter : title) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) != 0) result += static_cast<char>(std::tolower(byte));
    if (letter == ' ') result += '-';
  }
  return result;
}

Html section(std::string_view title, const Html& content) {
  return element("section", {{"id", anchor(title)}}, element("h2", text(title)) + content);
}

Html subsection(std::string_view title, const Html& content) {
  return element("div", {{"class", "subsection"}}, element("h3", text(title)) + content);
}

Html table(const std::vector<std::string>& header, const std::vector<std::vector<Html>>& rows) {
  Html head;
  for (const std::string& cell : header) head += element("th", text(cell));
  Html body;
  for (const auto& cells : rows) {
    Html line;
    for (const Html& cell : cells) line += element("td", cell);
    body += element("tr", line);
  }
  const Html top = header.empty() ? Html{} : element("thead", element("tr", head));
  return element("table", top + element("tbody", body));
}

Html row(const std::vector<Html>& blocks) {
  Html content;
  for (const Html& block : blocks) content += element("div", {{"class", "block"}}, block);
  return element("div", {{"class", "row"}}, content);
}

std::string number(double value, int digits) {
  if (!std::isfinite(value)) return "not finite";
  // %g turns to exponents at 1e<digits>; whole numbers of that size read better written out.
  if (std::abs(value) >= std::pow(10.0, digits) && std::abs(value) < 1e6)
    return formatted("%.*f", 0, value);
  return formatted("%.*g", digits, value);
}

std::string percent(double fraction, int digits) {
  return number(100.0 * fraction, digits) + " %";
}

std::string duration(double seconds) {
  if (seconds < 60.0) return formatted("%.*f", seconds < 10.0 ? 1 : 0, seconds) + " s";
  const auto whole = static_cast<long>(std::lround(seconds));
  if (whole < 3600) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

std::string file_size(double bytes) {
  if (bytes < 1e3) return number(bytes, 3) + " B";
  if (bytes < 1e6) return number(bytes / 1e3, 3) + " kB";
  return number(bytes / 1e6, 3) + " MB";
}

}  // namespace kappamu::report
