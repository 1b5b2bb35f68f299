// The data of one channel as the fit sees them on one grid: exitance, weights, light. Made from
// SurfaceMeasurements, then restricted level by level.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/grid.h"
#include "core/surface_measurements.h"
#include "forward/block_setup.h"
#include "inverse/problem/fields.h"
#include "inverse/problem/smooth_error.h"
#include "inverse/problem/views.h"

namespace kappamu::inverse {

/// Standard deviation added in quadrature to the measured one, for what the model cannot reproduce:
/// σ² = variance + (relative |d|)² + (of_maximum · max d of the pattern)².
struct ModelError {
  double relative = 0.0;    ///< of each datum [dimensionless]
  double of_maximum = 0.0;  ///< of the largest datum of its pattern [dimensionless]
};

struct Problem {
  forward::GridSetup setup;
  Face seen_face = Face::z_plus;
  std::vector<Face> seen_faces{};  ///< as those of SurfaceMeasurements
  int patterns = 0;                ///< M
  Cameras cameras{};               ///< as those of SurfaceMeasurements, under collimated light
  /// [M] 1: lit pixels are used, and LitFace (lit_face.h) describes this picture; empty: none.
  std::vector<std::uint8_t> lateral{};
  std::vector<double> irradiance;  ///< [M][v][u] on the lit face, before Fresnel
  std::vector<double> data;        ///< [M][v][u] exitance on the seen face
  std::vector<double> weight;      ///< [M][v][u] 1/σ², 0 where masked
  /// Share of 1/weight that is the noise of a correction r (objective.h), which neighbours have in
  /// common [M][v][u]; empty: none.
  std::vector<double> correction_variance{};
  SmoothError smooth_error{};
  /// Precision of √weight times residuals, made of smooth_error; none: they are independent.
  std::optional<SmoothErrorPrecision> precision{};

  FaceShape lit_shape() const { return face_shape(setup.shape, setup.lit_face); }
  FaceShape seen_shape() const { return face_shape(setup.shape, seen_face); }
  Views views() const { return {irradiance, patterns, seen_face, seen_faces}; }
  /// Numbers of the pictures of each face that is seen.
  std::vector<std::vector<int>> pictures_by_face() const;
  MediumSpace space() const { return forward::block_space(setup.shape, setup.lit_face); }
  std::size_t used() const;  ///< data with weight > 0
};

/// Exitance per unit of the measured quantity [dimensionless or sr].
double exitance_per_value(const SurfaceMeasurements& measurements, const forward::GridSetup& setup);

/// The cameras that transport predicts the radiance towards: none under diffuse light, whose part
/// that has not scattered follows no P1 law, nor of other quantities than exitance.
Cameras cameras_of(const SurfaceMeasurements& measurements);

/// The setup `measurements` ask for: collimated light enters by first collisions, diffuse light
/// through the boundary; under [W]'s convention all of it does.
forward::GridSetup make_setup(const SurfaceMeasurements& measurements,
                              forward::Convention convention);

/// Channel `channel` of `measurements`, which must have passed validate().
Problem make_problem(const SurfaceMeasurements& measurements, int channel,
                     forward::Convention convention, const ModelError& model_error);

/// Gives every datum used the same weight, 1/mean σ²: [W] (6) knows no variances.
void equalise_weights(Problem& problem);

/// The same on voxels of twice the edge. Odd extents are rounded up: the last coarse voxels
/// overhang the block, which the correction of Objective absorbs. Irradiance keeps its power; a
/// coarse datum exists where all fine data it covers inside the block do. `model_error` is that of
/// the coarse grid.
Problem coarsen(const Problem& fine, const ModelError& model_error);

/// Means over face pixels of a `factor` times finer image [M][v][u], where the fine face may be
/// smaller than factor × the coarse one (overhang): means over what exists.
std::vector<double> restrict_face(const std::vector<double>& fine, FaceShape fine_shape,
                                  FaceShape coarse_shape, int factor, int patterns);

/// Splits every pixel of `coarse` [M][v][u] into factor² equal ones, cut to `fine_shape`.
std::vector<double> split_face(const std::vector<double>& coarse, FaceShape coarse_shape,
                               FaceShape fine_shape, int factor, int patterns);

/// Cell-centred trilinear interpolation of `coarse` to voxels of half the edge, cut to
/// `fine_shape`; constant beyond the outermost centres.
std::vector<double> prolong(const std::vector<double>& coarse, const GridShape& coarse_shape,
                            const GridShape& fine_shape);

/// Means over the voxels that each of `coarse`, 2^n times as large, covers.
std::vector<double> restrict_voxels(const std::vector<double>& values, const GridShape& fine,
                                    const GridShape& coarse);

CoefficientPair restrict_voxels(const CoefficientPair& fields, const GridShape& fine,
                                const GridShape& coarse);

/// Splits every voxel of `coarse` into factor³ equal ones, cut to `fine_shape`.
std::vector<double> split_voxels(const std::vector<double>& coarse, const GridShape& coarse_shape,
                                 const GridShape& fine_shape, int factor);

}  // namespace kappamu::inverse
