#include "pipeline/sfdi/sfdi_spectra.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.h"
#include "core/file_name.h"
#include "core/parallel.h"
#include "core/shown_text.h"
#include "forward/lateral/chromophores.h"
#include "inverse/lateral/spectral_fit.h"
#include "io/csv_table.h"
#include "pipeline/sfdi/median.h"

namespace kappamu::pipeline::sfdi {

namespace {

// A median of χ² per degree of freedom above this: deviations would be twice too small.
constexpr double explained = 4.0;
const std::string hbo2 = name_of(chromophore_names, Chromophore::hbo2);
const std::string hb = name_of(chromophore_names, Chromophore::hb);

std::vector<double> wavelengths_of(const Description& d) {
  std::set<double> all;
  for (const Pictures& p : d.measurements) all.insert(p.wavelength_nm);
  return {all.begin(), all.end()};
}

/// Absorption of one unit [1/mm] by the lab's own table, linear between its wavelengths.
class OwnTable {
 public:
  OwnTable(const std::filesystem::path& file, const std::string& absorber) : file_(file.string()) {
    std::string column = absorber;
    std::transform(column.begin(), column.end(), column.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    io::read_csv(
        file, {{"wavelength_nm"}, {column.c_str()}},
        [&](const std::vector<std::string>& cells, const std::string& where) {
          const auto nm = io::csv_number(cells[0]), value = io::csv_number(cells[1]);
          if (!nm || !value || !(*nm > 0.0) || !(*value >= 0.0)) {
            throw InputError(where + ": wavelength_nm is above 0, and " + column + " 0 or above");
          }
          rows_.emplace_back(*nm, *value);
        });
    std::sort(rows_.begin(), rows_.end());
    for (std::size_t i = 1; i < rows_.size(); ++i) {
      if (rows_[i].first == rows_[i - 1].first) {
        throw InputError(file_ + ": states " + shown_number(rows_[i].first) + " nm twice");
      }
    }
  }

  double at(double nm) const {
    const auto above = std::lower_bound(rows_.begin(), rows_.end(), std::pair{nm, 0.0});
    if (above == rows_.end() || (above == rows_.begin() && above->first > nm)) {
      throw InputError(file_ + ": does not reach " + shown_number(nm) + " nm");
    }
    if (above->first == nm) return above->second;
    const auto below = above - 1;
    const double part = (nm - below->first) / (above->first - below->first);
    return (1.0 - part) * below->second + part * above->second;
  }

 private:
  std::string file_;
  std::vector<std::pair<double, double>> rows_;
};

/// Column by absorber, row by wavelength [1/mm per unit].
Eigen::MatrixXd spectra_of(const Description& d) {
  const std::vector<double> nm = wavelengths_of(d);
  const Spectra& spectra = *d.spectra;
  Eigen::MatrixXd all(static_cast<Eigen::Index>(nm.size()),
                      static_cast<Eigen::Index>(spectra.absorbers.size()));
  for (Eigen::Index j = 0; j < all.cols(); ++j) {
    const std::string& name = spectra.absorbers[static_cast<std::size_t>(j)];
    const auto known = value_of(chromophore_names, name);
    if (!known && spectra.file.empty()) {
      throw InputError("'" + shown_name(name) + "' is no absorber of the built-in tables, " +
                       list_of(chromophore_names) + "; name a \"file\" that has its spectrum");
    }
    std::optional<OwnTable> own;
    if (!spectra.file.empty()) own.emplace(d.folder / spectra.file, name);
    for (Eigen::Index i = 0; i < all.rows(); ++i) {
      const double at = nm[static_cast<std::size_t>(i)];
      all(i, j) = own ? own->at(at) : chromophore_absorption(*known, at);
    }
  }
  return all;
}

bool states_saturation(const Description& d) {
  if (!d.spectra) return false;
  const auto& names = d.spectra->absorbers;
  return std::find(names.begin(), names.end(), hbo2) != names.end() &&
         std::find(names.begin(), names.end(), hb) != names.end();
}

class Spectrometer {
 public:
  Spectrometer(const Description& d, Maps& maps) : d_(d), maps_(maps) {
    const Image<float>& first = maps.wavelengths.front().mua;
    if (d.spectra) spectra_ = spectra_of(d);
    wavelength_nm_.resize(static_cast<Eigen::Index>(maps.wavelengths.size()));
    for (Eigen::Index i = 0; i < wavelength_nm_.size(); ++i) {
      const WavelengthMap& map = maps.wavelengths[static_cast<std::size_t>(i)];
      wavelength_nm_[i] = map.wavelength_nm;
      if (!map.mua.same_shape(first)) {
        throw InputError((d.folder / file_name).string() +
                         ": pictures of different wavelengths differ in size");
      }
    }
    const Image<float> unset(first.width(), first.height(), 1, not_valid);
    for (const std::string& name : spectral_names(d)) {
      maps.spectral.push_back({name, unit_of(name), unset, unset});
    }
  }

