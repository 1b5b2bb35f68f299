#include "app/fingerprint.h"

#include <array>
#include <cstdio>
#include <limits>
#include <system_error>

#include "io/read_file.h"

namespace kappamu::app {

Fingerprint& Fingerprint::add(std::string_view piece) {
  constexpr std::uint64_t prime = 1099511628211ULL;
  const auto mix = [&](unsigned char byte) { state_ = (state_ ^ byte) * prime; };
  for (const char c : piece) mix(static_cast<unsigned char>(c));
  for (std::size_t length = piece.size(), i = 0; i < 8; ++i, length >>= 8U)
    mix(static_cast<unsigned char>(length & 0xFFU));
  return *this;
}

Fingerprint& Fingerprint::add_file(const std::filesystem::path& file) {
  add(file.filename().string());
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) return add("missing");
  const auto time = std::filesystem::last_write_time(file, error);
  if (error) return add("missing");
  return add(std::to_string(size)).add(std::to_string(time.time_since_epoch().count()));
}

std::string Fingerprint::text() const {
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(state_));
  return digits.data();
}

std::string content_fingerprint(const std::filesystem::path& file) {
  constexpr std::size_t any_size = std::numeric_limits<std::size_t>::max();
  return Fingerprint().add(io::read_text(file, any_size)).text();
}

std::string session_fingerprint(const capture::Session& session) {
  Fingerprint result;
  result.add(content_fingerprint(session.folder / "session.json"));
  const auto add_frame = [&](const capture::Frame& frame) {
    result.add_file(session.folder / frame.file);
  };
  const auto add_stack = [&](const capture::Stack& stack) {
    for (const capture::Frame& frame : stack) add_frame(frame);
  };
  for (const capture::Pattern& pattern : session.patterns) {
    result.add_file(session.folder / pattern.image);
    add_stack(pattern.frames);
  }
  const capture::Calibration& calibration = session.calibration;
  add_stack(calibration.camera_boards);
  for (const capture::ProjectorPlane& plane : calibration.projector_planes) {
    add_frame(plane.board);
    if (plane.projected) add_frame(*plane.projected);
    add_stack(plane.gray_code);
  }
  for (const capture::SampleView& view : calibration.sample_views) add_frame(view.frame);
  add_stack(calibration.dark);
  if (calibration.white_target) {
    add_stack(calibration.white_target->frames);
    add_stack(calibration.white_target->off_frames);
    for (const capture::ProjectorLevel& level : calibration.white_target->levels) {
      add_stack(level.frames);
    }
  }
  for (const capture::Stack& stack : calibration.ambient) add_stack(stack);
  add_stack(calibration.white_target_black);
  if (calibration.colour_chart) add_stack(calibration.colour_chart->frames);
  return result.text();
}

std::string measurements_fingerprint(const std::filesystem::path& folder) {
  Fingerprint result;
  result.add(content_fingerprint(folder / "measurements.json"));
  for (const char* name : {"irradiance.npy", "value.npy", "variance.npy", "mask.npy"})
    result.add_file(folder / name);
  return result.text();
}

}  // namespace kappamu::app
