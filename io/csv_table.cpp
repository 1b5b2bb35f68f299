#include "io/csv_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::io {

namespace {

namespace fs = std::filesystem;

/// Blanks of UTF-8 that look like none: no-break, narrow no-break and zero-width space, byte order
/// mark.
constexpr std::array<std::string_view, 6> blanks{" ", "\t", "\u00a0", "\u202f", "\u200b", "\ufeff"};

std::string trimmed(std::string_view text) {
  const auto cut = [&](const auto& has, const auto& take) {
    for (bool again = true; again;) {
      again = false;
      for (const std::string_view blank : blanks) {
        if (!has(blank)) continue;
        take(blank.size());
        again = true;
      }
    }
  };
  cut([&](std::string_view blank) { return text.starts_with(blank); },
      [&](std::size_t size) { text.remove_prefix(size); });
  cut([&](std::string_view blank) { return text.ends_with(blank); },
      [&](std::size_t size) { text.remove_suffix(size); });
  return std::string(text);
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The lines of a table and their cells.
class Lines {
 public:
  explicit Lines(const fs::path& file, std::string_view text)
      : file_(file), text_(text), separator_(find_separator()) {}

  /// False at the end of the text.
  bool next(std::vector<std::string>& cells) {
    cells.clear();
    if (at_ >= text_.size()) return false;
    line_ = next_line_;
    bool more = true;
    while (more) cells.push_back(trimmed(cell(more)));
    return true;
  }
  std::string where() const { return file_.string() + ": line " + std::to_string(line_); }

 private:
  /// By the first line; one that only states the separator is taken away.
  char find_separator() {
    std::string_view first = text_.substr(0, text_.find_first_of("\r\n"));
    if (first.size() == 5 && lower(std::string(first.substr(0, 4))) == "sep=") {
      at_ = first.size();
      end_line();
      return first.back();
    }
    while (at_ < text_.size() && (text_[at_] == '\r' || text_[at_] == '\n')) end_line();
    first = text_.substr(at_, text_.find_first_of("\r\n", at_) - at_);
    const auto cells = [&](char c) { return std::count(first.begin(), first.end(), c); };
    return std::max({',', ';', '\t'}, [&](char a, char b) { return cells(a) < cells(b); });
  }

  void end_line() {
    if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
    ++at_;
    ++next_line_;
  }

  /// The text up to the next separator or line end; `more` where another cell follows.
  std::string cell(bool& more) {
    std::string text;
    bool blank = true;  // so far: a quote behind the first letter is one
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == separator_) {
        ++at_;
        return text;
      }
      if (c == '\r' || c == '\n') {
        end_line();
        break;
      }
      if (c == '"' && blank) {
        quoted(text);
      } else {
        text += c;
      }
      blank &= c == ' ' || c == '\t';
    }
    more = false;
    return text;
  }

  /// Leaves `at_` on the closing quote.
  void quoted(std::string& text) {
    for (++at_; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      const bool doubled = c == '"' && at_ + 1 < text_.size() && text_[at_ + 1] == '"';
      if (c == '"' && !doubled) return;
      if (doubled) ++at_;
      if (c == '\n') ++next_line_;
      text += c;
    }
    throw InputError(where() +
                     " opens a quote that does not end; close it, or double quotes "
                     "that belong to the text.");
  }

  const fs::path& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1, next_line_ = 1;
  char separator_;
};

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return shown_text(text, 120);
}

/// Of each column its place in the lines; that of an optional one may lie behind them.
std::vector<std::size_t> places_of(const std::vector<CsvColumn>& columns,
                                   const std::vector<std::string>& header,
                                   const std::string& where) {
  if (header.empty()) throw InputError(where + " is empty; the first line names the columns.");
  std::vector<std::size_t> places;
  for (const CsvColumn& column : columns) {
    const auto is_it = [&](const std::string& name) { return lower(name) == column.name; };
    const auto found = std::find_if(header.begin(), header.end(), is_it);
    if (found == header.end() && column.required) {
      throw InputError(where + " names no column '" + column.name + "' but " + listed(header) +
                       "; the first line names the columns, separated by commas, semicolons or "
                       "tabs.");
    }
    if (std::count_if(header.begin(), header.end(), is_it) > 1) {
      throw InputError(where + " names the column '" + column.name + "' twice; keep one.");
    }
    places.push_back(static_cast<std::size_t>(found - header.begin()));
  }
  return places;
}

}  // namespace

void read_csv(const fs::path& file, const std::vector<CsvColumn>& columns, const CsvRow& row,
              std::size_t largest) {
  const std::string bytes = read_text(file, largest);
  std::string_view text = bytes;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
      text.find('\0') != std::string_view::npos) {
    throw InputError(file.string() +
                     ": the table is UTF-16 or no text; save it as CSV in UTF-8 (Excel: 'CSV "
                     "UTF-8').");
  }
  Lines lines(file, text);
  std::vector<std::string> header, line;
  lines.next(header);
  const std::vector<std::size_t> places = places_of(columns, header, lines.where());
  std::vector<std::string> cells(columns.size());
  while (lines.next(line)) {
    const auto filled = [](const std::string& cell) { return !cell.empty(); };
    const auto last = std::find_if(line.rbegin(), line.rend(), filled);
    if (last == line.rend()) continue;
    const auto used = static_cast<std::size_t>(line.rend() - last);
    if (used > header.size()) {
      throw InputError(lines.where() + " has " + std::to_string(used) +
                       " cells, the first line names " + std::to_string(header.size()) +
                       " columns; put cells that hold a separator in double quotes.");
    }
    for (std::size_t c = 0; c < columns.size(); ++c) {
      cells[c] = places[c] < line.size() ? line[places[c]] : std::string();
      if (cells[c].empty() && columns[c].required) {
        throw InputError(lines.where() + " has no " + columns[c].name + "; fill in the cell.");
      }
    }
    row(cells, lines.where());
  }
}

std::optional<double> csv_number(std::string cell) {
  if (std::count(cell.begin(), cell.end(), ',') == 1 && cell.find('.') == std::string::npos) {
    std::replace(cell.begin(), cell.end(), ',', '.');
  }
  double value = 0.0;
  const char* end = cell.data() + cell.size();
  const auto read = std::from_chars(cell.data(), end, value);
  if (cell.empty() || read.ec != std::errc() || read.ptr != end || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

}  // namespace kappamu::io
