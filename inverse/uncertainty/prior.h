// The prior of a block: H1 for every regulariser of the fit, because the positions of edges are not
// known beforehand.
#pragma once

namespace kappamu::inverse {

struct Prior {
  double weight = 1.0;            ///< α
  double anchor_length_mm = 1.0;  ///< L
};

}  // namespace kappamu::inverse
