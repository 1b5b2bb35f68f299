// What commands ask of photographs that lie in a folder without a session.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/command.h"
#include "capture/import/photograph_session.h"

namespace kappamu::app {

/// A folder is a session's if it has a session.json.
bool is_session(const std::filesystem::path& folder);

/// Adds --orientation.
void add_orientation(CLI::App& command, std::optional<capture::Orientation>& orientation);

/// Of photographs without a session.
struct PhotographOptions {
  std::optional<std::string> table;
  std::optional<capture::Orientation> orientation;

  capture::PhotographSource source(const std::filesystem::path& folder, capture::Links links) const;
  /// Throws where they are given with a session.
  void require_none(const std::filesystem::path& session) const;
};

/// Adds --table and --orientation.
void add_photograph_options(CLI::App& command, PhotographOptions& options);

struct BoardOptions {
  std::string corners;  ///< "9x6"; empty: not given
  double square_mm = 0.0;
  std::string kind = "chessboard";
  double marker_mm = 0.0;  ///< ChArUco
  std::string dictionary;  ///< ChArUco
  std::string projector;   ///< "1024x768"; empty: none

  capture::Board board() const;
  std::optional<capture::Projector> projector_size() const;
};

/// Adds --board, --square, --board-kind, --marker, --dictionary and --projector.
void add_board_options(CLI::App& command, BoardOptions& options);

}  // namespace kappamu::app