  void run() {
    const std::size_t pixels = maps_.wavelengths.front().mua.size();
    const int height = maps_.wavelengths.front().mua.height();
    const std::size_t width = pixels / static_cast<std::size_t>(height);
    std::vector<double> chi_square(pixels, std::numeric_limits<double>::quiet_NaN());
    for_rows(height, [&](int y) {
      for (std::size_t x = 0; x < width; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * width + x;
        pixel(i, chi_square[i]);
      }
    });
    std::erase_if(chi_square, [](double one) { return std::isnan(one); });
    const Eigen::Index freedom = spectra_.rows() - spectra_.cols();
    if (!d_.spectra || freedom < 1 || chi_square.empty()) return;
    maps_.chi_square = median(std::move(chi_square)) / static_cast<double>(freedom);
    if (*maps_.chi_square <= explained) return;
    std::string names;
    for (const std::string& name : d_.spectra->absorbers) {
      names += (names.empty() ? "" : ", ") + shown_name(name);
    }
    maps_.warnings.push_back(
        "amounts of " + names + " do not explain the absorption (median chi square " +
        shown_number(*maps_.chi_square, "%.2g") +
        " per degree of freedom); another absorber is there, or deviations are stated too small.");
  }

 private:
  static std::string unit_of(const std::string& name) {
    if (name == "scattering_500nm") return "1/mm";
    const auto known = value_of(chromophore_names, name);
    return known ? chromophore_unit(*known) : "";
  }

  void set(std::size_t map, std::size_t pixel, double value, double deviation) {
    maps_.spectral[map].value.values()[pixel] = static_cast<float>(value);
    maps_.spectral[map].deviation.values()[pixel] = static_cast<float>(deviation);
  }

  void pixel(std::size_t i, double& chi_square) {
    const Eigen::Index n = wavelength_nm_.size();
    Eigen::VectorXd mua(n), mua_deviation(n), musp(n), musp_deviation(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const WavelengthMap& map = maps_.wavelengths[static_cast<std::size_t>(k)];
      if (map.verdict.values()[i] != 0) return;
      mua[k] = map.mua.values()[i];
      musp[k] = map.musp.values()[i];
      mua_deviation[k] = std::max<double>(map.mua_deviation.values()[i], 1e-4 * mua[k]);
      musp_deviation[k] = std::max<double>(map.musp_deviation.values()[i], 1e-4 * musp[k]);
    }
    std::size_t next = 0;
    const inverse::ScatteringLaw law =
        inverse::fit_scattering_law(wavelength_nm_, musp, musp_deviation);
    set(next++, i, law.at_500nm, law.at_500nm_deviation);
    set(next++, i, law.exponent, law.exponent_deviation);
    if (!d_.spectra) return;
    const inverse::AmountFit fit = inverse::fit_amounts(spectra_, mua, mua_deviation);
    chi_square = fit.chi_square;
    for (Eigen::Index j = 0; j < fit.amount.size(); ++j) {
      set(next++, i, fit.amount[j], fit.deviation(j));
    }
    if (states_saturation(d_)) saturation(next, i, fit);
  }

  /// hbo2/(hbo2 + hb); the deviation by the amounts' covariance.
  void saturation(std::size_t map, std::size_t i, const inverse::AmountFit& fit) {
    const auto& names = d_.spectra->absorbers;
    const auto index = [&](const std::string& name) {
      return std::find(names.begin(), names.end(), name) - names.begin();
    };
    const Eigen::Index with = index(hbo2), without = index(hb);
    const double total = fit.amount[with] + fit.amount[without];
    if (!(total > 0.0)) return;
    const double value = fit.amount[with] / total;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(fit.amount.size());
    slope[with] = (1.0 - value) / total;
    slope[without] = -value / total;
    set(map, i, value, std::sqrt(std::max(0.0, slope.dot(fit.covariance * slope))));
  }

  const Description& d_;
  Maps& maps_;
  Eigen::VectorXd wavelength_nm_;
  Eigen::MatrixXd spectra_;
};

}  // namespace

std::vector<std::string> spectral_names(const Description& description) {
  if (wavelengths_of(description).size() < 2) return {};
  std::vector<std::string> names{"scattering_500nm", "scattering_exponent"};
  if (!description.spectra) return names;
  const auto& absorbers = description.spectra->absorbers;
  names.insert(names.end(), absorbers.begin(), absorbers.end());
  if (states_saturation(description)) names.emplace_back("saturation");
  return names;
}

void check_spectra(const Description& description) {
  if (!description.spectra) return;
  const std::string field = (description.folder / file_name).string() + ": spectra.absorbers ";
  const auto& absorbers = description.spectra->absorbers;
  const std::size_t wavelengths = wavelengths_of(description).size();
  if (absorbers.empty() || absorbers.size() > inverse::most_absorbers) {
    throw InputError(field + "names " + std::to_string(absorbers.size()) + " absorbers; 1 to " +
                     std::to_string(inverse::most_absorbers) + " can be fitted");
  }
  if (absorbers.size() > wavelengths || wavelengths < 2) {
    throw InputError(field + "names " + std::to_string(absorbers.size()) + " absorbers for " +
                     std::to_string(wavelengths) +
                     " wavelengths; measure at as many wavelengths as there are absorbers, and at "
                     "two or more");
  }
  for (const std::string& name : absorbers) {
    if (name.empty() ||
        name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos) {
      throw InputError(field + "has '" + shown_name(name) +
                       "'; a name has small letters, digits and _, as files are named by it");
    }
  }
  try {
    if (!inverse::distinct(spectra_of(description))) {
      throw InputError(
          "are alike at these wavelengths; leave one out, or choose wavelengths where "
          "their spectra differ");
    }
  } catch (const InputError& error) {
    throw InputError(field.substr(0, field.size() - 1) + ": " + error.what());
  }
}

void add_spectra(const Description& description, Maps& maps) {
  if (maps.wavelengths.size() < 2) return;
  Spectrometer(description, maps).run();
}

}  // namespace kappamu::pipeline::sfdi
