#include "inverse/distributed/piece_waves.h"

#include <algorithm>
#include <array>
#include <utility>

#include "inverse/optimise/lateral_hessian.h"

namespace kappamu::inverse::distributed {

namespace {

using forward::distributed::Exchange;
using forward::distributed::Rectangle;
using forward::distributed::share_of;

MediumSpace space_of(const BlockPieces& pieces) {
  return forward::block_space(pieces.whole().shape, pieces.whole().lit_face);
}

Rectangle across(const BlockPieces& pieces, int a, int b) {
  const auto& box = pieces.owned();
  return {{box.begin[a], box.begin[b]}, {box.end[a], box.end[b]}};
}

}  // namespace

PieceWaves::PieceWaves(const BlockPieces& pieces)
    : comm_(pieces.comm()),
      rank_(static_cast<std::size_t>(pieces.rank())),
      ranks_(pieces.ranks()),
      owned_(pieces.owned()),
      modes_(space_of(pieces)),
      depth_axis_(space_of(pieces).depth_axis),
      axis_a_(depth_axis_ == 0 ? 1 : 0),
      axis_b_(depth_axis_ == 2 ? 1 : 2),
      na_(pieces.whole().shape.extent(axis_a_)),
      nb_(pieces.whole().shape.extent(axis_b_)),
      cosines_a_(na_),
      cosines_b_(nb_),
      planes_(comm_, across(pieces, axis_a_, axis_b_), na_, nb_, modes_.rows()) {
  // Bins in turn, about as many waves a rank.
  first_bin_.push_back(0);
  first_wave_.push_back(0);
  for (int bin = 0; bin < modes_.bins(); ++bin) {
    const auto so_far = static_cast<long>(order_.size());
    while (so_far * ranks_ >= static_cast<long>(first_bin_.size()) * modes_.waves()) {
      first_bin_.push_back(bin);
      first_wave_.push_back(static_cast<int>(so_far));
    }
    const std::vector<int>& members = modes_.members(bin);
    order_.insert(order_.end(), members.begin(), members.end());
  }
  first_bin_.resize(static_cast<std::size_t>(ranks_) + 1, modes_.bins());
  first_wave_.resize(first_bin_.size(), modes_.waves());
  int wave = 0;
  for (int bin = first_bin_[rank_]; bin < first_bin_[rank_ + 1]; ++bin) {
    std::vector<int>& columns = members_.emplace_back(modes_.members(bin).size());
    for (int& column : columns) column = wave++;
  }
}

template <class F>
void PieceWaves::for_parts(F f) const {
  const auto ea = static_cast<std::size_t>(owned_.extent(axis_a_));
  const auto eb = static_cast<std::size_t>(owned_.extent(axis_b_));
  std::size_t own = 0;
  std::array<std::size_t, 3> at{};
  for (at[2] = 0; at[2] < static_cast<std::size_t>(owned_.extent(2)); ++at[2]) {
    for (at[1] = 0; at[1] < static_cast<std::size_t>(owned_.extent(1)); ++at[1]) {
      for (at[0] = 0; at[0] < static_cast<std::size_t>(owned_.extent(0)); ++at[0]) {
        f(own++, (at[depth_axis_] * eb + at[axis_b_]) * ea + at[axis_a_]);
      }
    }
  }
}

Eigen::MatrixXd PieceWaves::analyse(const CoefficientPair& own) const {
  const std::size_t cells = owned_.cells();
  std::vector<double> parts(2 * cells);
  for_parts([&](std::size_t i, std::size_t k) {
    parts[k] = own.log_kappa[i];
    parts[cells + k] = own.log_mu[i];
  });
  std::vector<double> planes = planes_.whole(parts);
  const Eigen::Index all = modes_.waves(), here = planes_.count();
  for (Eigen::Index p = 0; p < here; ++p) {
    to_waves(cosines_a_, cosines_b_, planes.data() + p * all);
  }
  std::vector<int> sent, received;
  std::vector<double> packed;
  packed.reserve(planes.size());
  for (int r = 0; r < ranks_; ++r) {
    const auto [first, end] = share_of(rows(), r, ranks_);
    const int theirs = first_wave_[r + 1] - first_wave_[r];
    sent.push_back(theirs * static_cast<int>(here));
    received.push_back(waves() * (end - first));
    for (int w = first_wave_[r]; w < first_wave_[r + 1]; ++w) {
      for (Eigen::Index p = 0; p < here; ++p) packed.push_back(planes[p * all + order_[w]]);
    }
  }
  const std::vector<double> from = Exchange(comm_, sent, received)(packed);
  Eigen::MatrixXd coefficients(rows(), waves());
  std::size_t next = 0;
  for (int r = 0; r < ranks_; ++r) {
    const auto [first, end] = share_of(rows(), r, ranks_);
    for (int w = 0; w < waves(); ++w) {
      for (int row = first; row < end; ++row) coefficients(row, w) = from[next++];
    }
  }
  return coefficients;
}

CoefficientPair PieceWaves::synthesise(const Eigen::MatrixXd& coefficients) const {
  const Eigen::Index all = modes_.waves(), here = planes_.count();
  std::vector<int> sent, received;
  std::vector<double> packed;
  packed.reserve(static_cast<std::size_t>(coefficients.size()));
  for (int r = 0; r < ranks_; ++r) {
    const auto [first, end] = share_of(rows(), r, ranks_);
    sent.push_back(waves() * (end - first));
    received.push_back((first_wave_[r + 1] - first_wave_[r]) * static_cast<int>(here));
    for (int w = 0; w < waves(); ++w) {
      for (int row = first; row < end; ++row) packed.push_back(coefficients(row, w));
    }
  }
  const std::vector<double> from = Exchange(comm_, sent, received)(packed);
  std::vector<double> planes(static_cast<std::size_t>(all * here));
  std::size_t next = 0;
  for (const int wave : order_) {
    for (Eigen::Index p = 0; p < here; ++p) planes[p * all + wave] = from[next++];
  }
  for (Eigen::Index p = 0; p < here; ++p) {
    from_waves(cosines_a_, cosines_b_, planes.data() + p * all);
  }
  const std::vector<double> parts = planes_.parts(planes);
  const std::size_t cells = owned_.cells();
  CoefficientPair own{std::vector<double>(cells), std::vector<double>(cells)};
  for_parts([&](std::size_t i, std::size_t k) {
    own.log_kappa[i] = parts[k];
    own.log_mu[i] = parts[cells + k];
  });
  return own;
}

/// The sums of the bins from begin[rank] to end[rank], which other ranks may have; of its own this
/// rank has `sums`.
LateralBlocks PieceWaves::with_neighbours(LateralBlocks sums, std::span<const int> begin,
                                          std::span<const int> end) const {
  const int mine = static_cast<int>(rank_);
  LateralBlocks all(static_cast<std::size_t>(end[rank_] - begin[rank_]));
  std::vector<MPI_Request> requests;
  const int numbers = rows() * rows();
  for (int owner = 0; owner < ranks_; ++owner) {
    for (int bin = first_bin_[owner]; bin < first_bin_[owner + 1]; ++bin) {
      if (owner != mine) {
        if (bin < begin[rank_] || bin >= end[rank_]) continue;
        Eigen::MatrixXd& block = all[static_cast<std::size_t>(bin - begin[rank_])];
        block.resize(rows(), rows());
        MPI_Irecv(block.data(), numbers, MPI_DOUBLE, owner, bin, comm_, &requests.emplace_back());
        continue;
      }
      for (int other = 0; other < ranks_; ++other) {
        if (other == mine || bin < begin[other] || bin >= end[other]) continue;
        MPI_Isend(sums[static_cast<std::size_t>(bin - first_bin_[rank_])].data(), numbers,
                  MPI_DOUBLE, other, bin, comm_, &requests.emplace_back());
      }
    }
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    all[k + static_cast<std::size_t>(first_bin_[rank_] - begin[rank_])] = std::move(sums[k]);
  }
  return all;
}

LateralBlocks PieceWaves::blocks(std::span<const CoefficientPair> rows_of_data) const {
  std::vector<int> samples;
  for (int bin = 0; bin < modes_.bins(); ++bin) {
    samples.push_back(static_cast<int>(rows_of_data.size() * modes_.members(bin).size()));
  }
  // A bin's block is made of its neighbours' sums too.
  std::vector<int> begin(first_bin_.begin(), first_bin_.end() - 1);
  std::vector<int> end(first_bin_.begin() + 1, first_bin_.end());
  for (int r = 0; r < ranks_; ++r) {
    for (int bin = first_bin_[r]; bin < first_bin_[r + 1]; ++bin) {
      const int reach = pooled_reach(samples, bin, rows());
      begin[r] = std::max(0, std::min(begin[r], bin - reach));
      end[r] = std::min(modes_.bins(), std::max(end[r], bin + reach + 1));
    }
  }
  const LateralBlocks sums = with_neighbours(lateral_sums(rows_of_data, *this), begin, end);
  const LateralBlocks blocks =
      pooled_blocks(sums, {samples.begin() + begin[rank_], samples.begin() + end[rank_]});
  const auto own = blocks.begin() + (first_bin_[rank_] - begin[rank_]);
  return {own, own + bins()};
}

}  // namespace kappamu::inverse::distributed
