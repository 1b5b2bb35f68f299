// Maps that are cut between ranks, and the same maps whole, each on one rank: what a transform over
// a plane needs of a block whose columns are spread over the ranks.
#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace kappamu::forward::distributed {

/// Pixels [begin, end) along both axes of a map; none where they do not rise.
struct Rectangle {
  std::array<int, 2> begin{}, end{};

  std::size_t pixels() const {
    const int a = end[0] - begin[0], b = end[1] - begin[1];
    return a > 0 && b > 0 ? static_cast<std::size_t>(a) * static_cast<std::size_t>(b) : 0;
  }
};

/// Numbers for each rank, and from each.
class Exchange {
 public:
  Exchange(MPI_Comm comm, std::vector<int> sent, std::vector<int> received);

  /// Of `to` all ranks in turn, of the result from all ranks in turn. Called by all.
  std::vector<double> operator()(std::span<const double> to) const;
  Exchange reversed() const { return {comm_, received_, sent_}; }

 private:
  MPI_Comm comm_;
  std::vector<int> sent_, received_;
};

/// The `rank`-th of `ranks` nearly equal shares of `count` things: [first, end).
std::array<int, 2> share_of(int count, int rank, int ranks);

/// `maps` maps [b][a] of na × nb pixels, of which this rank has the rectangle `own`; the rectangles
/// of all ranks make the whole.
class PlaneExchange {
 public:
  PlaneExchange(MPI_Comm comm, const Rectangle& own, int na, int nb, int maps);

  int first() const { return mine_[0]; }  ///< of the maps that are whole on this rank
  int count() const { return mine_[1] - mine_[0]; }

  /// [count()][b][a] whole, of `parts` [maps][b][a] of the rectangle. Called by all.
  std::vector<double> whole(std::span<const double> parts) const;
  /// And back.
  std::vector<double> parts(std::span<const double> whole) const;

 private:
  /// f(place in the packed numbers, place in the whole maps), rank by rank.
  template <class F>
  void for_packed(F f) const;

  int na_, nb_;
  std::array<int, 2> mine_;
  std::vector<Rectangle> rectangles_;  ///< of all ranks
  Exchange to_whole_;
};

}  // namespace kappamu::forward::distributed
