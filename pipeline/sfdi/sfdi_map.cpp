#include "pipeline/sfdi/sfdi_map.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/parallel.h"
#include "core/shown_text.h"
#include "pipeline/sfdi/calibration.h"
#include "pipeline/sfdi/median.h"
#include "pipeline/sfdi/sfdi_layers.h"
#include "pipeline/sfdi/sfdi_neighbours.h"
#include "pipeline/sfdi/sfdi_ratios.h"
#include "pipeline/sfdi/sfdi_spectra.h"

namespace kappamu::pipeline::sfdi {

namespace {

using inverse::LateralCoefficients;
using inverse::LateralFit;
using inverse::LateralVerdict;
using inverse::PerFrequency;

// Stripes and harmonics above this part of the amplitude are reported: they shift R(f) by as much.
constexpr double reported_stripes = 0.02;
// A sinusoid whose own frequency is off by more than this part is reported.
constexpr double reported_frequency = 0.02;
// Fringes further from the phantom's are reported: by a projector at 15 degrees, a height of 2 mm.
constexpr double reported_shift_mm = 0.5;
// Weight of a pixel without noise of its own, relative.
constexpr double least_deviation = 1e-4;

/// Standard deviations [1/mm], [1/mm] and of κ = 1/(3(μa + σs')) [mm].
struct Deviations {
  double mua = 0.0, musp = 0.0, kappa = 0.0;
};

/// `covariance` of ln μa and ln σs'.
Deviations deviations(const LateralCoefficients& at, const Eigen::Matrix2d& covariance) {
  const double sum = at.mua + at.musp;
  const Eigen::Vector2d by_log(at.mua / sum, at.musp / sum);
  return {at.mua * std::sqrt(covariance(0, 0)), at.musp * std::sqrt(covariance(1, 1)),
          std::sqrt(by_log.dot(covariance * by_log)) / (3.0 * sum)};
}

Eigen::Matrix2d noise_covariance(const LateralFit& fit, const PerFrequency& deviation) {
  const inverse::Gain noise = fit.gain * deviation.asDiagonal();
  return noise * noise.transpose();
}

/// The maps of one wavelength.
class Mapper {
 public:
  Mapper(const Description& description, WavelengthMap map, Ratios measured)
      : d_(description), map_(std::move(map)) {
    ratios_ = std::move(measured.by_frequency);
    relief_ = std::move(measured.relief);
    if (relief_) map_.height_mm = relief_->height_mm;
    frequency_.resize(static_cast<Eigen::Index>(ratios_.size()));
    if (ratios_.size() > inverse::most_frequencies) {
      throw InputError((d_.folder / file_name).string() + ": measurements has " +
                       std::to_string(ratios_.size()) + " lights of one wavelength; at most " +
                       std::to_string(inverse::most_frequencies) + " are fitted together");
    }
    for (std::size_t i = 0; i < ratios_.size(); ++i) {
      frequency_[static_cast<Eigen::Index>(i)] = ratios_[i].per_mm;
      far_[i] = ratios_[i].far;
      if (!ratios_[i].value.same_shape(ratios_.front().value)) {
        throw InputError((d_.folder / file_name).string() +
                         ": the sample's pictures differ in size between measurements");
      }
    }
    if (cover_is_unknown(d_.medium)) find_cover();
    calibration_.emplace(d_, map_.wavelength_nm, frequency_, far_);
  }

  WavelengthMap map() {
    const int width = ratios_.front().value.width(), height = ratios_.front().value.height();
    const Image<float> unset(width, height, 1, not_valid);
    map_.mua = map_.musp = map_.kappa = unset;
    map_.mua_deviation = map_.musp_deviation = map_.kappa_deviation = unset;
    map_.verdict = Image<std::uint8_t>(width, height, 1);
    std::vector<std::vector<std::array<double, 2 * part_names.size()>>> parts(height);
    for_rows(height, [&](int y) {
      LateralCoefficients start;
      for (int x = 0; x < width; ++x) pixel(x, y, start, parts[y]);
    });
    for (std::size_t i = 0; i < 2 * part_names.size(); ++i) {
      std::vector<double> all;
      for (const auto& row : parts) {
        for (const auto& one : row) all.push_back(one[i]);
      }
      map_.parts[i / 2][i % 2] = median(std::move(all));
    }
    if (d_.region_px) region(*d_.region_px);
    return std::move(map_);
  }

