#include "tests/capture/session/bad_sessions.h"

#include <functional>
#include <nlohmann/json.hpp>

#include "tests/capture/session_files.h"

namespace kappamu::capture {
namespace {

using nlohmann::json;

json frame(const char* file, double exposure_s) {
  return {{"file", file}, {"exposure_s", exposure_s}};
}

}  // namespace

std::vector<EditedSession> good_sessions() {
  std::vector<EditedSession> sessions;
  const json example = json::parse(documented_session_text());
  const auto add = [&](const std::string& name, const std::function<void(json&)>& edit) {
    json document = example;
    edit(document);
    sessions.push_back({name, document.dump()});
  };
  add("unchanged", [](json&) {});
  add("noise figures left out", [](json& s) {
    s["camera"].erase("electrons_full_scale");
    s["camera"].erase("read_noise_electrons");
  });
  add("no white target", [](json& s) { s["calibration"].erase("white_target"); });
  add("no black frames", [](json& s) { s["calibration"]["white_target"].erase("black_frames"); });
  add("no chart", [](json& s) { s["calibration"].erase("colour_chart"); });
  add("outline by hand", [](json& s) {
    s["calibration"]["sample_views"][0]["corners_px"] = {{1, 1}, {600, 1}, {600, 400}, {1, 400.5}};
  });
  add("front-lit from one station", [](json& s) {
    s["setup"] = "front-lit";
    s["sample"]["seen_face"] = "z-";
    s["stations"]["patterns"] = "front";
    s["calibration"]["sample_views"].erase(1);
  });
  add("circles", [](json& s) { s["calibration"]["board"]["kind"] = "asymmetric-circles"; });
  add("charuco", [](json& s) {
    json& board = s["calibration"]["board"];
    board["kind"] = "charuco";
    board["marker_mm"] = 3.0;
    board["dictionary"] = "DICT_5X5_100";
  });
  add("one channel", [](json& s) { s["channels"] = {"Y"}; });
  add("whole number written with a point", [](json& s) { s["camera"]["width"] = 640.0; });
  add("white level of a RAW camera", [](json& s) {
    s["camera"]["encoding"] = "linear";
    s["camera"]["white_level"] = 3900;
  });
  add("headerless RAW", [](json& s) {
    s["camera"]["encoding"] = "linear";
    s["camera"]["raw_layout"] = {
        {"bits", 16}, {"byte_order", "big"}, {"offset", 32}, {"mosaic", "GBRG"}};
  });
  add("known instrument", [](json& s) { s["smooth_error"] = {{"common", 0}, {"own", 5e-3}}; });
  add("known lens", [](json& s) {
    s["calibration"]["lens"] = {{"file", "calibration/camera.yml"}, {"use", "start"}};
  });
  add("no read noise", [](json& s) { s["camera"]["read_noise_electrons"] = 0; });
  add("another axis", [](json& s) {
    s["sample"]["lit_face"] = "x+";
    s["sample"]["seen_face"] = "x-";
    s["calibration"]["sample_views"][0]["face"] = "x+";
    s["calibration"]["sample_views"][1]["face"] = "x-";
  });
  add("Gray codes and no chessboard", [](json& s) {
    json& plane = s["calibration"]["projector_planes"][0];
    plane.erase("projected");
    s["calibration"].erase("projected_board");
    plane["gray_code"] = json::array();
    for (int k = 0; k < 42; ++k) {
      plane["gray_code"].push_back(frame(("gray_" + std::to_string(k) + ".png").c_str(), 0.1));
    }
  });
  add("room light and projector levels", [](json& s) {
    json& white = s["calibration"]["white_target"];
    const json frames = json::array({frame("f.png", 0.1), frame("g.png", 0.2)});
    white["off_frames"] = frames;
    white["levels"] = {{{"value", 64}, {"frames", frames}}, {{"value", 128}, {"frames", frames}}};
    s["calibration"]["ambient"] = {{{"frames", frames}}, {{"frames", frames}}};
  });
  add("a pattern kept for validation", [](json& s) {
    json pattern = s["patterns"][0];
    pattern["id"] = "held_out.00";
    pattern["role"] = "validate";
    s["patterns"].push_back(pattern);
  });
  return sessions;
}

std::vector<BadSession> bad_sessions() {
  std::vector<BadSession> sessions;
  const json example = json::parse(documented_session_text());
  const auto add = [&](const std::string& name, const std::string& field, const std::string& says,
                       const std::function<void(json&)>& edit) {
    json document = example;
    edit(document);
    sessions.push_back({{name, document.dump()}, field, says, true});
  };
  // Rules across fields, which JSON Schema cannot state.
  const auto add_across = [&](const std::string& name, const std::string& field,
                              const std::string& says, const std::function<void(json&)>& edit) {
    add(name, field, says, edit);
    sessions.back().schema_sees_it = false;
  };

  add("half of a known instrument", "smooth_error.own", "is missing", [](json& s) {
    s["smooth_error"] = {{"common", 1e-3}};
  });
  add("instrument of per cents", "smooth_error", "is 2; relative errors must lie between 0 and 1",
      [](json& s) {
        s["smooth_error"] = {{"common", 2}, {"own", 0.5}};
      });
  add("instrument with a source", "smooth_error.source", "is an unknown field", [](json& s) {
    s["smooth_error"] = {{"common", 1e-3}, {"own", 1e-3}, {"source", "data sheet"}};
  });
  add("lens without a use", "calibration.lens.use", "is missing", [](json& s) {
    s["calibration"]["lens"] = {{"file", "camera.yml"}};
  });
  add("lens of another use", "calibration.lens.use", "is 'fixed'; write 'held' or 'start'",
      [](json& s) {
        s["calibration"]["lens"] = {{"file", "camera.yml"}, {"use", "fixed"}};
      });
  add("lens outside", "calibration.lens.file", "stay inside", [](json& s) {
    s["calibration"]["lens"] = {{"file", "../camera.yml"}, {"use", "held"}};
  });
  add("another format", "format", "is 'kappamu-measurements'; write 'kappamu-session'",
      [](json& s) { s["format"] = "kappamu-measurements"; });
  add("a later version", "version", "reads version 1", [](json& s) { s["version"] = 2; });
  add("a list", "the document", "object in braces", [](json& s) { s = json::array(); });
  add("centimetres", "units.length", "is 'cm'; kappamu sessions are in 'mm'",
      [](json& s) { s["units"]["length"] = "cm"; });
  add("milliseconds", "units.time", "is 'ms'; kappamu sessions are in 's'",
      [](json& s) { s["units"]["time"] = "ms"; });
  add("unit missing", "units.time", "is missing", [](json& s) { s["units"].erase("time"); });
  add("misspelt setup", "setup", "is 'backlit'; write 'back-lit' or 'front-lit'",
      [](json& s) { s["setup"] = "backlit"; });
  add("two channels", "channels", "must be", [](json& s) { s["channels"] = {"R", "G"}; });
  add("unknown field at the top", "samples", "is an unknown field",
      [](json& s) { s["samples"] = 1; });
  add("unknown field deep down", "patterns[0].frames[1].exposure", "is an unknown field",
      [](json& s) { s["patterns"][0]["frames"][1]["exposure"] = 1; });
  add("unknown field in the camera", "camera.iso", "is an unknown field",
      [](json& s) { s["camera"]["iso"] = 100; });
  add("field missing", "sample.eta", "is missing", [](json& s) { s["sample"].erase("eta"); });
  add("calibration missing", "calibration", "is missing", [](json& s) { s.erase("calibration"); });
  add("text for a number", "camera.width", "is a text; write a number",
      [](json& s) { s["camera"]["width"] = "640"; });
  add("number for a text", "sample.name", "is 7; write a text",
      [](json& s) { s["sample"]["name"] = 7; });
  add("broken number of pixels", "camera.height", "is 480.5; write a whole number",
      [](json& s) { s["camera"]["height"] = 480.5; });
  add("null", "camera.read_noise_electrons", "is null; write a number",
      [](json& s) { s["camera"]["read_noise_electrons"] = nullptr; });
  add("object for a list", "patterns", "is an object; write a list",
      [](json& s) { s["patterns"] = json::object(); });
  add("no width", "camera.width", "is 0", [](json& s) { s["camera"]["width"] = 0; });
  add("17 bits", "camera.bit_depth", "between 8 and 16",
      [](json& s) { s["camera"]["bit_depth"] = 17; });
  add("encoding misspelt", "camera.encoding", "write 'linear' or 'response'",
      [](json& s) { s["camera"]["encoding"] = "gamma"; });
  add("no electrons", "camera.electrons_full_scale", "positive",
      [](json& s) { s["camera"]["electrons_full_scale"] = 0; });
  add("negative read noise", "camera.read_noise_electrons", "must not be negative",
      [](json& s) { s["camera"]["read_noise_electrons"] = -1; });
  add("empty grid", "sample.grid[1]", "is 0", [](json& s) { s["sample"]["grid"][1] = 0; });
  add("flat grid", "sample.grid", "has 2 entries; it needs exactly 3", [](json& s) {
    s["sample"]["grid"] = {40, 32};
  });
  add("no voxel", "sample.voxel_mm", "positive", [](json& s) { s["sample"]["voxel_mm"] = 0; });
  add("eta below air", "sample.eta", "between 1 and 4", [](json& s) { s["sample"]["eta"] = 0.9; });
  add("no such face", "sample.lit_face", "is 'front'",
      [](json& s) { s["sample"]["lit_face"] = "front"; });
  add("back-lit, seen face lit", "sample.seen_face", "write 'z+'",
      [](json& s) { s["sample"]["seen_face"] = "z-"; });
  add("front-lit, seen face dark", "sample.seen_face", "write 'z-'",
      [](json& s) { s["setup"] = "front-lit"; });
  add("sample unnamed", "sample.name", "is empty", [](json& s) { s["sample"]["name"] = ""; });
  add("no patterns", "patterns", "needs at least 1", [](json& s) { s["patterns"].clear(); });
  add("pattern without frames", "patterns[0].frames", "needs at least 1",
      [](json& s) { s["patterns"][0]["frames"].clear(); });
  add("role misspelt", "patterns[0].role", "write 'fit' or 'validate'",
      [](json& s) { s["patterns"][0]["role"] = "train"; });
  add("nothing to fit", "patterns", "no pattern of role 'fit'",
      [](json& s) { s["patterns"][0]["role"] = "validate"; });
  add("id with a slash", "patterns[0].id", "use letters",
      [](json& s) { s["patterns"][0]["id"] = "a/b"; });
  add("zero exposure", "patterns[0].frames[0].exposure_s", "is 0; it must be a positive number",
      [](json& s) { s["patterns"][0]["frames"][0]["exposure_s"] = 0; });
  add("negative exposure", "calibration.dark[0].exposure_s", "positive",
      [](json& s) { s["calibration"]["dark"][0]["exposure_s"] = -0.1; });
  add("absolute file", "patterns[0].image", "relative to the session folder",
      [](json& s) { s["patterns"][0]["image"] = "/etc/passwd"; });
  add("file outside", "calibration.dark[0].file", "stay inside",
      [](json& s) { s["calibration"]["dark"][0]["file"] = "a/../../b.png"; });
  add("nameless file", "calibration.camera_boards[0].file", "is empty",
      [](json& s) { s["calibration"]["camera_boards"][0]["file"] = ""; });
  add("board too small", "calibration.board.rows", "between 3 and",
      [](json& s) { s["calibration"]["board"]["rows"] = 2; });
  add("board without size", "calibration.board.square_mm", "is missing",
      [](json& s) { s["calibration"]["board"].erase("square_mm"); });
  add("board of an unknown kind", "calibration.board.kind", "is 'dots'; write 'chessboard'",
      [](json& s) { s["calibration"]["board"]["kind"] = "dots"; });
  add("markers on a chessboard", "calibration.board.marker_mm", "is an unknown field",
      [](json& s) { s["calibration"]["board"]["marker_mm"] = 3; });
  const auto charuco = [](json& s, double marker_mm, const char* dictionary) {
    s["calibration"]["board"].update(
        {{"kind", "charuco"}, {"marker_mm", marker_mm}, {"dictionary", dictionary}});
  };
  add("unknown dictionary", "calibration.board.dictionary", "is '4X4'; write one of DICT_4X4_50, ",
      [charuco](json& s) { charuco(s, 3.0, "4X4"); });
  add_across("Gray code cut short", "calibration.projector_planes[0].gray_code",
             "has 41 entries; the Gray code of a 1024 x 768 projector has 42", [](json& s) {
               json& code = s["calibration"]["projector_planes"][0]["gray_code"] = json::array();
               for (int k = 0; k < 41; ++k) {
                 code.push_back(frame(("gray_" + std::to_string(k) + ".png").c_str(), 0.1));
               }
             });
  const auto code = [](json& s, std::size_t plane) {
    json& frames = s["calibration"]["projector_planes"][plane]["gray_code"] = json::array();
    for (int k = 0; k < 42; ++k) {
      frames.push_back(frame(("gray_" + std::to_string(k) + ".png").c_str(), 0.1));
    }
  };
  add_across("Gray code at two exposure times", "calibration.projector_planes[0].gray_code",
             "has exposure times of 0.1 s and 0.2 s (gray_7.png)", [code](json& s) {
               code(s, 0);
               s["calibration"]["projector_planes"][0]["gray_code"][7]["exposure_s"] = 0.2;
             });
  add("planes of two kinds", "calibration.projector_planes[0]",
      "has no projected chessboard and calibration.projector_planes[1] no code", [code](json& s) {
        json& planes = s["calibration"]["projector_planes"];
        planes.push_back(planes[0]);
        planes[0].erase("projected");
        code(s, 0);
      });
  add("plane without light", "calibration.projector_planes[0]", "all planes need 'projected'",
      [](json& s) { s["calibration"]["projector_planes"][0].erase("projected"); });
  add("projected board untold", "calibration.projected_board",
      "is missing although calibration.projector_planes[0].projected",
      [](json& s) { s["calibration"].erase("projected_board"); });
  const auto level = [](json& s, int value) {
    s["calibration"]["white_target"]["levels"].push_back(
        {{"value", value}, {"frames", {frame("level.png", 0.1)}}});
  };
  add("projector level of white", "calibration.white_target.levels[0].value",
      "is 255; it must lie between 1 and 254", [level](json& s) { level(s, 255); });
  add_across("projector levels that fall", "calibration.white_target.levels[1].value",
             "is 64 after 128; list the values once each, rising", [level](json& s) {
               level(s, 128);
               level(s, 64);
             });
  add_across("room light on the target alone", "calibration.ambient",
             "is missing although white_target.off_frames", [](json& s) {
               s["calibration"]["white_target"]["off_frames"] = {frame("off.png", 0.1)};
             });
  add_across("room light on the sample alone", "calibration.white_target.off_frames",
             "room light would count as the projector's black", [](json& s) {
               s["calibration"]["ambient"] = {{{"frames", {frame("off.png", 0.1)}}}};
             });
  add("ambient without frames", "calibration.ambient[0].frames", "is missing",
      [](json& s) { s["calibration"]["ambient"] = {json::object()}; });
  add_across("markers over their squares", "calibration.board.marker_mm", "smaller than its square",
             [charuco](json& s) { charuco(s, 4.0, "DICT_4X4_50"); });
  add_across("more markers than the dictionary has", "calibration.board.dictionary",
             "fewer than the 35 markers",
             [charuco](json& s) { charuco(s, 3.0, "DICT_APRILTAG_16h5"); });
  add("no boards", "calibration.camera_boards", "needs at least 1",
      [](json& s) { s["calibration"]["camera_boards"].clear(); });
  add("no planes", "calibration.projector_planes", "needs at least 1",
      [](json& s) { s["calibration"]["projector_planes"].clear(); });
  add("no dark frames", "calibration.dark", "needs at least 1",
      [](json& s) { s["calibration"]["dark"].clear(); });
  add("white beyond white", "calibration.white_target.reflectance", "is 1.2",
      [](json& s) { s["calibration"]["white_target"]["reflectance"] = 1.2; });
  add("three corners", "calibration.sample_views[0].corners_px", "needs exactly 4", [](json& s) {
    s["calibration"]["sample_views"][0]["corners_px"] = {{1, 1}, {2, 1}, {2, 2}};
  });
  add("origin in one number", "calibration.projected_board.origin_px", "is 500; write a list",
      [](json& s) { s["calibration"]["projected_board"]["origin_px"] = 500; });

  const auto headerless = [](json& s) -> json& {
    s["camera"]["encoding"] = "linear";
    s["camera"]["raw_layout"] = {
        {"bits", 16}, {"byte_order", "little"}, {"offset", 0}, {"mosaic", "RGGB"}};
    return s["camera"]["raw_layout"];
  };
  add("packed codes", "camera.raw_layout.bits", "is 12",
      [=](json& s) { headerless(s)["bits"] = 12; });
  add("negative offset", "camera.raw_layout.offset", "is -4",
      [=](json& s) { headerless(s)["offset"] = -4; });
  add("unknown mosaic", "camera.raw_layout.mosaic", "RGGB",
      [=](json& s) { headerless(s)["mosaic"] = "RGB"; });
  add_across("codes longer than their bytes", "camera.bit_depth", "more than the 8 bits",
             [=](json& s) { headerless(s)["bits"] = 8; });
  add_across("a grey camera of three channels", "channels", "must be one",
             [=](json& s) { headerless(s)["mosaic"] = "none"; });
  add_across("an odd mosaic", "camera.width and height", "must be even", [=](json& s) {
    headerless(s);
    s["camera"]["width"] = 639;
  });

  add_across("white level beyond the codes", "camera.white_level", "between 1023 and 4095",
             [](json& s) {
               s["camera"]["encoding"] = "linear";
               s["camera"]["white_level"] = 5000;
             });
  add_across("white level behind a curve", "camera.white_level", "although encoding is 'response'",
             [](json& s) { s["camera"]["white_level"] = 3900; });
  add_across("one file twice", "patterns[0].frames[1].file", "is the same file", [](json& s) {
    s["patterns"][0]["frames"][1]["file"] = s["patterns"][0]["frames"][0]["file"];
  });
  add_across("equal ids", "patterns[1].id", "like that of patterns[0]",
             [](json& s) { s["patterns"].push_back(s["patterns"][0]); });
  add_across("one station back-lit", "stations.patterns", "give them two names",
             [](json& s) { s["stations"]["patterns"] = "front"; });
  add_across("station without a view", "calibration.sample_views", "no view from station 'back'",
             [](json& s) { s["calibration"]["sample_views"].erase(1); });
  add_across("view from nowhere", "calibration.sample_views[1].station", "is 'side'",
             [](json& s) { s["calibration"]["sample_views"][1]["station"] = "side"; });
  add_across("view of another face", "calibration.sample_views[0].face", "sees 'z-'",
             [](json& s) { s["calibration"]["sample_views"][0]["face"] = "y-"; });
  add_across("corner outside the picture", "calibration.sample_views[0].corners_px[1][0]",
             "camera's 640 pixels", [](json& s) {
               s["calibration"]["sample_views"][0]["corners_px"] = {
                   {1, 1}, {700, 1}, {600, 400}, {1, 400}};
             });
  add_across("board beyond the projector", "calibration.projected_board.origin_px[0]",
             "projector's 1024 pixels",
             [](json& s) { s["calibration"]["projected_board"]["square_px"] = 70; });

  const std::string text = documented_session_text();
  sessions.push_back({{"cut off", text.substr(0, 700)}, "not valid JSON", "", true});
  sessions.push_back({{"empty", ""}, "not valid JSON", "", true});
  std::string doubled = text;
  doubled.insert(doubled.find("\"setup\""), "\"version\": 1, ");
  sessions.push_back({{"field twice", doubled}, "field 'version'", "occurs twice", false});
  return sessions;
}

}  // namespace kappamu::capture
