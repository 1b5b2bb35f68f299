#include "calib/linear_frame.h"

#include <algorithm>
#include <vector>

#include "calib/targets/chessboard.h"
#include "capture/session/frames.h"

namespace kappamu::calib {
namespace {

/// Row by row as it is decoded: no picture of codes in three channels is held. `values[c]` has the
/// value of each code of a channel, or one table serves all.
Image<float> luminance(const capture::Session& session, const capture::Frame& frame,
                       const std::vector<std::vector<float>>& values) {
  const std::size_t channels = session.channels.size();
  Image<float> grey(session.camera.width, session.camera.height, 1);
  Image<float> row(grey.width(), 1, static_cast<int>(channels));
  capture::load_rows(session, frame, [&](int y, const std::uint16_t* codes) {
    for (std::size_t c = 0; c < channels; ++c) {
      const std::vector<float>& table = values[std::min(c, values.size() - 1)];
      for (std::size_t k = c; k < row.size(); k += channels) {
        // Codes beyond the bit depth are refused when the last row has come.
        row.values()[k] = table[std::min<std::size_t>(codes[k], table.size() - 1)];
      }
    }
    if (channels != 3) {
      for (int x = 0; x < grey.width(); ++x) grey(x, y) = row(x, 0);
      return;
    }
    for (int x = 0; x < grey.width(); ++x) grey(x, y) = luminance_of(&row(x, 0));
  });
  return grey;
}

}  // namespace

Image<float> load_codes(const capture::Session& session, const capture::Frame& frame) {
  std::vector<float> same(static_cast<std::size_t>(capture::largest_code(session.camera)) + 1);
  for (std::size_t code = 0; code < same.size(); ++code) same[code] = static_cast<float>(code);
  return luminance(session, frame, {same});
}

Image<float> load_linear(const capture::Session& session, const capture::Frame& frame,
                         const capture::Radiometry& radiometry) {
  if (capture::is_float_frame(session, frame))
    return to_grey(capture::load_float_frame(session, frame));
  std::vector<std::vector<float>> values;
  for (const std::vector<double>& linear : radiometry.response.linear) {
    values.emplace_back(linear.begin(), linear.end());
  }
  return luminance(session, frame, values);
}

}  // namespace kappamu::calib