 private:
  /// Both layers of the region; the upper one is then known to the map.
  void find_cover() {
    Description bare = d_;
    bare.medium.cover.reset();
    calibration_.emplace(bare, map_.wavelength_nm, frequency_, far_);
    const Image<float>& picture = ratios_.front().value;
    const std::array<int, 4> all{0, 0, picture.width(), picture.height()};
    const std::array<int, 4> box = d_.region_px.value_or(all);
    PerFrequency mean = PerFrequency::Zero(frequency_.size()), variance = mean, reflectance, noise;
    double n = 0.0;
    for (int y = box[1]; y < std::min(box[1] + box[3], picture.height()); ++y) {
      for (int x = box[0]; x < std::min(box[0] + box[2], picture.width()); ++x) {
        if (!read(x, y, reflectance, noise)) continue;
        ++n;
        mean += reflectance;
        variance += noise.cwiseAbs2();
      }
    }
    const std::string file = (d_.folder / file_name).string();
    if (n == 0.0) throw InputError(file + ": region_px holds no pixel with light");
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      variance[i] *= ratios_[static_cast<std::size_t>(i)].shared_pixels / (n * n);
    }
    const PerFrequency deviation = variance.cwiseSqrt();
    const LateralFit even = fit(frequency_, mean / n, deviation, {});
    if (even.verdict != LateralVerdict::good) {
      throw InputError(file +
                       ": the region's reflectances are of no medium to start from; check "
                       "the scale, or choose another region_px");
    }
    map_.layers =
        find_layers(d_.medium, *calibration_, frequency_, mean / n, deviation, even.coefficients);
    d_.medium.cover = as_cover(*map_.layers, *d_.medium.cover->thickness_mm, map_.wavelength_nm);
  }

  bool read(int x, int y, PerFrequency& reflectance, PerFrequency& noise) const {
    reflectance.resize(frequency_.size());
    noise.resize(frequency_.size());
    for (Eigen::Index i = 0; i < frequency_.size(); ++i) {
      const Ratio& ratio = ratios_[static_cast<std::size_t>(i)];
      if (ratio.mask(x, y) == 0) return false;
      reflectance[i] = ratio.value(x, y) * calibration_->scale()[i];
      noise[i] = ratio.deviation(x, y);
    }
    return true;
  }

  PerFrequency detail_at(int x, int y) const {
    PerFrequency detail = PerFrequency::Zero(frequency_.size());
    for (Eigen::Index i = 0; i < detail.size(); ++i) {
      const Image<float>& of = ratios_[static_cast<std::size_t>(i)].detail;
      if (!of.empty()) detail[i] = of(x, y);
    }
    return detail;
  }

  /// On the surface at a pixel.
  PerFrequency frequency_at(int x, int y) const {
    return relief_ ? PerFrequency(frequency_ * relief_->frequency(x, y)) : frequency_;
  }

  LateralFit fit(const PerFrequency& frequency, const PerFrequency& reflectance,
                 const PerFrequency& noise, const LateralCoefficients& start) const {
    const double own = d_.errors ? d_.errors->own : 0.0;
    const PerFrequency weight =
        (noise.array().square() + own * own + least_deviation * least_deviation).sqrt();
    return fit_lateral(calibration_->sample().stated, frequency, reflectance, weight, start, far_);
  }

