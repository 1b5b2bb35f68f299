#include "forward/lateral/chromophores.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu {

namespace {

struct Row {
  double nm;
  double hbo2, hb;    ///< molar extinction, decadic [1/(cm mol/l)]
  double water, fat;  ///< absorption [1/mm]
};

constexpr double step_nm = 10.0;
constexpr std::array<Row, 56> table{{
    {450, 62816, 103292, 2.8e-05, 0.006375},      {460, 44480, 23388.8, 2.612e-05, 0.005523},
    {470, 33209.2, 16156.4, 2.488e-05, 0.004327}, {480, 26629.2, 14550, 2.471e-05, 0.003315},
    {490, 23684.4, 16684, 2.481e-05, 0.002515},   {500, 20932.8, 20862, 2.5e-05, 0.001906},
    {510, 20035.2, 25773.6, 2.667e-05, 0.001501}, {520, 24202.4, 31589.6, 3.013e-05, 0.001231},
    {530, 39956.8, 39036.4, 3.391e-05, 0.001031}, {540, 53236, 46592, 3.859e-05, 0.000896},
    {550, 43016, 53412, 4.5e-05, 0.000773},       {560, 32613.2, 53788, 5.435e-05, 0.000698},
    {570, 44496, 45072, 6.896e-05, 0.000629},     {580, 50104, 37020, 9.94e-05, 0.000566},
    {590, 14400.8, 28324.4, 0.0001714, 0.000502}, {600, 3200, 14677.2, 0.00023, 0.000466},
    {610, 1506, 9443.6, 0.0002542, 0.000464},     {620, 942, 6509.6, 0.0002715, 0.00043},
    {630, 610, 5148.8, 0.000288, 0.000428},       {640, 442, 4345.2, 0.0003021, 0.000452},
    {650, 368, 3750.12, 0.00032, 0.000471},       {660, 319.6, 3226.56, 0.0003495, 0.000418},
    {670, 294, 2795.12, 0.0003909, 0.00045},      {680, 277.6, 2407.92, 0.0004403, 0.000406},
    {690, 276, 2051.96, 0.000502, 0.000342},      {700, 290, 1794.28, 0.0006, 0.000323},
    {710, 314, 1540.48, 0.0008974, 0.000315},     {720, 348, 1325.88, 0.001369, 0.000367},
    {730, 390, 1102.2, 0.001823, 0.000499},       {740, 446, 1115.88, 0.00234, 0.000654},
    {750, 518, 1405.24, 0.0026, 0.000972},        {760, 586, 1548.52, 0.002555, 0.001278},
    {770, 650, 1311.88, 0.002455, 0.000871},      {780, 710, 1075.44, 0.002326, 0.000409},
    {790, 756, 890.8, 0.002124, 0.000346},        {800, 816, 761.72, 0.002, 0.000403},
    {810, 864, 717.08, 0.001986, 0.000527},       {820, 916, 693.76, 0.002391, 0.000691},
    {830, 974, 693.04, 0.002907, 0.000803},       {840, 1022, 692.36, 0.003471, 0.000726},
    {850, 1058, 691.32, 0.0043, 0.000637},        {860, 1092, 694.32, 0.004676, 0.000674},
    {870, 1128, 705.84, 0.0052, 0.000938},        {880, 1154, 726.44, 0.005598, 0.001636},
    {890, 1178, 743.6, 0.006043, 0.003116},       {900, 1198, 761.84, 0.0068, 0.004633},
    {910, 1214, 774.56, 0.007291, 0.007046},      {920, 1224, 777.36, 0.01093, 0.01065},
    {930, 1222, 763.84, 0.0173, 0.0131},          {940, 1214, 693.44, 0.02674, 0.008754},
    {950, 1204, 602.24, 0.039, 0.003799},         {960, 1186, 525.56, 0.042, 0.002047},
    {970, 1162, 429.32, 0.045, 0.001528},         {980, 1128, 359.656, 0.043, 0.001417},
    {990, 1080, 283.22, 0.041, 0.001716},         {1000, 1024, 206.784, 0.036, 0.002654},
}};

double unit_absorption(Chromophore chromophore, const Row& row) {
  // Decadic per cm and mol/l to natural per mm and µmol/l.
  constexpr double molar = std::numbers::ln10 * 0.1 * 1e-6;
  switch (chromophore) {
    case Chromophore::hbo2:
      return molar * row.hbo2;
    case Chromophore::hb:
      return molar * row.hb;
    case Chromophore::water:
      return row.water;
    default:
      return row.fat;
  }
}

}  // namespace

const char* chromophore_unit(Chromophore chromophore) {
  return chromophore == Chromophore::hbo2 || chromophore == Chromophore::hb ? "umol/l" : "";
}

double chromophore_absorption(Chromophore chromophore, double wavelength_nm) {
  if (!(wavelength_nm >= first_chromophore_nm && wavelength_nm <= last_chromophore_nm)) {
    throw InputError("absorption of " + std::string(name_of(chromophore_names, chromophore)) +
                     " is known from " + shown_number(first_chromophore_nm) + " to " +
                     shown_number(last_chromophore_nm) + " nm, not at " +
                     shown_number(wavelength_nm) + " nm");
  }
  if (chromophore == Chromophore::melanin) return 1.70e11 * std::pow(wavelength_nm, -3.48);
  const double at = (wavelength_nm - first_chromophore_nm) / step_nm;
  const auto below = std::min(static_cast<std::size_t>(at), table.size() - 2);
  const double part = at - static_cast<double>(below);
  return (1.0 - part) * unit_absorption(chromophore, table[below]) +
         part * unit_absorption(chromophore, table[below + 1]);
}

}  // namespace kappamu
