// What is known of a block beforehand: H1, whatever the fit's regulariser, since where edges are is
// what is found.
#pragma once

namespace kappamu::inverse {

struct Prior {
  double weight = 1.0;            ///< α
  double anchor_length_mm = 1.0;  ///< L
};

}  // namespace kappamu::inverse