  void pixel(int x, int y, LateralCoefficients& start,
             std::vector<std::array<double, 2 * part_names.size()>>& parts) {
    PerFrequency reflectance, noise;
    LateralFit fitted;
    fitted.verdict = LateralVerdict::no_light;
    if (read(x, y, reflectance, noise)) {
      const PerFrequency frequency = frequency_at(x, y);
      fitted = fit(frequency, reflectance, noise, start);
      if (fitted.verdict == LateralVerdict::no_medium) {
        fitted = fit(frequency, reflectance, noise, {});
      }
    }
    map_.verdict(x, y) = static_cast<std::uint8_t>(fitted.verdict);
    if (fitted.verdict != LateralVerdict::good) return;
    start = fitted.coefficients;
    Calibration::Shared shared = calibration_->shared_errors(fitted);
    shared.covariance[static_cast<std::size_t>(Part::noise)] = noise_covariance(fitted, noise);
    shared.covariance[static_cast<std::size_t>(Part::detail)] =
        noise_covariance(fitted, detail_at(x, y));
    const Deviations deviation = deviations(start, shared.total());
    map_.mua(x, y) = static_cast<float>(start.mua);
    map_.musp(x, y) = static_cast<float>(start.musp);
    map_.kappa(x, y) = static_cast<float>(1.0 / (3.0 * (start.mua + start.musp)));
    map_.mua_deviation(x, y) = static_cast<float>(deviation.mua);
    map_.musp_deviation(x, y) = static_cast<float>(deviation.musp);
    map_.kappa_deviation(x, y) = static_cast<float>(deviation.kappa);
    auto& row = parts.emplace_back();
    for (std::size_t i = 0; i < part_names.size(); ++i) {
      for (const int which : {0, 1}) {
        row[2 * i + static_cast<std::size_t>(which)] =
            std::sqrt(shared.covariance[i](which, which));
      }
    }
  }

  /// Mean, spread and deviation over a box; the shared errors at the mean's coefficients.
  void region(const std::array<int, 4>& box) {
    std::vector<std::array<double, 2>> values;
    PerFrequency mean = PerFrequency::Zero(frequency_.size()), variance = mean, reflectance, noise;
    for (int y = box[1]; y < std::min(box[1] + box[3], map_.mua.height()); ++y) {
      for (int x = box[0]; x < std::min(box[0] + box[2], map_.mua.width()); ++x) {
        if (map_.verdict(x, y) != 0 || !read(x, y, reflectance, noise)) continue;
        values.push_back({map_.mua(x, y), map_.musp(x, y)});
        mean += reflectance;
        variance += noise.cwiseAbs2();
      }
    }
    if (values.empty()) {
      throw InputError((d_.folder / file_name).string() +
                       ": region_px holds no pixel with valid coefficients");
    }
    const auto n = static_cast<double>(values.size());
    RegionMean result{values.size(), {0.0, 0.0}, {}, {}};
    for (const auto& [mua, musp] : values) {
      result.mean.mua += mua / n;
      result.mean.musp += musp / n;
    }
    for (const auto& [mua, musp] : values) {
      result.spread[0] += (mua - result.mean.mua) * (mua - result.mean.mua) / n;
      result.spread[1] += (musp - result.mean.musp) * (musp - result.mean.musp) / n;
    }
    for (double& spread : result.spread) spread = std::sqrt(spread);
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      variance[i] *= ratios_[static_cast<std::size_t>(i)].shared_pixels / (n * n);
    }
    const PerFrequency deviation = variance.cwiseSqrt();
    const LateralFit fitted = fit(frequency_, mean / n, deviation, result.mean);
    if (fitted.verdict == LateralVerdict::good) {
      Calibration::Shared shared = calibration_->shared_errors(fitted);
      shared.covariance[static_cast<std::size_t>(Part::noise)] =
          noise_covariance(fitted, deviation);
      const Deviations total = deviations(result.mean, shared.total());
      result.deviation = {total.mua, total.musp};
    }
    map_.region = result;
  }

  Description d_;
  WavelengthMap map_;
  std::vector<Ratio> ratios_;
  std::optional<calib::Relief> relief_;
  PerFrequency frequency_;
  inverse::FarSides far_;
  std::optional<Calibration> calibration_;
};

}  // namespace

