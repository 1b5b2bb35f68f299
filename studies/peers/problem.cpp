#include "studies/peers/problem.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace kappamu::peers {

namespace {

std::vector<double> read_doubles(const std::filesystem::path& file, std::size_t count) {
  std::ifstream in(file, std::ios::binary);
  std::vector<double> values(count);
  in.read(reinterpret_cast<char*>(values.data()),
          static_cast<std::streamsize>(count * sizeof(double)));
  if (!in) throw std::runtime_error("cannot read " + file.string());
  return values;
}

}  // namespace

Problem::Problem(const std::filesystem::path& folder, int rank, int ranks) {
  std::ifstream text(folder / "problem.txt");
  std::array<int, 3> n{};
  if (!(text >> n[0] >> n[1] >> n[2] >> patterns_)) {
    throw std::runtime_error("cannot read " + (folder / "problem.txt").string());
  }
  const auto cells = static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) *
                     static_cast<std::size_t>(n[2]);
  link_ = {read_doubles(folder / "link_x.bin", cells), read_doubles(folder / "link_y.bin", cells),
           read_doubles(folder / "link_z.bin", cells)};
  diagonal_ = read_doubles(folder / "diagonal.bin", cells);
  rhs_ = read_doubles(folder / "rhs.bin", cells * static_cast<std::size_t>(patterns_));
  extent_ = n;
  stride_ = {1, static_cast<std::size_t>(n[0]),
             static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1])};
  if (n[1] > n[2]) {
    std::swap(extent_[1], extent_[2]);
    std::swap(stride_[1], stride_[2]);
    std::swap(link_[1], link_[2]);
  }
  slab_begin_ = extent_[2] * rank / ranks;
  slab_end_ = extent_[2] * (rank + 1) / ranks;
}

std::array<int, 3> Problem::position(int row) const {
  return {row % extent_[0], row / extent_[0] % extent_[1], row / plane()};
}

std::size_t Problem::index(const std::array<int, 3>& position) const {
  std::size_t result = 0;
  for (std::size_t a = 0; a < 3; ++a) result += stride_[a] * static_cast<std::size_t>(position[a]);
  return result;
}

std::array<double, 4> Problem::upper_row(int local) const {
  const std::array<int, 3> at = position(first_row() + local);
  const std::size_t i = index(at);
  std::array<double, 4> row{diagonal_[i]};
  for (std::size_t a = 0; a < 3; ++a) row[1 + a] = at[a] + 1 < extent_[a] ? -link_[a][i] : 0.0;
  return row;
}

std::vector<double> Problem::local_rhs(int pattern) const {
  const double* b = rhs_.data() + static_cast<std::size_t>(pattern) * diagonal_.size();
  std::vector<double> local(static_cast<std::size_t>(local_rows()));
  for (int i = 0; i < local_rows(); ++i)
    local[static_cast<std::size_t>(i)] = b[cell(first_row() + i)];
  return local;
}

}  // namespace kappamu::peers
