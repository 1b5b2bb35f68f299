#include <algorithm>

#include "core/error.h"
#include "io/image/image_file.h"
#include "report/drawing/picture.h"
#include "report/sections.h"

namespace kappamu::report {

namespace {

constexpr int thumbnail_width = 132;  // CSS px
constexpr int thumbnail_pixels = 160;

std::string exposures_of(const capture::Stack& frames) {
  const auto [shortest, longest] = std::minmax_element(
      frames.begin(), frames.end(),
      [](const capture::Frame& a, const capture::Frame& b) { return a.exposure_s < b.exposure_s; });
  if (frames.size() == 1) return number(shortest->exposure_s) + " s";
  return std::to_string(frames.size()) + " exposures, " + number(shortest->exposure_s) + " to " +
         number(longest->exposure_s) + " s";
}

/// The picture the projector showed; a note where its file is gone.
Html pattern_picture(const capture::Session& session, const capture::Pattern& pattern) {
  try {
    const Image<std::uint16_t> codes = io::read_code_image(session.folder / pattern.image);
    Image<float> grey(codes.width(), codes.height(), 1);
    for (int y = 0; y < codes.height(); ++y)
      for (int x = 0; x < codes.width(); ++x) grey(x, y) = static_cast<float>(codes(x, y));
    Image<float> small = reduced(grey, thumbnail_pixels);
    Image<std::uint8_t> shown(small.width(), small.height(), 1);
    for (std::size_t i = 0; i < small.size(); ++i)
      shown.values()[i] = static_cast<std::uint8_t>(std::min(255.0F, small.values()[i]));
    return picture(shown, thumbnail_width, "pattern " + pattern.id);
  } catch (const InputError&) {
    return note("pattern file not readable");
  }
}

Html sample_table(const capture::Session& session) {
  const capture::Sample& sample = session.sample;
  const auto size = [&](int axis) {
    return number(sample.grid[static_cast<std::size_t>(axis)] * sample.voxel_mm);
  };
  std::size_t fit = 0;
  for (const capture::Pattern& pattern : session.patterns)
    fit += pattern.role == capture::PatternRole::fit ? 1 : 0;
  std::vector<std::vector<std::string>> lines{
      {"sample", sample.name},
      {"block", size(0) + " × " + size(1) + " × " + size(2) + " mm"},
      {"grid", std::to_string(sample.grid[0]) + " × " + std::to_string(sample.grid[1]) + " × " +
                   std::to_string(sample.grid[2]) + " voxels of " + number(sample.voxel_mm) +
                   " mm"},
      {"refractive index", number(sample.eta)},
      {"setup", session.setup == capture::Setup::back_lit ? "back-lit" : "front-lit"},
      {"faces", "lit " + to_string(sample.lit_face) + ", seen " + to_string(sample.seen_face)},
      {"camera",
       std::to_string(session.camera.width) + " × " + std::to_string(session.camera.height) +
           " px, " + std::to_string(session.camera.bit_depth) + " bit, " +
           (session.camera.encoding == capture::Encoding::linear ? "linear"
                                                                 : "response curve recovered")},
      {"projector", std::to_string(session.projector.width) + " × " +
                        std::to_string(session.projector.height) + " px"},
      {"patterns", std::to_string(fit) + " for the fit, " +
                       std::to_string(session.patterns.size() - fit) + " for validation"},
      {"calibration shots",
       std::to_string(session.calibration.camera_boards.size()) + " board views, " +
           std::to_string(session.calibration.projector_planes.size()) + " projector planes"}};
  if (!session.description.empty()) lines.push_back({"captured by", session.description});
  std::vector<std::vector<Html>> rows;
  rows.reserve(lines.size());
  for (const auto& line : lines) rows.push_back({text(line[0]), text(line[1])});
  return table({}, rows);
}

Html measurements_table(const SurfaceMeasurements& measured) {
  std::string channels;
  for (const std::string& channel : measured.channels)
    channels += (channels.empty() ? "" : ", ") + channel;
  const GridShape& grid = measured.grid;
  return table(
      {}, {{text("grid"),
            text(std::to_string(grid.nx) + " × " + std::to_string(grid.ny) + " × " +
                 std::to_string(grid.nz) + " voxels of " + number(grid.voxel_mm) + " mm")},
           {text("refractive index"), text(number(measured.eta))},
           {text("faces"),
            text("lit " + to_string(measured.lit_face) + ", seen " + to_string(measured.seen_face) +
                 (measured.two_faces() ? " and " + to_string(opposite(measured.seen_face)) : ""))},
           {text("light"), text(to_string(measured.light))},
           {text("quantity"), text(to_string(measured.quantity))},
           {text("patterns"), text(std::to_string(measured.patterns))},
           {text("channels"), text(channels)}});
}

Html pattern_gallery(const RunData& run) {
  std::vector<Html> blocks;
  for (const capture::Pattern& pattern : run.session->patterns) {
    Html block = pattern_picture(*run.session, pattern);
    const auto hdr = std::find_if(run.hdr.begin(), run.hdr.end(), [&](const HdrSummary& summary) {
      return summary.pattern == pattern.id;
    });
    if (hdr != run.hdr.end())
      block += picture(tone_mapped(hdr->thumbnail, hdr->bright), thumbnail_width,
                       "HDR of " + pattern.id);
    const bool validates = pattern.role == capture::PatternRole::validate;
    blocks.push_back(figure(block, pattern.id + (validates ? " (validation)" : "") + ": " +
                                       exposures_of(pattern.frames)));
  }
  return row(blocks);
}

}  // namespace

Html capture_section(const RunData& run) {
  Html content;
  if (run.session) {
    content += sample_table(*run.session);
    content += subsection("Patterns, what the camera saw (HDR, tone-mapped), exposure times",
                          pattern_gallery(run));
  } else {
    if (run.record && run.record->input_kind == pipeline::RunRecord::InputKind::session)
      content += note("The session folder could not be read; what was captured is not shown.");
    if (run.fit_patterns) content += measurements_table(run.fit_patterns->measured);
  }
  return section("What was captured", content);
}

}  // namespace kappamu::report
