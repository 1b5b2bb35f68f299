// Main memory of the machine and of this process [bytes].
#pragma once

#include <string>

namespace kappamu {

double main_memory();
/// The most that this process has held so far.
double peak_memory();

/// "5.4 GB".
std::string gigabytes(double bytes);

}  // namespace kappamu
