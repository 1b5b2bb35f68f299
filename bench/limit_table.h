// Figures of docs/limits.md: records as measured, and the Markdown tables made of them.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace kappamu::bench {

using Figure = std::variant<std::string, int, double>;
/// Named figures of one measurement, in the order of their columns.
using Record = std::vector<std::pair<std::string, Figure>>;

struct LimitTable {
  std::string id;  ///< of its place in the document
  std::vector<Record> records;
  std::string markdown;
};

/// Doubles with two significant digits.
std::string to_text(const Figure& figure);
/// A share in whole percent, "25 %".
std::string percent(double share);

/// The record's figure of that name; InternalError when there is none.
const Figure& figure(const Record& record, const std::string& name);

/// One line per record, one column per name.
std::string flat_table(const std::vector<Record>& records, const std::vector<std::string>& names);

/// A raster: a line for each value of `line`, a column for each of `column`, `cell` of the record
/// that has both.
std::string cross_table(const std::vector<Record>& records, const std::string& line,
                        const std::string& column,
                        const std::function<std::string(const Record&)>& cell);

/// `document` with the lines between `<!-- limits:ID -->` and `<!-- limits:end -->` replaced by the
/// table. Throws InputError naming `file` when it has no such place.
std::string with_table(const std::string& document, const LimitTable& table,
                       const std::string& file);

}  // namespace kappamu::bench
