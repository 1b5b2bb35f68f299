#include "calib/linear_frame.h"

#include <algorithm>

#include "calib/targets/chessboard.h"
#include "capture/session/frames.h"

namespace kappamu::calib {
namespace {

/// Without a picture of floats in three channels between: row by row.
template <class Linear>
Image<float> luminance(const Image<std::uint16_t>& codes, const Linear& linear) {
  const auto channels = static_cast<std::size_t>(codes.channels());
  Image<float> grey(codes.width(), codes.height(), 1);
  Image<float> row(codes.width(), 1, codes.channels());
  for (int y = 0; y < codes.height(); ++y) {
    const std::uint16_t* from = &codes(0, y);
    for (std::size_t k = 0; k < row.size(); ++k) row.values()[k] = linear(from[k], k % channels);
    const Image<float> light = to_grey(row);
    std::copy(light.values().begin(), light.values().end(), &grey(0, y));
  }
  return grey;
}

}  // namespace

Image<float> load_codes(const capture::Session& session, const capture::Frame& frame) {
  return luminance(capture::load_frame(session, frame),
                   [](std::uint16_t code, std::size_t) { return static_cast<float>(code); });
}

Image<float> load_linear(const capture::Session& session, const capture::Frame& frame,
                         const capture::Radiometry& radiometry) {
  if (capture::is_float_frame(session, frame))
    return to_grey(capture::load_float_frame(session, frame));
  return luminance(capture::load_frame(session, frame),
                   [&](std::uint16_t code, std::size_t channel) {
                     return static_cast<float>(radiometry.response.linear[channel][code]);
                   });
}

}  // namespace kappamu::calib
