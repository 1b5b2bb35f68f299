// session.json from and to Session by one description of its fields, in the order of
// docs/formats.md. What the values mean together is checked in session_check.cpp.
#include "capture/session/session.h"
#include "core/error.h"
#include "io/atomic_file.h"
#include "io/json_fields.h"

namespace kappamu::io {

template <class Fields>
void describe(Fields& fields, RawLayout& layout) {
  static constexpr Names<bool, 2> byte_orders{{{"little", false}, {"big", true}}};
  static constexpr Names<std::optional<BayerLayout>, 5> mosaics{{{"RGGB", BayerLayout{0, 1, 1, 2}},
                                                                 {"BGGR", BayerLayout{2, 1, 1, 0}},
                                                                 {"GRBG", BayerLayout{1, 0, 2, 1}},
                                                                 {"GBRG", BayerLayout{1, 2, 0, 1}},
                                                                 {"none", std::nullopt}}};
  fields("bits", layout.bits);
  fields.named("byte_order", layout.big_endian, byte_orders);
  fields("offset", layout.offset);
  fields.named("mosaic", layout.mosaic, mosaics);
}

}  // namespace kappamu::io

namespace kappamu {

template <class Fields>
void describe(Fields& fields, SmoothError& error) {
  fields("common", error.common);
  fields("own", error.own);
}

}  // namespace kappamu

