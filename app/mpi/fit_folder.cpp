#include "app/mpi/fit_folder.h"

#include <cmath>
#include <utility>

#include "forward/distributed/together.h"
#include "inverse/problem/problem.h"
#include "io/atomic_file.h"
#include "pipeline/fit_files.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using inverse::CoefficientPair;

/// Voxels beyond which a coarser volume is left beside, for programs of one machine.
constexpr std::size_t most_for_one_machine = std::size_t{1} << 24;

}  // namespace

void FitFolder::write_volume(const fs::path& file, const std::vector<double>& logs) const {
  std::vector<float> values;
  values.reserve(logs.size());
  for (const double x : logs) values.push_back(static_cast<float>(std::exp(x)));
  write_part(pieces_.comm(), file, volume_part(header_.grid, pieces_.owned()),
             std::span<const float>(values));
}

void FitFolder::keep(const std::string& channel, const inverse::distributed::PieceFit& found) {
  write_volume(folder_ / ("kappa_" + channel + ".npy"), found.own.log_kappa);
  write_volume(folder_ / ("mu_" + channel + ".npy"), found.own.log_mu);
  names_.push_back(channel);
  if (header_.grid.cells() > most_for_one_machine) keep_coarse(found.own);
}

void FitFolder::keep_validated(const std::string& channel, const CoefficientPair& own) const {
  const fs::path folder = folder_ / pipeline::validated_folder;
  forward::distributed::on_first(pieces_.comm(), [&] { fs::create_directories(folder); });
  write_volume(folder / ("kappa_" + channel + ".npy"), own.log_kappa);
  write_volume(folder / ("mu_" + channel + ".npy"), own.log_mu);
}

void FitFolder::keep_prediction(const std::string& file, const SurfaceMeasurements& of,
                                const std::vector<double>& exitance) const {
  const double per_value = inverse::exitance_per_value(of, pieces_.whole());
  const FaceShape face = face_shape(pieces_.piece().shape, of.seen_face);
  std::vector<float> own;
  for (std::size_t i = 0; i < exitance.size(); ++i) {
    const int k = static_cast<int>(i % face.cells());
    if (!pieces_.owns_pixel(of.seen_face, k % face.nu, k / face.nu)) continue;
    own.push_back(static_cast<float>(exitance[i] / per_value));
  }
  write_part(pieces_.comm(), folder_ / file,
             within(face_part(header_.grid, of.seen_face, of.patterns, pieces_.owned(), true),
                    names_.size(), channels_),
             std::span<const float>(own));
}

void FitFolder::keep_coarse(const CoefficientPair& own) {
  int factor = 2;
  while (header_.grid.cells() / (static_cast<std::size_t>(factor) * factor * factor) >
         most_for_one_machine / 8) {
    factor *= 2;
  }
  const GridShape& whole = header_.grid;
  const auto coarse = [&](int n) { return (n + factor - 1) / factor; };
  const GridShape shape{coarse(whole.nx), coarse(whole.ny), coarse(whole.nz),
                        factor * whole.voxel_mm};
  std::vector<double> kappa(shape.cells(), 0.0), mu = kappa, count = kappa;
  const auto& box = pieces_.owned();
  std::size_t k = 0;
  for (int z = box.begin[2]; z < box.end[2]; ++z) {
    for (int y = box.begin[1]; y < box.end[1]; ++y) {
      for (int x = box.begin[0]; x < box.end[0]; ++x, ++k) {
        const std::size_t to = shape.index(x / factor, y / factor, z / factor);
        kappa[to] += std::exp(own.log_kappa[k]);
        mu[to] += std::exp(own.log_mu[k]);
        count[to] += 1.0;
      }
    }
  }
  for (std::vector<double>* sums : {&kappa, &mu, &count}) pieces_.sum(*sums);
  for (std::size_t i = 0; i < count.size(); ++i) {
    kappa[i] /= count[i];
    mu[i] /= count[i];
  }
  coarse_.push_back({{shape, std::move(kappa)}, {shape, std::move(mu)}});
}

/// What volume.json says of the volumes, which are not here.
io::VolumeSet FitFolder::described(const GridShape& shape, const std::string& device) const {
  io::VolumeSet set;
  set.channels = names_;
  for (std::size_t c = 0; c < names_.size(); ++c) {
    set.media.push_back({Volume<double>(shape, std::vector<double>()),
                         Volume<double>(shape, std::vector<double>())});
  }
  set.eta = header_.eta;
  set.metadata = {{"program", "kappamu-mpi fit"}, {"device", device}};
  return set;
}

void FitFolder::write_words(const std::string& device) const {
  forward::distributed::on_first(pieces_.comm(), [&] {
    if (!coarse_.empty()) {
      io::VolumeSet coarse = described(coarse_.front().kappa.shape(), device);
      coarse.media = coarse_;
      io::write_volume_folder(folder_ / "coarse", coarse);
    }
    io::write_text_atomically(folder_ / "volume.json",
                              io::volume_json(described(header_.grid, device)));
  });
}

}  // namespace kappamu::app::mpi
