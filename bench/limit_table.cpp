#include "bench/limit_table.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "core/error.h"

namespace kappamu::bench {

namespace {

std::string line_of(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

std::string rule_of(std::size_t columns) {
  std::string line = "|";
  for (std::size_t i = 0; i < columns; ++i) line += "---|";
  return line + "\n";
}

void add_once(std::vector<std::string>& list, const std::string& value) {
  if (std::find(list.begin(), list.end(), value) == list.end()) list.push_back(value);
}

}  // namespace

std::string to_text(const Figure& figure) {
  if (const auto* text = std::get_if<std::string>(&figure)) return *text;
  if (const auto* count = std::get_if<int>(&figure)) return std::to_string(*count);
  const double value = std::get<double>(figure);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2g", value);
  // 1e-06 reads as 1e-6.
  std::string result(text.data());
  const std::size_t exponent = result.find('e');
  if (exponent != std::string::npos) {
    const bool negative = result[exponent + 1] == '-';
    std::size_t digits = exponent + 2;
    while (digits + 1 < result.size() && result[digits] == '0') ++digits;
    result = result.substr(0, exponent + 1) + (negative ? "-" : "") + result.substr(digits);
  }
  return result;
}

std::string percent(double share) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%.0f %%", 100.0 * share);
  return text.data();
}

const Figure& figure(const Record& record, const std::string& name) {
  for (const auto& [known, value] : record) {
    if (known == name) return value;
  }
  throw InternalError("internal error: a limit's record has no " + name);
}

std::string flat_table(const std::vector<Record>& records, const std::vector<std::string>& names) {
  std::string table = line_of(names) + rule_of(names.size());
  for (const Record& record : records) {
    std::vector<std::string> cells;
    for (const std::string& name : names) cells.push_back(to_text(figure(record, name)));
    table += line_of(cells);
  }
  return table;
}

std::string cross_table(const std::vector<Record>& records, const std::string& line,
                        const std::string& column,
                        const std::function<std::string(const Record&)>& cell) {
  std::vector<std::string> lines, columns;
  for (const Record& record : records) {
    add_once(lines, to_text(figure(record, line)));
    add_once(columns, to_text(figure(record, column)));
  }
  std::vector<std::string> head{line};
  for (const std::string& name : columns) head.push_back(column + " " + name);
  std::string table = line_of(head) + rule_of(head.size());
  for (const std::string& at : lines) {
    std::vector<std::string> cells{at};
    for (const std::string& across : columns) {
      const auto found = std::find_if(records.begin(), records.end(), [&](const Record& record) {
        return to_text(figure(record, line)) == at && to_text(figure(record, column)) == across;
      });
      cells.push_back(found == records.end() ? "" : cell(*found));
    }
    table += line_of(cells);
  }
  return table;
}

std::string with_table(const std::string& document, const LimitTable& table,
                       const std::string& file) {
  const std::string begin = "<!-- limits:" + table.id + " -->\n";
  const std::string end = "<!-- limits:end -->";
  const std::size_t from = document.find(begin);
  const std::size_t to =
      from == std::string::npos ? std::string::npos : document.find(end, from + begin.size());
  if (to == std::string::npos) {
    throw InputError(file + ": no place for the table '" + table.id + "'; put the lines '" +
                     begin.substr(0, begin.size() - 1) + "' and '" + end + "' where it belongs.");
  }
  return document.substr(0, from + begin.size()) + "\n" + table.markdown + "\n" +
         document.substr(to);
}

}  // namespace kappamu::bench
