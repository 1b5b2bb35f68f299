// Work spread over threads by rows; results must not depend on which thread does what.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>

#include "core/threads/helpers.h"

namespace kappamu {

/// Calls work(row) for every row in [0, rows), on `threads` threads at most (0: one per core).
/// Rethrows the first exception.
template <class Work>
void for_rows(int rows, const Work& work, unsigned threads = 0) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex failure_lock;
  const auto run = [&] {
    try {
      for (int row = next++; row < rows; row = next++) work(row);
    } catch (...) {
      const std::lock_guard guard(failure_lock);
      if (!failure) failure = std::current_exception();
      next = rows;
    }
  };
  const int most = threads == 0 ? rows : std::min(rows, static_cast<int>(threads));
  share(most - 1, std::ref(run));
  if (failure) std::rethrow_exception(failure);
}

/// Elements of a vector that for_pieces() hands out at once by default.
inline constexpr std::size_t piece_length = 65536;

/// How many pieces a vector of `size` has.
inline std::size_t pieces(std::size_t size, std::size_t length = piece_length) {
  return (size + length - 1) / length;
}

/// Calls work(piece, begin, end) for every piece [begin, end) of a vector of `size`, on all cores.
/// The pieces are the same on any number of cores: sums per piece, added up in order, have the same
/// bits.
template <class Work>
void for_pieces(std::size_t size, std::size_t length, const Work& work) {
  for_rows(static_cast<int>(pieces(size, length)), [&](int row) {
    const auto piece = static_cast<std::size_t>(row);
    work(piece, piece * length, std::min(size, (piece + 1) * length));
  });
}
template <class Work>
void for_pieces(std::size_t size, const Work& work) {
  for_pieces(size, piece_length, work);
}

/// Calls work(begin, end) for parts of [0, rows), on all cores where that pays.
template <class Work>
void for_ranges(std::size_t rows, const Work& work) {
  constexpr std::size_t range = 4096;
  if (rows <= 2 * range) {
    work(std::size_t{0}, rows);
    return;
  }
  for_pieces(rows, range,
             [&](std::size_t, std::size_t begin, std::size_t end) { work(begin, end); });
}

/// Whether test(i) holds for every element of a vector of `size`.
template <class Test>
bool for_all(std::size_t size, const Test& test) {
  std::atomic<bool> all{true};
  for_pieces(size, [&](std::size_t, std::size_t begin, std::size_t end) {
    bool here = true;
    for (std::size_t i = begin; i < end; ++i) here = here && test(i);
    if (!here) all = false;
  });
  return all;
}

}  // namespace kappamu
