#include "forward/lateral/chromophores.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"

namespace kappamu {
namespace {

TEST(Chromophores, HaemoglobinCrossesWhereItsFormsAbsorbAlike) {
  // Isosbestic points near 500, 530, 570 and 797 nm; oxygen makes it lighter at 660 nm and darker
  // at 940 nm, which is what a pulse oximeter counts on.
  const auto ratio = [](double nm) {
    return chromophore_absorption(Chromophore::hbo2, nm) /
           chromophore_absorption(Chromophore::hb, nm);
  };
  for (const double nm : {500.0, 530.0, 570.0, 797.0}) EXPECT_NEAR(ratio(nm), 1.0, 0.06) << nm;
  EXPECT_LT(ratio(660.0), 0.12);
  EXPECT_GT(ratio(940.0), 1.5);
}

TEST(Chromophores, WholeBloodAndWaterAbsorbAsPublished) {
  // 150 g/l of 64,500 g/mol at 660 nm: 0.17 /mm with oxygen, 1.73 /mm without (Prahl).
  const double blood = 150.0 / 64500.0 * 1e6;  // umol/l
  EXPECT_NEAR(blood * chromophore_absorption(Chromophore::hbo2, 660.0), 0.171, 0.002);
  EXPECT_NEAR(blood * chromophore_absorption(Chromophore::hb, 660.0), 1.728, 0.01);
  EXPECT_NEAR(chromophore_absorption(Chromophore::water, 980.0), 0.043, 0.003);
  // Fat's band at 930 nm; melanin falls with the wavelength's power 3.48.
  EXPECT_GT(chromophore_absorption(Chromophore::fat, 930.0),
            2.5 * chromophore_absorption(Chromophore::fat, 900.0));
  EXPECT_NEAR(chromophore_absorption(Chromophore::melanin, 500.0) /
                  chromophore_absorption(Chromophore::melanin, 1000.0),
              std::pow(2.0, 3.48), 1e-9);
}

TEST(Chromophores, RefuseWavelengthsBeyondTheTables) {
  for (const double nm : {449.0, 1001.0, std::nan("")}) {
    EXPECT_THROW(chromophore_absorption(Chromophore::water, nm), InputError) << nm;
  }
}

}  // namespace
}  // namespace kappamu
