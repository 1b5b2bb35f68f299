// What the solver is held to at its edges, in one place: tighten a number here when it has become
// better, never loosen one without a word in docs/limits.md.
#pragma once

#include <ostream>
#include <string>

#include "tests/cases/media.h"

namespace kappamu::bounds {

/// True relative error of φ where a residual of 1e-6 was asked for in single precision: storage
/// rounds at 6e-8, the rest is the tolerance.
inline constexpr double single_error = 1e-6;
/// Where the residual bounds the error worst: log κ rough from voxel to voxel at contrast 10⁶.
inline constexpr double rough_single_error = 3e-6;
/// Iterations in single precision where next to nothing leaves or is absorbed beside what κ moves
/// (mirrors, no absorption, up to 2048 voxels deep).
inline constexpr int weak_sink_iterations = 16;
/// True relative error of φ there at tolerance 1e-6, in either precision: 2048 voxels between the
/// open faces make a residual of 1e-6 say less.
inline constexpr double weak_sink_error = 3e-6;
/// Of layers one voxel thick at contrast 10⁶, in single precision, on any grid.
inline constexpr int layers_iterations = 12;
/// What is left at float's floor, and double's.
inline constexpr double single_floor = 3e-7;
inline constexpr double double_floor = 1e-13;
/// Of the power that enters, after a solve to 1e-6.
inline constexpr double imbalance = 1e-5;
/// Iterations at twice the edge over those at once, both contrast 10⁴.
inline constexpr double growth = 1.2;

/// Iterations to 1e-6 in single precision, 32×32×20 voxels.
struct Iterations {
  const char* name;
  test_cases::MediumSpec medium;
  int most;
};
inline void PrintTo(const Iterations& bound, std::ostream* out) {
  *out << bound.name;
}

using test_cases::MediumKind;
inline const Iterations iterations[] = {
    {"Even", {}, 12},
    {"Smooth1e1", {.kind = MediumKind::smooth, .contrast = 1e1}, 12},
    {"Smooth1e4", {.kind = MediumKind::smooth, .contrast = 1e4}, 20},
    {"Smooth1e6", {.kind = MediumKind::smooth, .contrast = 1e6}, 30},
    {"Balls1e1", {.kind = MediumKind::inclusions, .contrast = 1e1}, 12},
    {"Balls1e4", {.kind = MediumKind::inclusions, .contrast = 1e4}, 20},
    {"Balls1e6", {.kind = MediumKind::inclusions, .contrast = 1e6}, 30},
    {"Checkerboard1e1", {.kind = MediumKind::checkerboard, .contrast = 1e1}, 12},
    {"Checkerboard1e4", {.kind = MediumKind::checkerboard, .contrast = 1e4}, 20},
    {"Checkerboard1e6", {.kind = MediumKind::checkerboard, .contrast = 1e6}, 30},
    {"CubesOf3In1e1", {.kind = MediumKind::checkerboard, .contrast = 1e1, .period = 3}, 12},
    {"CubesOf3In1e4", {.kind = MediumKind::checkerboard, .contrast = 1e4, .period = 3}, 20},
    {"CubesOf3In1e6", {.kind = MediumKind::checkerboard, .contrast = 1e6, .period = 3}, 30},
    {"LayersAcross1e1", {.kind = MediumKind::layers, .contrast = 1e1}, 12},
    {"LayersAcross1e4", {.kind = MediumKind::layers, .contrast = 1e4}, 20},
    {"LayersAcross1e6", {.kind = MediumKind::layers, .contrast = 1e6}, 30},
    {"LayersAlong1e1", {.kind = MediumKind::layers, .contrast = 1e1, .axis = 0}, 12},
    {"LayersAlong1e4", {.kind = MediumKind::layers, .contrast = 1e4, .axis = 0}, 20},
    {"LayersAlong1e6", {.kind = MediumKind::layers, .contrast = 1e6, .axis = 0}, 30},
    {"Random1e1", {.kind = MediumKind::random, .contrast = 1e1}, 12},
    {"Random1e4", {.kind = MediumKind::random, .contrast = 1e4}, 20},
    {"Random1e6", {.kind = MediumKind::random, .contrast = 1e6}, 60},
    {"RandomCubesOf3In1e4", {.kind = MediumKind::random, .contrast = 1e4, .period = 3}, 20},
    {"RandomCubesOf3In1e6", {.kind = MediumKind::random, .contrast = 1e6, .period = 3}, 30},
};

}  // namespace kappamu::bounds
