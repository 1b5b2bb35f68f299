// Tables as spreadsheets and scripts write them: the one reader of CSV files.
//
// A first line names the columns, in any order and capitals. Cells end at commas, semicolons or
// tabs, whichever the first line has most of; lines end with CR, LF or both. Cells in double quotes
// may hold separators, line ends and doubled quotes (RFC 4180). A UTF-8 byte order mark, Excel's
// line "sep=;" and lines without text are passed over.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/read_file.h"

namespace kappamu::io {

struct CsvColumn {
  const char* name;      ///< in small letters
  bool required = true;  ///< its cells are not empty; an absent one has empty cells otherwise
};

/// `cells` are those of the columns asked for, in their order, without blanks around them; `where`
/// is "<file>: line <number>", to begin a message with.
using CsvRow = std::function<void(const std::vector<std::string>& cells, const std::string& where)>;

/// Calls `row` for each line behind the first. Throws InputError naming file and line for a column
/// or cell that is missing, a name that occurs twice, more cells than names, a quote that does not
/// end, and UTF-16.
void read_csv(const std::filesystem::path& file, const std::vector<CsvColumn>& columns,
              const CsvRow& row, std::size_t largest = largest_text);

/// 0.5, and 0,5 as spreadsheets in many languages write it; nothing where the cell is no number.
std::optional<double> csv_number(std::string cell);

}  // namespace kappamu::io