void add_map_warnings(const WavelengthMap& map, double pixel_mm,
                      std::vector<std::string>& warnings) {
  const std::string at = map.label() + ", ";
  const bool measured_height = !map.height_mm.empty();
  for (const LightCheck& check : map.checks) {
    const std::string where = at + shown_number(check.per_mm) + " /mm: ";
    if (check.found_per_mm &&
        std::abs(*check.found_per_mm / check.per_mm - 1.0) > reported_frequency) {
      warnings.push_back(where + "the sinusoid seen has " +
                         shown_number(*check.found_per_mm, "%.4g") +
                         " /mm; check pixel_mm, or the sample is tilted.");
    }
    if (check.second_harmonic > reported_stripes) {
      warnings.push_back(where + "the second harmonic is " +
                         shown_number(100.0 * check.second_harmonic, "%.2g") +
                         " % of the amplitude; the projector's response is not linear.");
    }
    if (check.stripes > reported_stripes) {
      warnings.push_back(where + "demodulation leaves stripes of " +
                         shown_number(100.0 * check.stripes, "%.2g") +
                         " % of the amplitude; the light changes between phases, or a phase is "
                         "wrong.");
    }
    if (!measured_height && check.shift_mm.value_or(0.0) > reported_shift_mm) {
      warnings.push_back(where + "fringes lie " + shown_number(*check.shift_mm, "%.2g") +
                         " mm from the phantom's; the sample is higher or lower, which changes "
                         "its light: state projector, or place both alike.");
    }
    if (check.per_mm > 0.5) {
      warnings.push_back(where +
                         "beyond 0.5 /mm the reflectance depends on the phase function, not on g "
                         "alone; these coefficients are uncertain.");
    }
    if (check.saturated > 0) {
      warnings.push_back(where + std::to_string(check.saturated) +
                         " saturated pixels are left out.");
    }
  }
  if (map.layers) add_layer_warnings(map.label(), *map.layers, warnings);
  std::array<std::size_t, inverse::lateral_verdict_names.size()> counts{};
  for (const std::uint8_t verdict : map.verdict.values()) ++counts[verdict];
  const auto total = static_cast<double>(map.verdict.size());
  if (counts[static_cast<std::size_t>(LateralVerdict::good)] == 0) {
    const auto most = std::max_element(counts.begin(), counts.end()) - counts.begin();
    std::size_t saturated = 0;
    for (const auto& check : map.checks) saturated = std::max(saturated, check.saturated);
    throw InputError(at + "no pixel has coefficients (most: " +
                     inverse::lateral_verdict_names[static_cast<std::size_t>(most)].first +
                     "); check the phantom, the scale and per_mm in " + file_name +
                     (saturated > 0 ? ", and the exposure: " + std::to_string(saturated) +
                                          " pixels are saturated"
                                    : ""));
  }
  const std::size_t none = counts[static_cast<std::size_t>(LateralVerdict::no_medium)];
  if (static_cast<double>(none) > 0.001 * total) {
    warnings.push_back(
        at + shown_number(100.0 * static_cast<double>(none) / total, "%.2g") +
        " % of the pixels have reflectances of no homogeneous medium: glare, shadow, an edge, or a "
        "sample thinner than stated.");
  }
  if (auto sentence = neighbours_warning(map, pixel_mm)) warnings.push_back(*std::move(sentence));
}

WavelengthMap map_of_ratios(const Description& description, WavelengthMap map, Ratios ratios) {
  return Mapper(description, std::move(map), std::move(ratios)).map();
}

Maps measure_maps(const Description& description, Progress& progress) {
  std::set<double> wavelengths;
  for (const Pictures& p : description.measurements) wavelengths.insert(p.wavelength_nm);
  Maps maps;
  for (const double wavelength : wavelengths) {
    progress.update(
        "map " + shown_number(wavelength) + " nm",
        static_cast<double>(maps.wavelengths.size()) / static_cast<double>(wavelengths.size()), "");
    WavelengthMap map;
    map.wavelength_nm = wavelength;
    Ratios ratios = measure_ratios(description, wavelength, map.checks);
    maps.wavelengths.push_back(map_of_ratios(description, std::move(map), std::move(ratios)));
    add_map_warnings(maps.wavelengths.back(), description.pixel_mm, maps.warnings);
  }
  add_spectra(description, maps);
  return maps;
}

}  // namespace kappamu::pipeline::sfdi
