#include "app/mpi/measurement_parts.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "app/mpi/npy_parts.h"
#include "core/error.h"
#include "core/numbers/coefficient_bounds.h"
#include "forward/distributed/together.h"
#include "io/measurements_file.h"
#include "pipeline/verify.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using namespace forward::distributed;

const MPI_Comm world = MPI_COMM_WORLD;

}  // namespace

MeasurementParts::MeasurementParts(fs::path folder) : folder_(std::move(folder)) {
  on_first(world, [&] { pipeline::require_as_written(folder_); });
  together(world, [&] {
    header_ = io::read_measurements_header(folder_);
    if (header_.two_faces()) {
      throw InputError((folder_ / "measurements.json").string() +
                       ": seen_faces lists two faces, and kappamu-mpi fits one; use kappamu fit");
    }
  });
  require_usual_voxel(header_.grid.voxel_mm, folder_.string());
  masked_ = fs::exists(folder_ / "mask.npy");
  const auto shape = npy_shape(world, folder_ / "irradiance.npy");
  if (shape.size() != 3 || shape.front() == 0) {
    throw InputError((folder_ / "irradiance.npy").string() +
                     ": must be an array [patterns][v][u] of the lit face");
  }
  header_.patterns = static_cast<int>(shape.front());
}

SurfaceMeasurements MeasurementParts::channel(const BlockPieces& pieces,
                                              std::size_t channel) const {
  const auto read = [&](const char* name, Face face, bool by_channel) {
    Part part = face_part(header_.grid, face, header_.patterns, pieces.held());
    if (by_channel) part = within(std::move(part), channel, header_.channels.size());
    const std::vector<double> values = read_part(world, folder_ / name, part);
    return std::vector<float>(values.begin(), values.end());
  };
  SurfaceMeasurements piece = header_;
  piece.grid = pieces.piece().shape;
  piece.channels = {header_.channels[channel]};
  piece.irradiance = read("irradiance.npy", header_.lit_face, false);
  piece.value = read("value.npy", header_.seen_face, true);
  piece.variance = read("variance.npy", header_.seen_face, true);
  if (masked_) {
    for (const float use : read("mask.npy", header_.seen_face, true)) {
      piece.mask.push_back(use != 0.0F ? 1 : 0);
    }
  }
  require_usable(piece);
  return piece;
}

/// As validate() of whole measurements, each rank its part.
void MeasurementParts::require_usable(const SurfaceMeasurements& piece) const {
  float brightest = 0.0F;
  together(world, [&] {
    const auto fail = [&](const std::string& what) {
      throw InputError(folder_.string() + ": " + what);
    };
    for (const float e : piece.irradiance) {
      if (!std::isfinite(e) || e < 0.0F) fail("irradiance has a negative or non-finite value");
      brightest = std::max(brightest, e);
    }
    for (std::size_t i = 0; i < piece.value.size(); ++i) {
      if (!piece.mask.empty() && piece.mask[i] == 0) continue;
      if (!std::isfinite(piece.value[i])) {
        fail("value has a non-finite entry that mask does not exclude");
      }
      if (!std::isfinite(piece.variance[i]) || piece.variance[i] <= 0.0F) {
        fail("variance must be positive and finite wherever mask allows use");
      }
    }
  });
  brightest = static_cast<float>(largest(world, brightest));
  if (brightest == 0.0F) {
    throw InputError(folder_.string() +
                     ": irradiance is zero everywhere; at least one pattern must light the sample");
  }
  require_usual_light(brightest, folder_.string());
}

}  // namespace kappamu::app::mpi
