#include "capture/rig/printables.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::capture {
namespace {

constexpr double points_per_mm = 72.0 / 25.4;
constexpr double text_mm = 12.0;  // below the board, for the line of text

/// The smallest usual page that holds width x height [mm], else that size itself.
std::array<double, 2> page_of(double width, double height) {
  constexpr double margin = 5.0;  // what printers leave white
  for (const std::array<double, 2> paper : {std::array{210.0, 297.0}, std::array{297.0, 210.0},
                                            std::array{297.0, 420.0}, std::array{420.0, 297.0}}) {
    if (width + 2 * margin <= paper[0] && height + 2 * margin <= paper[1]) return paper;
  }
  return {width + 2 * margin, height + 2 * margin};
}

/// A PDF 1.4 file of these objects, the first of which is the catalogue.
std::string pdf(const std::vector<std::string>& objects) {
  std::string file = "%PDF-1.4\n";
  std::string places;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    places += formatted("%010zu 00000 n \n", file.size());
    file += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
  }
  const std::string size = std::to_string(objects.size() + 1);
  const std::string begin = std::to_string(file.size());
  return file + "xref\n0 " + size + "\n0000000000 65535 f \n" + places + "trailer\n<< /Size " +
         size + " /Root 1 0 R >>\nstartxref\n" + begin + "\n%%EOF\n";
}

std::string label(double x, double y, const std::string& text, const char* anchor = "middle") {
  return "<text x=\"" + shown_number(x) + "\" y=\"" + shown_number(y) + "\" text-anchor=\"" +
         anchor + "\">" + text + "</text>\n";
}

/// A box with a lens on the side towards the block: dx is +1 where that is to the right.
std::string device(double x, double y, int dx, const std::string& fill) {
  return "<rect x=\"" + shown_number(x - 30) + "\" y=\"" + shown_number(y - 18) +
         "\" width=\"60\" height=\"36\" rx=\"4\" fill=\"" + fill +
         "\" stroke=\"#333\"/>\n<rect x=\"" + shown_number(dx > 0 ? x + 30 : x - 40) + "\" y=\"" +
         shown_number(y - 10) + "\" width=\"10\" height=\"20\" fill=\"#333\"/>\n";
}

}  // namespace

std::string board_pdf(const Board& board) {
  if (board.kind != BoardKind::chessboard) {
    throw InputError("capture plan: only a chessboard is drawn for printing.");
  }
  const double square = board.square_mm;
  const double width = (board.columns + 3) * square;
  const double height = (board.rows + 3) * square;
  const std::array<double, 2> page = page_of(width, height + text_mm);
  const double left = 0.5 * (page[0] - (board.columns + 1) * square);
  const double bottom = 0.5 * (page[1] - (board.rows + 1) * square) + 0.5 * text_mm;
  std::string drawing =
      shown_number(points_per_mm) + " 0 0 " + shown_number(points_per_mm) + " 0 0 cm\n0 g\n";
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = row % 2; column <= board.columns; column += 2) {
      drawing += shown_number(left + column * square) + " " + shown_number(bottom + row * square) +
                 " " + shown_number(square) + " " + shown_number(square) + " re\n";
    }
  }
  const std::string size = std::to_string(board.columns) + " x " + std::to_string(board.rows) +
                           " inner corners. Print at 100 %: the black pattern is " +
                           shown_number((board.columns + 1) * square) + " mm x " +
                           shown_number((board.rows + 1) * square) + " mm, a square " +
                           shown_number(square) + " mm.";
  const double letters_mm =
      std::min(3.5, 1.9 * (page[0] - 10.0) / static_cast<double>(size.size()));
  drawing += "f\nBT /F1 " + shown_number(letters_mm) + " Tf 5 " +
             shown_number(std::max(5.0, bottom - square - 0.5 * text_mm)) + " Td (" + size +
             ") Tj ET\n";
  return pdf(
      {"<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
       "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + shown_number(page[0] * points_per_mm) +
           " " + shown_number(page[1] * points_per_mm) +
           "] /Resources << /Font << /F1 5 0 R >> >> /Contents 4 0 R >>",
       "<< /Length " + std::to_string(drawing.size()) + " >>\nstream\n" + drawing + "endstream",
       "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"});
}

std::string rig_sketch(const Sample& sample, Setup setup) {
  const bool back_lit = setup == Setup::back_lit;
  const auto mm = [&](int axis) {
    return shown_number(sample.grid[static_cast<std::size_t>(axis)] * sample.voxel_mm);
  };
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 330\" "
      "font-family=\"sans-serif\" "
      "font-size=\"13\" fill=\"#222\">\n<rect width=\"640\" height=\"330\" fill=\"white\"/>\n";
  svg += label(320, 22, "The rig seen from above; distances are not to scale");
  // Light and lines of sight.
  svg += "<path d=\"M110 130 L290 85 L290 175 Z\" fill=\"#ffe9a8\"/>\n";
  svg += "<path d=\"M110 240 L290 160\" stroke=\"#4477aa\" stroke-dasharray=\"5 4\"/>\n";
  if (back_lit)
    svg += "<path d=\"M530 130 L350 130\" stroke=\"#4477aa\" stroke-dasharray=\"5 4\"/>\n";
  svg += device(70, 130, 1, "#d9d9d9") + label(70, 105, "projector");
  svg += device(70, 240, 1, "#bcd2ee");
  svg += label(20, 278, "camera at station front", "start");
  svg += label(20, 295, back_lit ? "(boards, planes, white target)" : "(all photographs)", "start");
  if (back_lit) {
    svg += device(570, 130, -1, "#bcd2ee") + label(620, 168, "camera at station back", "end");
    svg += label(620, 185, "(the patterns)", "end");
  }
  svg +=
      "<rect x=\"290\" y=\"80\" width=\"60\" height=\"100\" fill=\"#e8c8b0\" stroke=\"#333\"/>\n";
  svg += label(320, 70, "block, " + mm(0) + " x " + mm(1) + " x " + mm(2) + " mm along x, y, z");
  svg += label(284, 206, "front: " + to_string(sample.lit_face), "end");
  svg += label(284, 222, back_lit ? "lit" : "lit and seen", "end");
  svg += label(356, 206, "back: " + std::string("z+"), "start");
  if (back_lit) svg += label(356, 222, "seen", "start");
  // Axes: the projector looks along z, its picture's x is to its right, down the page.
  svg +=
      "<path d=\"M300 255 h50 m-8 -5 l8 5 l-8 5 M300 255 v45 m-5 -8 l5 8 l5 -8\" fill=\"none\" "
      "stroke=\"#222\"/>\n";
  svg += label(360, 259, "z, along the light", "start") +
         label(308, 312, "x, as in the projector's picture; y is down, as there", "start");
  return svg + "</svg>\n";
}

}  // namespace kappamu::capture
