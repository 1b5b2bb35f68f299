#include "calib/linear_frame.h"

#include <algorithm>

#include "calib/targets/chessboard.h"
#include "capture/session/frames.h"

namespace kappamu::calib {

Image<float> load_codes(const capture::Session& session, const capture::Frame& frame) {
  const Image<std::uint16_t> codes = capture::load_frame(session, frame);
  Image<float> image(codes.width(), codes.height(), codes.channels());
  std::transform(codes.values().begin(), codes.values().end(), image.values().begin(),
                 [](std::uint16_t code) { return static_cast<float>(code); });
  return to_grey(image);
}

Image<float> load_linear(const capture::Session& session, const capture::Frame& frame,
                         const capture::Radiometry& radiometry) {
  if (capture::is_float_frame(session, frame))
    return to_grey(capture::load_float_frame(session, frame));
  const Image<std::uint16_t> codes = capture::load_frame(session, frame);
  Image<float> image(codes.width(), codes.height(), codes.channels());
  for (std::size_t k = 0; k < codes.size(); ++k) {
    const auto channel = k % static_cast<std::size_t>(codes.channels());
    image.values()[k] = static_cast<float>(radiometry.response.linear[channel][codes.values()[k]]);
  }
  return to_grey(image);
}

}  // namespace kappamu::calib
