#include "forward/grid/rounding_floor.h"

namespace kappamu::forward {

std::string rounding_floor_sentence(Precision precision) {
  if (precision == Precision::single_precision) {
    return "this is single precision's floor, rounding to 24 bits undoes further gains; "
           "double precision goes lower";
  }
  return "this is double precision's floor, rounding to 53 bits undoes further gains; "
         "ask for a larger tolerance";
}

}  // namespace kappamu::forward
