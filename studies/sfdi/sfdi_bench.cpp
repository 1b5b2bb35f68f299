#include "studies/sfdi/lateral_table.h"
#include "studies/sfdi/photographs.h"
#include "studies/subjects.h"

namespace kappamu::studies {

Subject sfdi_subject() {
  return {
      "sfdi",
      "Absorption and scattering from photographs under sinusoidal light (docs/sfdi.md)",
      R"(  kappamu-studies sfdi --section peer phantoms tissue --data FOLDER -o out/

The folder holds phantoms.csv, peer_rd.csv, phantoms/ and pig/ with the photographs of
github.com/masontchen/GANPOP_Pytorch. `walks` and `table` remake the table of lateral transport,
forward/lateral/lateral_table.inc, and need no photographs: ten minutes of one core.)",
      {{"walks", "White Monte Carlo of the table", sfdi::measure_walks},
       {"table", "Polynomials fitted to the walks; writes lateral_table.inc", sfdi::measure_table},
       {"peer", "Reflectance beside two other groups' Monte Carlo", sfdi::measure_peer},
       {"phantoms", "Nine phantoms, each with each other one as reference", sfdi::measure_phantoms},
       {"tissue", "Tissue ex vivo, pixel by pixel", sfdi::measure_tissue}},
      {{"data", "Folder of the photographs", Setting::Kind::words},
       {"photons", "Of walks, for each anisotropy (default 1.6e7)", Setting::Kind::number, 100,
        1e10}}};
}

}  // namespace kappamu::studies