namespace kappamu::capture {
namespace {

constexpr Names<PatternRole, 2> role_names{
    {{"fit", PatternRole::fit}, {"validate", PatternRole::validate}}};
constexpr Names<PhaseShift::Along, 2> along_names{
    {{"columns", PhaseShift::Along::columns}, {"rows", PhaseShift::Along::rows}}};

constexpr const char* session_file = "session.json";

}  // namespace

template <class Fields>
void describe(Fields& fields, Frame& frame) {
  fields("file", frame.file);
  fields("exposure_s", frame.exposure_s);
}

template <class Fields>
void describe(Fields& fields, Sample& sample) {
  fields("name", sample.name);
  fields("grid", sample.grid);
  fields("voxel_mm", sample.voxel_mm);
  fields("eta", sample.eta);
  fields.named("sides", sample.sides, sides_names);
  fields.named("lit_face", sample.lit_face, face_names);
  fields.named("seen_face", sample.seen_face, face_names);
  fields.kind("radiance", sample.radiance, radiance_names, Radiance::transport);
}

template <class Fields>
void describe(Fields& fields, Camera& camera) {
  fields("width", camera.width);
  fields("height", camera.height);
  fields("bit_depth", camera.bit_depth);
  fields.named("encoding", camera.encoding, encoding_names);
  fields("white_level", camera.white_level);
  fields("raw_layout", camera.raw_layout);
  fields("orientation", camera.orientation);
  fields("electrons_full_scale", camera.electrons_full_scale);
  fields("read_noise_electrons", camera.read_noise_electrons);
}

template <class Fields>
void describe(Fields& fields, Projector& projector) {
  fields("width", projector.width);
  fields("height", projector.height);
}

template <class Fields>
void describe(Fields& fields, Pattern& pattern) {
  fields("id", pattern.id);
  fields("image", pattern.image);
  fields.named("role", pattern.role, role_names);
  fields("frames", pattern.frames);
  fields.optional("station", pattern.station);
}

template <class Fields>
void describe(Fields& fields, Board& board) {
  fields("columns", board.columns);
  fields("rows", board.rows);
  fields("square_mm", board.square_mm);
  fields.kind("kind", board.kind, board_kind_names, BoardKind::chessboard);
  if (board.kind != BoardKind::charuco) return;
  fields("marker_mm", board.marker_mm);
  fields("dictionary", board.dictionary);
}

template <class Fields>
void describe(Fields& fields, ProjectedBoard& board) {
  fields("columns", board.columns);
  fields("rows", board.rows);
  fields("square_px", board.square_px);
  fields("origin_px", board.origin_px);
}

template <class Fields>
void describe(Fields& fields, PhaseShift& set) {
  fields.named("along", set.along, along_names);
  fields("period_px", set.period_px);
  fields("frames", set.frames);
}

template <class Fields>
void describe(Fields& fields, ProjectorPlane& plane) {
  fields("board", plane.board);
  fields("projected", plane.projected);
  fields.optional("gray_code", plane.gray_code);
  fields.optional("phase_shift", plane.phase_shift);
  fields.optional("correspondences", plane.correspondences);
}

template <class Fields>
void describe(Fields& fields, SampleView& view) {
  fields("station", view.station);
  fields.named("face", view.face, face_names);
  fields("frame", view.frame);
  fields("corners_px", view.corners_px);
}

template <class Fields>
void describe(Fields& fields, ProjectorLevel& level) {
  fields("value", level.value);
  fields("frames", level.frames);
}

template <class Fields>
void describe(Fields& fields, WhiteTarget& white) {
  fields("reflectance", white.reflectance);
  fields("frames", white.frames);
  fields.optional("black_frames", white.black_frames);
  fields.optional("off_frames", white.off_frames);
  fields.optional("levels", white.levels);
}

template <class Fields>
void describe(Fields& fields, ColourChart& chart) {
  fields("frames", chart.frames);
  fields("corners_px", chart.corners_px);
}

template <class Fields>
void describe(Fields& fields, LensFile& lens) {
  static constexpr Names<bool, 2> uses{{{"held", true}, {"start", false}}};
  fields("file", lens.file);
  fields.named("use", lens.held, uses);
}

template <class Fields>
void describe(Fields& fields, Calibration& calibration) {
  fields("lens", calibration.lens);
  fields("board", calibration.board);
  fields("camera_boards", calibration.camera_boards);
  fields("projected_board", calibration.projected_board);
  fields("projector_planes", calibration.projector_planes);
  fields("sample_views", calibration.sample_views);
  fields("dark", calibration.dark);
  fields("white_target", calibration.white_target);
  fields("colour_chart", calibration.colour_chart);
  fields.objects("ambient", calibration.ambient,
                 [](auto& inner, Stack& frames) { inner("frames", frames); });
}

template <class Fields>
void describe(Fields& fields, Session& session) {
  fields.format("kappamu-session");
  fields.object("units", [](auto& inner) {
    inner.fixed("length", "mm", "kappamu sessions are in 'mm': convert the numbers and write 'mm'");
    inner.fixed("time", "s", "kappamu sessions are in 's': convert the numbers and write 's'");
  });
  fields.named("setup", session.setup, setup_names);
  fields("channels", session.channels);
  fields("sample", session.sample);
  fields("camera", session.camera);
  fields("projector", session.projector);
  fields.object("stations", [&](auto& inner) {
    inner("calibration", session.calibration_station);
    inner("patterns", session.pattern_station);
  });
  fields("patterns", session.patterns);
  fields("calibration", session.calibration);
  fields.optional("description", session.description);
  fields("smooth_error", session.smooth_error);
}

Face pattern_face(const Session& session, const Pattern& pattern) {
  const bool from_calibration =
      !pattern.station.empty() && pattern.station == session.calibration_station;
  return from_calibration ? session.sample.lit_face : session.sample.seen_face;
}

Session read_session(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / session_file;
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    throw InputError(folder.string() +
                     ": no such folder; give the folder that holds session.json.");
  }
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(path.string() +
                     ": no such file; a capture session is a folder with a session.json.");
  }
  Session session;
  io::FieldReader::read(io::JsonDocument(path, "docs/formats.md").root(), session);
  session.folder = folder;
  session.source = path;
  validate(session);
  return session;
}

void write_session(const Session& session) {
  validate(session);
  const std::filesystem::path path = session.folder / session_file;
  Session written = session;
  io::write_text_atomically(path, io::FieldWriter::written(written).text(path));
}

}  // namespace kappamu::capture
