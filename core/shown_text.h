// Text of others for people to see, on a terminal and on a page.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kappamu {

/// Control characters as \xNN or \uNNNN, so that they neither steer the terminal nor hide; so are
/// marks that turn the direction of writing (Unicode Bidi_Control, UAX #9), which make a line read
/// as another, and bytes that are not UTF-8. Longer text ends in "...".
std::string shown_text(std::string_view text, std::size_t most_characters = std::string_view::npos);

/// What printf would print.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

/// A number by a format of printf for one double, such as "%.3f".
std::string shown_number(double value, const char* format = "%.6g");

}  // namespace kappamu
