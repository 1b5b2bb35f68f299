// Failures of a program whose ranks must end together: what fails on one rank fails on all, with
// the same sentence, and the first rank says it.
#pragma once

#include <mpi.h>

#include <algorithm>
#include <exception>
#include <new>
#include <string>

#include "core/error.h"

namespace kappamu::forward::distributed {

/// Calls work() on every rank; where any of them throws, all throw what the first of those did.
/// work() must not communicate: the others would wait for one that has failed.
template <class Work>
void together(MPI_Comm comm, const Work& work) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::string sentence;
  try {
    work();
  } catch (const std::bad_alloc&) {
    sentence = "out of memory; start more ranks, on more machines";
  } catch (const std::exception& error) {
    sentence = error.what();
    if (sentence.empty()) sentence = "unknown failure";
  }
  int failed = sentence.empty() ? ranks : rank;
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MIN, comm);
  if (failed == ranks) return;
  int length = static_cast<int>(sentence.size());
  MPI_Bcast(&length, 1, MPI_INT, failed, comm);
  sentence.resize(static_cast<std::size_t>(length));
  MPI_Bcast(sentence.data(), length, MPI_CHAR, failed, comm);
  throw InputError(sentence);
}

/// The first rank does it; all fail where it fails.
template <class Work>
void on_first(MPI_Comm comm, const Work& work) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  together(comm, [&] {
    if (rank == 0) work();
  });
}

/// Of the first rank, on all.
std::string shared(MPI_Comm comm, std::string text);

/// Of all ranks' values.
double largest(MPI_Comm comm, double value);

}  // namespace kappamu::forward::distributed
