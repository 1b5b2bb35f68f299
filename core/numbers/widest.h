// Functions that are compiled for the widest registers that a processor has, beside for all.
#pragma once

// Clang and the sanitizers go without: their builds are for checks.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define KAPPAMU_WIDEST __attribute__((target_clones("avx512f", "avx2", "default")))
#define KAPPAMU_WIDTHS 1  // 1: code may also be compiled for one of these widths by itself
#else
#define KAPPAMU_WIDEST
#define KAPPAMU_WIDTHS 0
#endif
