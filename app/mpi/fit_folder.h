// The run folder of a fit by pieces: every rank writes its part of each array, the first one the
// words.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/mpi/npy_parts.h"
#include "core/surface_measurements.h"
#include "inverse/distributed/distributed_fit.h"
#include "io/volume/volume_file.h"

namespace kappamu::app::mpi {

/// Every call is collective.
class FitFolder {
 public:
  /// `header`: the measurements without their arrays; so many `channels` are fitted.
  FitFolder(const SurfaceMeasurements& header, const forward::distributed::BlockPieces& pieces,
            std::filesystem::path folder, std::size_t channels)
      : header_(header), pieces_(pieces), folder_(std::move(folder)), channels_(channels) {}

  /// κ and μ of the next channel, and beside volumes too large for programs of one machine their
  /// means over 2^n voxels along each axis.
  void keep(const std::string& channel, const inverse::distributed::PieceFit& found);
  /// As `found` was before it saw every pattern.
  void keep_validated(const std::string& channel, const inverse::CoefficientPair& own) const;
  /// Exitance [M][v][u] on the piece's seen face of the channel that keep() comes to next, in the
  /// unit of the measurements `of`.
  void keep_prediction(const std::string& file, const SurfaceMeasurements& of,
                       const std::vector<double>& exitance) const;
  /// volume.json and the coarse volume.
  void write_words(const std::string& device) const;

 private:
  void write_volume(const std::filesystem::path& file, const std::vector<double>& logs) const;
  void keep_coarse(const inverse::CoefficientPair& own);
  io::VolumeSet described(const GridShape& shape, const std::string& device) const;

  const SurfaceMeasurements& header_;
  const forward::distributed::BlockPieces& pieces_;
  std::filesystem::path folder_;
  std::size_t channels_;
  std::vector<std::string> names_;
  std::vector<Medium> coarse_;
};

}  // namespace kappamu::app::mpi
