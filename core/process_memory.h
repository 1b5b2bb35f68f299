// Main memory of the machine and of this process [bytes].
#pragma once

#include <string>

namespace kappamu {

double main_memory();
/// Of it, what new work finds without paging: what is free, and what caches give back.
double available_memory();
/// Of it, what one scene, picture or solve may take.
double usable_memory();
/// The most that this process has held so far.
double peak_memory();

/// From now on what is freed stays with the process for the next allocation. Fields of tens of
/// megabytes come and go with every solve: otherwise their pages are mapped and cleared anew each
/// time, which takes a tenth of a large fit. Nothing where the C library is not glibc.
void keep_freed_memory();
/// glibc's usual rule again; what is free goes back to the system.
void return_freed_memory();

/// "5.4 GB".
std::string gigabytes(double bytes);

}  // namespace kappamu
