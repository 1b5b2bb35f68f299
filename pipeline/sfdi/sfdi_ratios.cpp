#include "pipeline/sfdi/sfdi_ratios.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/error.h"
#include "core/shown_text.h"
#include "pipeline/sfdi/median.h"
#include "pipeline/sfdi/sfdi_pictures.h"

namespace kappamu::pipeline::sfdi {

namespace {

using calib::Demodulated;

constexpr double two_pi = 2.0 * std::numbers::pi;
// Standard deviation of the Gaussian over heights whose slopes tilt the surface.
constexpr double relief_smoothing_mm = 1.0;

/// Mean of light over a box; throws InputError where nothing in it is valid.
double box_mean(const Image<float>& light, const Image<std::uint8_t>& mask,
                const std::array<int, 4>& box, const std::string& field) {
  double sum = 0.0;
  std::size_t count = 0;
  for (int y = box[1]; y < std::min(box[1] + box[3], light.height()); ++y) {
    for (int x = box[0]; x < std::min(box[0] + box[2], light.width()); ++x) {
      if (mask(x, y) == 0) continue;
      sum += light(x, y);
      ++count;
    }
  }
  if (count == 0) throw InputError(field + " holds no pixel that can be used");
  return sum / static_cast<double>(count);
}

/// Reads a wavelength's pictures and turns them into ratios.
class Wavelength {
 public:
  Wavelength(const Description& description, double wavelength_nm, std::vector<LightCheck>& checks)
      : d_(description), wavelength_nm_(wavelength_nm), checks_(checks) {
    for (const Pictures& p : d_.measurements) {
      if (p.wavelength_nm != wavelength_nm) continue;
      if (p.side == Side::far) {
        far_.push_back(&p);
      } else {
        (p.per_mm == 0.0 ? even_ : sinusoids_).push_back(&p);
      }
    }
    if (even_.size() > 1) {
      throw InputError((d_.folder / file_name).string() +
                       ": measurements has even light twice at " + shown_number(wavelength_nm) +
                       " nm; name one");
    }
  }

  Ratios ratios() {
    std::optional<Demodulated> sample, phantom;  // under even light
    if (!even_.empty()) {
      sample = read(*even_.front(), true, nullptr);
      if (!even_.front()->reference.empty()) phantom = read(*even_.front(), false, nullptr);
    }
    // The lowest frequency first: its fringes tell heights apart over the longest range.
    std::stable_sort(sinusoids_.begin(), sinusoids_.end(),
                     [](const Pictures* a, const Pictures* b) { return a->per_mm < b->per_mm; });
    for (const Pictures* p : sinusoids_) {
      const Demodulated one = read(*p, true, sample ? &*sample : nullptr);
      const std::size_t check = checks_.size() - 1;
      std::optional<Demodulated> reference;
      if (!p->reference.empty()) reference = read(*p, false, phantom ? &*phantom : nullptr);
      if (reference && p->content == Content::light && p->sample.size() > 1 &&
          p->reference.size() > 1) {
        compare_phases(*p, one, *reference, checks_[check]);
      }
      if (result_.by_frequency.empty()) add_even(*p, sample, phantom, one, reference);
      add(p->per_mm, one, reference, &Demodulated::amplitude, &Demodulated::amplitude_deviation,
          &Demodulated::amplitude_detail);
    }
    if (sinusoids_.empty()) {  // even light, and what shines through
      if (d_.reference && !phantom && even_.front()->content != Content::ratio) {
        throw InputError((d_.folder / file_name).string() + ": measurements: even light at " +
                         shown_number(wavelength_nm_) + " nm lacks the phantom's picture; name it");
      }
      add(0.0, *sample, phantom, &Demodulated::mean, &Demodulated::mean_deviation,
          &Demodulated::mean_detail);
    }
    if (result_.relief) correct();
    add_far();
    if (result_.by_frequency.size() < 2) {
      throw InputError((d_.folder / file_name).string() + ": measurements has one frequency at " +
                       shown_number(wavelength_nm_) +
                       " nm, and demodulated pictures have no mean; add even light");
    }
    if (d_.projector && !result_.relief) {
      throw InputError((d_.folder / file_name).string() + ": projector: no sinusoid at " +
                       shown_number(wavelength_nm_) +
                       " nm has three or more phases of sample and phantom, which show height");
    }
    return std::move(result_);
  }

 private:
  /// Even light as taken, else the mean of the first sinusoid, whose pictures these are.
  void add_even(const Pictures& first, const std::optional<Demodulated>& sample,
                const std::optional<Demodulated>& phantom, const Demodulated& one,
                const std::optional<Demodulated>& reference) {
    const bool has_mean = first.content == Content::light;
    if (!sample && !has_mean) return;
    const bool divided = sample && even_.front()->content == Content::ratio;
    // The phantom's mean under a sinusoid stands for even light that was not taken.
    std::optional<Demodulated> by = phantom;
    if (!by && !divided && has_mean) by = reference;
    if (!by && !divided && d_.reference) {
      throw InputError((d_.folder / file_name).string() + ": measurements: even light at " +
                       shown_number(first.wavelength_nm) +
                       " nm lacks the phantom's picture, and demodulated pictures have no mean; "
                       "name it");
    }
    add(0.0, sample ? *sample : one, by, &Demodulated::mean, &Demodulated::mean_deviation,
        &Demodulated::mean_detail);
  }

