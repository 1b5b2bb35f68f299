// What the values of a session must fulfil, alone and together; used on reading and on writing.
#include <cmath>
#include <map>

#include "capture/session/field_check.h"

namespace kappamu::capture {
namespace {

constexpr int largest_image_extent = 65535;  // [px], of the file formats
constexpr int largest_grid_extent = 8192;    // [voxels]

class SessionCheck : FieldCheck {
 public:
  explicit SessionCheck(const Session& session) : FieldCheck(session) {}

  void run() const {
    channels();
    smooth_error();
    sample();
    camera_and_projector();
    stations();
    patterns();
  }

 private:
  void channels() const {
    const std::vector<std::string> rgb{"R", "G", "B"};
    require(session_.channels == rgb || session_.channels.size() == 1, "channels",
            "must be [\"R\", \"G\", \"B\"] or the name of one channel");
    for (std::size_t i = 0; i < session_.channels.size(); ++i) {
      name(session_.channels[i], indexed("channels", i));
    }
  }

  void smooth_error() const {
    if (!session_.smooth_error) return;
    for (const double error : {session_.smooth_error->common, session_.smooth_error->own}) {
      require(error >= 0.0 && error <= 1.0, "smooth_error",
              "is " + shown(error) + "; relative errors must lie between 0 and 1");
    }
  }

  void sample() const {
    const Sample& sample = session_.sample;
    require(!sample.name.empty(), "sample.name", "is empty; give the sample a name");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      whole(sample.grid[axis], 1, largest_grid_extent, indexed("sample.grid", axis));
    }
    positive(sample.voxel_mm, "sample.voxel_mm", " of millimetres");
    require(sample.eta >= 1.0 && sample.eta <= 4.0, "sample.eta",
            "is " + shown(sample.eta) + "; a refractive index must lie between 1 and 4");
    const bool opposite_faces = sample.seen_face == opposite(sample.lit_face);
    if (session_.setup == Setup::back_lit) {
      require(opposite_faces, "sample.seen_face",
              "is '" + to_string(sample.seen_face) + "'; in a back-lit setup it is opposite to " +
                  "the lit face: write '" + to_string(opposite(sample.lit_face)) + "'");
    } else {
      require(sample.seen_face == sample.lit_face, "sample.seen_face",
              "is '" + to_string(sample.seen_face) +
                  "'; in a front-lit setup it is the lit face: " + "write '" +
                  to_string(sample.lit_face) + "'");
    }
  }

  void raw_layout(const Camera& camera, const io::RawLayout& layout) const {
    const std::string field = "camera.raw_layout";
    require(
        layout.bits == 8 || layout.bits == 16, field + ".bits",
        "is " + std::to_string(layout.bits) + "; a stored code has 8 or 16 bits: unpack the files");
    require(camera.bit_depth <= layout.bits, "camera.bit_depth",
            "is " + std::to_string(camera.bit_depth) + ", more than the " +
                std::to_string(layout.bits) + " bits of " + field);
    require(layout.offset >= 0, field + ".offset",
            "is " + std::to_string(layout.offset) + "; it must not be negative");
    require(session_.channels.size() == (layout.mosaic ? 3 : 1), "channels",
            layout.mosaic ? "must be [\"R\", \"G\", \"B\"] where " + field + " has a mosaic"
                          : "must be one where " + field + ".mosaic is 'none'");
    require(!layout.mosaic || (camera.width % 2 == 0 && camera.height % 2 == 0),
            "camera.width and height", "must be even where " + field + " has a mosaic");
  }

  void camera_and_projector() const {
    const Camera& camera = session_.camera;
    whole(camera.width, 1, largest_image_extent, "camera.width");
    whole(camera.height, 1, largest_image_extent, "camera.height");
    whole(camera.bit_depth, 8, 16, "camera.bit_depth");
    if (camera.white_level) {
      const int top = (1 << camera.bit_depth) - 1;
      whole(*camera.white_level, top / 4, top, "camera.white_level");
      require(
          camera.encoding == Encoding::linear, "camera.white_level",
          "is stated although encoding is 'response'; it belongs to linear frames: leave it out");
    }
    if (camera.orientation) whole(*camera.orientation, 1, 8, "camera.orientation");
    if (camera.raw_layout) raw_layout(camera, *camera.raw_layout);
    if (camera.electrons_full_scale) {
      positive(*camera.electrons_full_scale, "camera.electrons_full_scale", " of electrons");
    }
    if (camera.read_noise_electrons) {
      const double noise = *camera.read_noise_electrons;
      require(std::isfinite(noise) && noise >= 0.0, "camera.read_noise_electrons",
              "is " + shown(noise) + "; it must not be negative");
    }
    whole(session_.projector.width, 1, largest_image_extent, "projector.width");
    whole(session_.projector.height, 1, largest_image_extent, "projector.height");
  }

  void stations() const {
    name(session_.calibration_station, "stations.calibration");
    name(session_.pattern_station, "stations.patterns");
    require(session_.setup == Setup::front_lit ||
                session_.calibration_station != session_.pattern_station,
            "stations.patterns",
            "is '" + session_.pattern_station +
                "' like stations.calibration; in a back-lit setup the camera sees the lit face " +
                "from one station and the patterns from another: give them two names");
  }

  void patterns() const {
    require(!session_.patterns.empty(), "patterns", "is empty; list at least one pattern");
    std::map<std::string, std::size_t> seen;
    bool any_fit = false;
    for (std::size_t i = 0; i < session_.patterns.size(); ++i) {
      const Pattern& pattern = session_.patterns[i];
      const std::string field = indexed("patterns", i);
      name(pattern.id, field + ".id");
      const auto [first, is_new] = seen.emplace(pattern.id, i);
      require(is_new, field + ".id",
              "is '" + pattern.id + "' like that of " + indexed("patterns", first->second) +
                  "; give every pattern its own id");
      relative_path(pattern.image, field + ".image");
      stack(pattern.frames, field + ".frames");
      require(pattern.station.empty() || pattern.station == session_.pattern_station ||
                  pattern.station == session_.calibration_station,
              field + ".station",
              "is '" + pattern.station + "'; it must be one of those in stations ('" +
                  session_.calibration_station + "', '" + session_.pattern_station + "')");
      require(session_.calibration.ambient.empty() || pattern.station.empty() ||
                  pattern.station == session_.pattern_station,
              field + ".station",
              "is '" + pattern.station +
                  "' in a room that is not dark: calibration.ambient is "
                  "seen from '" +
                  session_.pattern_station + "' alone; darken the room");
      any_fit |= pattern.role == PatternRole::fit;
    }
    require(any_fit, "patterns", "has no pattern of role 'fit'; the fit needs at least one");
  }
};

}  // namespace

void validate(const Session& session) {
  SessionCheck(session).run();
  check_calibration(session);
}

}  // namespace kappamu::capture
