// A whole page in the report's style.
#pragma once

#include <string>

#include "report/drawing/html.h"

namespace kappamu::report {

/// Self-contained; `title` is the window's.
Html whole_page(const std::string& title, const Html& body);

}  // namespace kappamu::report