  /// The far side's pictures: its mean under even light, its amplitude under a sinusoid.
  void add_far() {
    for (const Pictures* p : far_) {
      const Demodulated one = read(*p, true, nullptr);
      std::optional<Demodulated> reference;
      if (!p->reference.empty()) reference = read(*p, false, nullptr);
      if (d_.reference && !reference && p->content != Content::ratio) {
        throw InputError((d_.folder / file_name).string() + ": measurements: the far side at " +
                         shown_number(wavelength_nm_) + " nm lacks the phantom's picture; name it");
      }
      const bool even = p->per_mm == 0.0;
      add(p->per_mm, one, reference, even ? &Demodulated::mean : &Demodulated::amplitude,
          even ? &Demodulated::mean_deviation : &Demodulated::amplitude_deviation,
          even ? &Demodulated::mean_detail : &Demodulated::amplitude_detail);
      result_.by_frequency.back().far = true;
    }
  }

  /// Notes how far the fringes lie from the phantom's, and takes the first ones' relief.
  void compare_phases(const Pictures& p, const Demodulated& s, const Demodulated& phantom,
                      LightCheck& check) {
    if (!s.phase.same_shape(phantom.phase)) return;  // divide() names the files
    Image<std::uint8_t> mask = s.mask;
    std::vector<double> shifts;
    for (std::size_t i = 0; i < mask.size(); ++i) {
      mask.values()[i] = mask.values()[i] & phantom.mask.values()[i];
      if (mask.values()[i] == 0) continue;
      const double turned = double{s.phase.values()[i]} - phantom.phase.values()[i];
      shifts.push_back(std::abs(std::remainder(turned, two_pi)) / (two_pi * p.per_mm));
    }
    if (shifts.empty()) return;
    check.shift_mm = median(std::move(shifts));
    if (!d_.projector || result_.relief) return;
    const double direction = p.direction_degrees.value_or(0.0) * std::numbers::pi / 180.0;
    result_.relief = calib::measure_relief(
        s.phase, phantom.phase, mask,
        {d_.projector->degrees, d_.projector->distance_mm, p.per_mm, direction}, d_.pixel_mm,
        relief_smoothing_mm / d_.pixel_mm);
  }

  void correct() {
    for (Ratio& ratio : result_.by_frequency) {
      for (std::size_t i = 0; i < ratio.value.size(); ++i) {
        const float irradiance = result_.relief->irradiance.values()[i];
        if (irradiance > 0.0F) {
          ratio.value.values()[i] /= irradiance;
        } else {
          ratio.mask.values()[i] = 0;  // the projector does not see it
        }
      }
    }
  }

  Demodulated read(const Pictures& p, bool sample, const Demodulated* even) {
    DemodulatedSet set = demodulate(d_, p, sample, even, reader_);
    if (sample) {
      checks_.push_back({p.per_mm,
                         set.found_per_mm,
                         set.light.second_harmonic,
                         set.light.stripes,
                         set.saturated,
                         {}});
    }
    return std::move(set.light);
  }

  void add(double per_mm, const Demodulated& s, const std::optional<Demodulated>& phantom,
           Image<float> Demodulated::*light, Image<float> Demodulated::*noise,
           Image<float> Demodulated::*detail) {
    Ratio ratio{per_mm, s.*light, s.*noise, s.*detail, s.mask, s.shared_pixels};
    for (std::size_t i = 0; i < ratio.value.size(); ++i) {
      const float value = ratio.value.values()[i];
      for (Image<float>* part : {&ratio.deviation, &ratio.detail}) {
        if (part->empty()) continue;
        float& deviation = part->values()[i];
        deviation = value > 0.0F ? deviation / value : 0.0F;
      }
    }
    if (phantom) divide(ratio, *phantom, light, noise);
    result_.by_frequency.push_back(std::move(ratio));
  }

  void divide(Ratio& ratio, const Demodulated& phantom, Image<float> Demodulated::*light,
              Image<float> Demodulated::*noise) const {
    const auto& box = d_.reference->region_px;
    if (box) {
      const double mean = box_mean(phantom.*light, phantom.mask, *box,
                                   (d_.folder / file_name).string() + ": reference.region_px");
      for (float& value : ratio.value.values()) value = static_cast<float>(value / mean);
      return;
    }
    if (!(phantom.*light).same_shape(ratio.value)) {
      throw InputError((d_.folder / file_name).string() +
                       ": the phantom's pictures have another size than the sample's; state "
                       "reference.region_px");
    }
    for (std::size_t i = 0; i < ratio.value.size(); ++i) {
      const float at = (phantom.*light).values()[i];
      std::uint8_t& mask = ratio.mask.values()[i];
      mask = mask & phantom.mask.values()[i] & static_cast<std::uint8_t>(at > 0.0F);
      if (mask == 0) continue;
      ratio.value.values()[i] /= at;
      ratio.deviation.values()[i] =
          std::hypot(ratio.deviation.values()[i], (phantom.*noise).values()[i] / at);
    }
  }

  const Description& d_;
  double wavelength_nm_;
  std::vector<LightCheck>& checks_;
  std::vector<const Pictures*> even_, sinusoids_, far_;
  PictureReader reader_;
  Ratios result_;
};

}  // namespace

Ratios measure_ratios(const Description& description, double wavelength_nm,
                      std::vector<LightCheck>& checks) {
  return Wavelength(description, wavelength_nm, checks).ratios();
}

}  // namespace kappamu::pipeline::sfdi
