#include "app/photograph_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::app {

namespace {

/// "9x6" as {9, 6}.
std::array<int, 2> extent(const std::string& text, const std::string& option) {
  std::array<int, 2> size{};
  int used = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &size[0], &size[1], &used) != 2 ||
      used != static_cast<int>(text.size()) || size[0] < 2 || size[1] < 2) {
    throw InputError(option + " is '" + shown_text(text) +
                     "'; write columns x rows, both at least 2, such as 9x6.");
  }
  return size;
}

}  // namespace

bool is_session(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder / "session.json", ignored);
}

void add_orientation(CLI::App& command, std::optional<capture::Orientation>& orientation) {
  std::vector<std::string> names;
  for (const auto& [name, value] : capture::orientation_names) names.emplace_back(name);
  command
      .add_option_function<std::string>(
          "--orientation",
          [&orientation](const std::string& name) {
            orientation = value_of(capture::orientation_names, name);
          },
          "What is done with the photographs' EXIF orientation; without it they are ignored, with "
          "a warning where they agree on a turn")
      ->check(CLI::IsMember(names));
}

capture::PhotographSource PhotographOptions::source(const std::filesystem::path& folder,
                                                    capture::Links links) const {
  return {folder, table, links, {}, orientation};
}

void PhotographOptions::require_none(const std::filesystem::path& session) const {
  if (!table && !orientation) return;
  throw InputError(
      (session / "session.json").string() + ": " + (table ? "--table is" : "--orientation is") +
      " of photographs without a session; a session states " +
      (table ? "its frames' shots and exposure times itself." : "it as camera.orientation."));
}

void add_photograph_options(CLI::App& command, PhotographOptions& options) {
  command
      .add_option("--table", options.table,
                  "Of photographs without a session: CSV with the columns file, shot and, where "
                  "EXIF does not have it, exposure_s")
      ->type_name("CSV");
  add_orientation(command, options.orientation);
}

capture::Board BoardOptions::board() const {
  const std::array<int, 2> size = extent(corners, "--board");
  if (!(square_mm > 0.0)) {
    throw InputError("--square is missing; give the distance of two corners in mm.");
  }
  capture::Board board{size[0], size[1], square_mm};
  for (const auto& [name, known] : capture::board_kind_names) {
    if (name == kind) board.kind = known;
  }
  if (board.kind != capture::BoardKind::charuco) return board;
  if (!(marker_mm > 0.0 && marker_mm < square_mm) || dictionary.empty()) {
    throw InputError(
        "a ChArUco board needs --marker, the edge of a marker in mm, less than --square, and "
        "--dictionary, such as DICT_4X4_50.");
  }
  const bool known =
      std::any_of(capture::marker_dictionaries.begin(), capture::marker_dictionaries.end(),
                  [&](const capture::MarkerDictionary& entry) { return entry.name == dictionary; });
  if (!known) {
    throw InputError("--dictionary is '" + shown_text(dictionary) +
                     "'; write one of OpenCV's names, such as DICT_4X4_50.");
  }
  board.marker_mm = marker_mm;
  board.dictionary = dictionary;
  return board;
}

std::optional<capture::Projector> BoardOptions::projector_size() const {
  if (projector.empty()) return std::nullopt;
  const std::array<int, 2> size = extent(projector, "--projector");
  return capture::Projector{size[0], size[1]};
}

void add_board_options(CLI::App& command, BoardOptions& options) {
  command
      .add_option("--board", options.corners,
                  "Of photographs without a session: inner corners or dots of the printed board, "
                  "columns x rows, such as 9x6")
      ->type_name("NxM");
  command.add_option("--square", options.square_mm, "Distance of two of its corners or dots")
      ->type_name("MM");
  std::vector<std::string> names;
  for (const auto& [name, kind] : capture::board_kind_names) names.emplace_back(name);
  command.add_option("--board-kind", options.kind, "What the board shows")
      ->capture_default_str()
      ->check(CLI::IsMember(names));
  command
      .add_option("--marker", options.marker_mm,
                  "Edge of a ChArUco board's markers; --board counts its inner corners")
      ->type_name("MM");
  command.add_option("--dictionary", options.dictionary, "Of its markers, such as DICT_4X4_50")
      ->type_name("NAME");
  command
      .add_option("--projector", options.projector,
                  "Pixels of the projector whose Gray codes lie among the photographs, such as "
                  "1024x768")
      ->type_name("NxM");
}

}  // namespace kappamu::app
