#include "render/material/baked_field.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "core/process_memory.h"
#include "core/shown_text.h"
#include "render/material/surface_places.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

GridShape voxels_over(const Eigen::AlignedBox3d& box, double detail,
                      std::vector<std::string>& warnings) {
  const double coarsest = std::cbrt(box.volume() / most_baked_voxels);
  constexpr double usual = 1.0 / 64.0;  // of the object, where the material has no detail
  double h = std::min(detail, usual * box.sizes().maxCoeff());
  if (h < coarsest) {
    h = coarsest;
    warnings.push_back("its material's details of " + shown_number(detail, "%.2g") +
                       " mm are finer than its voxels of " + shown_number(h, "%.2g") +
                       " mm, of which it has 4 million at most; make size_mm smaller or the "
                       "details larger");
  }
  const Eigen::Array3i n = (box.sizes() / h).array().ceil().cast<int>().max(1);
  GridShape shape{n[0], n[1], n[2], h};
  const double bytes = bytes_per_baked_voxel * static_cast<double>(shape.cells());
  if (bytes > usable_memory()) {
    throw InputError("its material's voxels need " + gigabytes(bytes) +
                     " of memory where this machine has " + gigabytes(main_memory()) +
                     "; make the details larger");
  }
  return shape;
}

bool all_equal(const io::VolumeSet& set) {
  return std::all_of(set.media.begin(), set.media.end(), [&](const Medium& medium) {
    return medium.kappa.values() == set.media[0].kappa.values() &&
           medium.mu.values() == set.media[0].mu.values();
  });
}

}  // namespace

Baked baked(const MaterialField& field, const TriangleMesh& mesh,
            std::vector<std::string>& warnings) {
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const GridShape shape = voxels_over(box, field.detail_mm(), warnings);
  const SurfacePlaces places(mesh);
  Baked result{{}, box.min()};
  result.set.channels = {"R", "G", "B"};
  result.set.media.assign(3, {Volume<double>(shape), Volume<double>(shape)});
  // Voxels that the body does not reach are never looked up, but have to be coefficients.
  double outside = 0.0;
  const ColourCoefficients beyond = field.at(
      places.at(mesh.vertices[static_cast<std::size_t>(mesh.triangles[0][0])], 0, outside));
  const double h = shape.voxel_mm, deepest = field.deepest_mm();
  for_rows(shape.nz * shape.ny, [&](int row) {
    const int y = row % shape.ny, z = row / shape.ny;
    Place place;
    double away = 0.0;
    // The distance to the surface changes by no more than the way: voxels ahead that need not know
    // it are not asked where the surface is.
    int alike = 0;
    for (int x = 0; x < shape.nx; ++x) {
      const Vector3d point = box.min() + h * Vector3d(x + 0.5, y + 0.5, z + 0.5);
      if (alike > 0) {
        --alike;
        place.point = point;
      } else {
        place = places.at(point, place.triangle, away);
        const double spare = away > 0.0 ? away - 2.0 * h : place.depth - deepest;
        if (spare > 0.0) alike = static_cast<int>(std::min(spare / h, 1.0 * shape.nx));
      }
      const ColourCoefficients here = away < 2.0 * h ? field.at(place) : beyond;
      const std::size_t i = shape.index(x, y, z);
      for (std::size_t c = 0; c < here.size(); ++c) {
        result.set.media[c].kappa[i] = here[c].kappa;
        result.set.media[c].mu[i] = here[c].mu;
      }
    }
  });
  if (all_equal(result.set)) {
    result.set.media.resize(1);
    result.set.channels = {"grey"};
  }
  return result;
}

}  // namespace kappamu::render
