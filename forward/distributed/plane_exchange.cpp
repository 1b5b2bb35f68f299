#include "forward/distributed/plane_exchange.h"

#include <numeric>
#include <utility>

#include "core/error.h"

namespace kappamu::forward::distributed {

namespace {

int size_of(MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

int rank_in(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

std::vector<int> starts(const std::vector<int>& counts) {
  std::vector<int> first(counts.size(), 0);
  std::partial_sum(counts.begin(), counts.end() - 1, first.begin() + 1);
  return first;
}

std::vector<Rectangle> of_all(MPI_Comm comm, const Rectangle& own) {
  std::vector<Rectangle> all(static_cast<std::size_t>(size_of(comm)));
  static_assert(sizeof(Rectangle) == 4 * sizeof(int));
  MPI_Allgather(&own, 4, MPI_INT, all.data(), 4, MPI_INT, comm);
  return all;
}

/// Every map's own rectangle goes to the rank that has the map.
Exchange gathering(MPI_Comm comm, const std::vector<Rectangle>& rectangles, int maps) {
  const int ranks = size_of(comm), rank = rank_in(comm);
  const auto share = [&](int r) {
    const auto [first, end] = share_of(maps, r, ranks);
    return end - first;
  };
  const auto pixels = [&](int r) {
    return static_cast<int>(rectangles[static_cast<std::size_t>(r)].pixels());
  };
  std::vector<int> sent, received;
  for (int r = 0; r < ranks; ++r) {
    sent.push_back(share(r) * pixels(rank));
    received.push_back(share(rank) * pixels(r));
  }
  return {comm, std::move(sent), std::move(received)};
}

}  // namespace

Exchange::Exchange(MPI_Comm comm, std::vector<int> sent, std::vector<int> received)
    : comm_(comm), sent_(std::move(sent)), received_(std::move(received)) {}

std::vector<double> Exchange::operator()(std::span<const double> to) const {
  const std::vector<int> to_start = starts(sent_), from_start = starts(received_);
  check(to.size() == static_cast<std::size_t>(to_start.back() + sent_.back()),
        "exchange: wrong number of values");
  std::vector<double> from(static_cast<std::size_t>(from_start.back() + received_.back()));
  MPI_Alltoallv(to.data(), sent_.data(), to_start.data(), MPI_DOUBLE, from.data(), received_.data(),
                from_start.data(), MPI_DOUBLE, comm_);
  return from;
}

std::array<int, 2> share_of(int count, int rank, int ranks) {
  const auto begin = [&](long r) { return static_cast<int>(r * count / ranks); };
  return {begin(rank), begin(rank + 1L)};
}

PlaneExchange::PlaneExchange(MPI_Comm comm, const Rectangle& own, int na, int nb, int maps)
    : na_(na),
      nb_(nb),
      mine_(share_of(maps, rank_in(comm), size_of(comm))),
      rectangles_(of_all(comm, own)),
      to_whole_(gathering(comm, rectangles_, maps)) {}

template <class F>
void PlaneExchange::for_packed(F f) const {
  std::size_t packed = 0;
  for (const Rectangle& r : rectangles_) {
    for (int map = 0; map < count(); ++map) {
      for (int b = r.begin[1]; b < r.end[1]; ++b) {
        for (int a = r.begin[0]; a < r.end[0]; ++a) {
          f(packed++, (static_cast<std::size_t>(map) * nb_ + b) * na_ + a);
        }
      }
    }
  }
}

std::vector<double> PlaneExchange::whole(std::span<const double> parts) const {
  const std::vector<double> packed = to_whole_(parts);
  std::vector<double> maps(static_cast<std::size_t>(count()) * nb_ * na_);
  for_packed([&](std::size_t from, std::size_t to) { maps[to] = packed[from]; });
  return maps;
}

std::vector<double> PlaneExchange::parts(std::span<const double> whole) const {
  std::vector<double> packed(whole.size());
  for_packed([&](std::size_t to, std::size_t from) { packed[to] = whole[from]; });
  return to_whole_.reversed()(packed);
}

}  // namespace kappamu::forward::distributed
