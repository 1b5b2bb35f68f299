// Subsurface parameters of surface shaders, and what κ and μ they stand for. Both describe a medium
// whose boundary reflects nothing: the albedo α that gives a half-space of it the stated colour.
//
//   openpbr     radius = 1/σt, the mean free path; α = (1 − s²)/(1 − g s²),
//               s = 4.09712 + 4.20863 C − √(9.59217 + 41.6808 C + 17.7126 C²)
//               (OpenPBR Surface 1.1, "Subsurface"; C. Kulla, A. Conty, Revisiting physically based
//               shading at Imageworks, 2017; the inverse of van de Hulst's albedo)
//   principled  radius = d of the normalised diffusion profile, σt = 1/(d s(C)),
//               s = 1.9 − C + 3.5 (C − 0.8)², α = 1 − exp(−5.09406 C + 2.61188 C² − 4.31805 C³)
//               (M. J.-Y. Chiang, P. Kutz, B. Burley, Practical and controllable subsurface
//               scattering for production path tracing, 2016; Blender's Principled BSDF)
#pragma once

#include "core/names.h"
#include "render/colour.h"
#include "render/material/homogeneous.h"

namespace kappamu::render {

struct Subsurface {
  enum class Convention { openpbr, principled };

  Convention convention = Convention::openpbr;
  Colour colour = Colour::Constant(0.8);     ///< C, in [0, 1)
  Colour radius_mm = Colour::Constant(1.0);  ///< above 0
  double anisotropy = 0.0;                   ///< g of openpbr, in (−1, 1)
};

inline constexpr Names<Subsurface::Convention, 2> convention_names{
    {{"openpbr", Subsurface::Convention::openpbr},
     {"principled", Subsurface::Convention::principled}}};

/// σs' = (1 − g) α σt, μ = (1 − α) σt.
HomogeneousMaterial material_of(const Subsurface& subsurface);

/// With g = 0. A principled colour is at most 1, at which α = 0.9989: media that absorb less have
/// colour 1 and keep their σs' + μ.
Subsurface subsurface_of(const HomogeneousMaterial& material, Subsurface::Convention convention);

}  // namespace kappamu::render
