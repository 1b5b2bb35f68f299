// Measurements that no rank reads as a whole: each has its piece of every map.
#pragma once

#include <filesystem>

#include "core/surface_measurements.h"
#include "forward/distributed/block_pieces.h"

namespace kappamu::app::mpi {

/// Every call is collective. Throws InputError, on all ranks, of what is not there or not usable.
class MeasurementParts {
 public:
  /// `folder`: one with measurements.json.
  explicit MeasurementParts(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }
  /// The whole, without arrays.
  const SurfaceMeasurements& header() const { return header_; }
  /// One channel of this rank's piece, as if that were the block.
  SurfaceMeasurements channel(const forward::distributed::BlockPieces& pieces,
                              std::size_t channel) const;

 private:
  void require_usable(const SurfaceMeasurements& piece) const;

  std::filesystem::path folder_;
  SurfaceMeasurements header_;
  bool masked_ = false;
};

}  // namespace kappamu::app::mpi
