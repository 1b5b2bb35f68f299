// What absorbs in tissue, by wavelength: haemoglobin with and without oxygen, water, fat, melanin.
//
// Sources. Haemoglobin: S. Prahl's compilation of W. B. Gratzer's and N. Kollias' measurements
// (omlc.org/spectra/hemoglobin, molar extinction of the tetramer, 64,500 g/mol). Water: Hale and
// Querry, Appl. Opt. 12, 555 (1973). Fat: van Veen et al., J. Biomed. Opt. 10, 054004 (2005).
// Melanin: melanosome's 1.70e12 (λ/nm)^-3.48 per cm (S. Jacques, omlc.org/news/jan98).
#pragma once

#include <array>

#include "core/names.h"

namespace kappamu {

enum class Chromophore { hbo2, hb, water, fat, melanin };
inline constexpr Names<Chromophore, 5> chromophore_names{{{"hbo2", Chromophore::hbo2},
                                                          {"hb", Chromophore::hb},
                                                          {"water", Chromophore::water},
                                                          {"fat", Chromophore::fat},
                                                          {"melanin", Chromophore::melanin}}};

/// [nm]; the tables' first and last wavelength.
inline constexpr double first_chromophore_nm = 450.0, last_chromophore_nm = 1000.0;

/// "umol/l" of hbo2 and hb; "" where the amount is a volume fraction.
const char* chromophore_unit(Chromophore chromophore);

/// Absorption [1/mm] of one unit. Tables are linear between every 10 nm; outside them, and for a
/// wavelength that is no number, throws InputError.
double chromophore_absorption(Chromophore chromophore, double wavelength_nm);

}  // namespace kappamu
