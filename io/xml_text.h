// Text inside XML and HTML.
#pragma once

#include <string>
#include <string_view>

namespace kappamu::io {

/// `text` with &, <, > and double quotes replaced, for contents and for attributes in double
/// quotes.
std::string xml_escaped(std::string_view text);

}  // namespace kappamu::io
