#pragma once

namespace kappamu::capture {

/// Frames that are decoded at the same time, as one after the other leaves all cores but one
/// without work; no more, as each is in memory as a file meanwhile.
inline constexpr unsigned frames_at_once = 2;

}  // namespace kappamu::capture
