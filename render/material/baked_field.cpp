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

/// Puts a field into voxels.
class Baker {
 public:
  /// Voxels further outside than this many edges are never looked up, but have to be coefficients.
  static constexpr double looked_up = 2.0;

  Baker(const MaterialField& field, const TriangleMesh& mesh, const GridShape& shape,
        const Vector3d& corner, io::VolumeSet& set)
      : field_(field),
        places_(mesh),
        shape_(shape),
        corner_(corner),
        beyond_away_(looked_up * shape.voxel_mm),
        set_(set) {
    double outside = 0.0;
    beyond_ = field.at(
        places_.at(mesh.vertices[static_cast<std::size_t>(mesh.triangles[0][0])], 0, outside));
  }

  void bake() {
    constexpr int edge = 16;
    const Eigen::Array3i size(shape_.nx, shape_.ny, shape_.nz);
    const Eigen::Array3i bricks = (size + (edge - 1)) / edge;
    for_rows(bricks.prod(), [&](int brick) {
      const Eigen::Array3i first =
          edge * Eigen::Array3i(brick % bricks[0], brick / bricks[0] % bricks[1],
                                brick / (bricks[0] * bricks[1]));
      fill(first, (first + edge).min(size), 0);
    });
  }

 private:
  Vector3d middle_of(const Eigen::Array3i& voxel) const {
    return corner_ + shape_.voxel_mm * (voxel.cast<double>() + 0.5).matrix();
  }

  /// Voxels from `first` to before `last`; `near`: a triangle that may be close. The distance to
  /// the surface changes by no more than the way: of voxels that need not know it, one alone is
  /// asked for it.
  void fill(const Eigen::Array3i& first, const Eigen::Array3i& last, int near) {
    const Vector3d low = middle_of(first), high = middle_of(last - 1);
    const double reach = 0.5 * (high - low).norm();
    double away = 0.0;
    Place place = places_.at(0.5 * (low + high), near, away);
    const bool outside = away - reach >= beyond_away_;
    const double shallow = std::max(0.0, -away - reach), deep = std::max(0.0, -away + reach);
    if (outside || reach == 0.0 || field_.of_point_alone(shallow, deep)) {
      for (int z = first[2]; z < last[2]; ++z) {
        for (int y = first[1]; y < last[1]; ++y) {
          for (int x = first[0]; x < last[0]; ++x) {
            place.point = middle_of({x, y, z});
            set(shape_.index(x, y, z), outside ? beyond_ : field_.at(place));
          }
        }
      }
      return;
    }
    const Eigen::Array3i half = (first + last) / 2;
    for (int part = 0; part < 8; ++part) {
      Eigen::Array3i from = first, to = half;
      for (int axis = 0; axis < 3; ++axis) {
        if ((part >> axis & 1) == 0) continue;
        from[axis] = half[axis];
        to[axis] = last[axis];
      }
      if ((from < to).all()) fill(from, to, place.triangle);
    }
  }

  void set(std::size_t voxel, const ColourCoefficients& here) {
    for (std::size_t c = 0; c < here.size(); ++c) {
      set_.media[c].kappa[voxel] = here[c].kappa;
      set_.media[c].mu[voxel] = here[c].mu;
    }
  }

  const MaterialField& field_;
  SurfacePlaces places_;
  GridShape shape_;
  Vector3d corner_;
  double beyond_away_;
  ColourCoefficients beyond_;
  io::VolumeSet& set_;
};

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
  Baked result{{}, box.min()};
  result.set.channels = {"R", "G", "B"};
  result.set.media.resize(3);
  for_rows(6, [&](int k) {
    Medium& medium = result.set.media[static_cast<std::size_t>(k / 2)];
    (k % 2 == 0 ? medium.kappa : medium.mu) = Volume<double>(shape);
  });
  Baker(field, mesh, shape, box.min(), result.set).bake();
  if (all_equal(result.set)) {
    result.set.media.resize(1);
    result.set.channels = {"grey"};
  }
  return result;
}

}  // namespace kappamu::render
