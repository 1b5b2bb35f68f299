// Opening the photographs of a session: every mistake is reported with the file's name.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "capture/session/session.h"
#include "core/image.h"
#include "core/numbers/region.h"
#include "io/image/raw_file.h"

namespace kappamu::capture {

/// The largest code value, 2^bit_depth - 1.
inline int largest_code(const Camera& camera) {
  return (1 << camera.bit_depth) - 1;
}

/// What errors about a session begin with: the session.json that was read or, where it was made
/// otherwise, the one in its folder or else the folder.
std::string shown_session(const Session& session);

/// Whether the frame is a picture of linear floats (EXR, float TIFF) rather than code values.
bool is_float_frame(const Session& session, const Frame& frame);

/// The region of the upright picture that is wanted, or all of it. Of a mosaic its edges lie
/// between 2 x 2 cells. What lies outside is not checked.
using Part = std::optional<Region>;

/// Code values 0 ... largest_code, [y][x][channel], the session's channels. Float frames hold
/// linear light as fractions of full scale; here they are rounded to codes (no black level) and cut
/// to the range. Frames are turned by the camera's orientation, if any; RAW frames are demosaiced
/// bilinearly, linear, black not subtracted. Where the camera's encoding is a response, borders
/// that software filled in are saturated (filled_border.h). Throws InputError naming the file if it
/// is missing, truncated, of another size or number of channels than the session tells, stored with
/// 8 bits though the camera has more, or holds codes beyond the bit depth.
Image<std::uint16_t> load_frame(const Session& session, const Frame& frame, const Part& part = {});

/// The same row by row, [x][channel], in order from `y` = 0 of the part on, without a picture of
/// them where the frame's kind allows that. All come a second time, which counts, where a filled
/// border is met on the way. Throws as load_frame(), at the end for codes beyond the bit depth.
using TakeRow = std::function<void(int y, const std::uint16_t* codes)>;
void load_rows(const Session& session, const Frame& frame, const TakeRow& take,
               const Part& part = {});

/// Codes that no interpolation has touched, for statistics of black and noise: of a RAW frame the
/// sites of each 2 x 2 cell as R, one G and B, half the extent; otherwise as load_frame().
Image<std::uint16_t> load_sites(const Session& session, const Frame& frame);

/// Whether the file is a RAW one without a header, whose layout the camera's description has.
bool is_headerless(const Camera& camera, const std::filesystem::path& file);

/// Whether the frame holds a sensor's own codes, or those of a linear DNG: a camera RAW file, or
/// one without a header whose layout the session describes.
bool is_raw_frame(const Session& session, const Frame& frame);

/// What the projector showed, codes 0 to 255. Throws InputError where it is not grey, of other bits
/// or not of the projector's size.
Image<std::uint16_t> load_pattern(const Session& session, const Pattern& pattern);

/// A RAW frame's codes, a mosaic's or of every channel. Throws as load_frame() does, and where the
/// session's camera is not linear or has another white level than the file. Without a header the
/// session's white level is taken.
io::RawImage load_raw_frame(const Session& session, const Frame& frame, const Part& part = {});

/// A float frame as it is: linear light as fractions of full scale, 1 and above saturated. Throws
/// as load_frame() does, and for values that are not finite or far beyond saturation.
Image<float> load_float_frame(const Session& session, const Frame& frame, const Part& part = {});

}  // namespace kappamu::capture
