// Truths of four families for claims about fits in general: each figure is drawn by its seed alone
// and is the same on every grid. Seeds that settings were chosen on and seeds that are reported are
// apart (studies/inverse/ablations.h).
#pragma once

#include <cstdint>

#include "core/grid.h"
#include "core/names.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::test_cases {

enum class Family {
  boxes,    ///< smooth fields of contrast 4 with two boxes (make_truth)
  layers,   ///< two to four even layers across the light, two balls of other κ and μ in them
  veins,    ///< three bent sheets of half a voxel to two, of low κ and high μ, in smooth fields
  figures,  ///< sharp bars, discs and rings through an even block
};
inline constexpr Names<Family, 4> family_names{{{"boxes", Family::boxes},
                                                {"layers", Family::layers},
                                                {"veins", Family::veins},
                                                {"figures", Family::figures}}};

/// On the cell centres of `shape`, whose z is the depth; `voxel_mm` is what veins are measured in,
/// that of the grid to be fitted.
inverse::CoefficientPair make_family(const GridShape& shape, Family family, double voxel_mm,
                                     std::uint64_t seed);

}  // namespace kappamu::test_cases
