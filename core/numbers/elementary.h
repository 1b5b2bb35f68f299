// Elementary functions of many numbers at once, in vector registers. Correct to two units in the
// last place, and the same bits on any machine.
#pragma once

#include <span>

namespace kappamu {

/// x becomes e^x; beyond ±700 it counts as that.
void exponentiate(std::span<double> x);
/// x becomes arsinh(x), with an absolute error of 1e-15 where it is small.
void take_arsinh(std::span<double> x);

}  // namespace kappamu
