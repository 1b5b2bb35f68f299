#include "pipeline/sfdi/sfdi_file.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/lateral/lateral_reflectance.h"
#include "io/json_fields.h"
#include "pipeline/sfdi/picture_names.h"
#include "pipeline/sfdi/sfdi_series.h"
#include "pipeline/sfdi/sfdi_spectra.h"

namespace kappamu::pipeline::sfdi {

namespace {

constexpr const char* format_name = "kappamu-sfdi";

}  // namespace

template <class Fields>
void describe(Fields& fields, PhantomRow& r) {
  fields("wavelength_nm", r.wavelength_nm);
  fields("absorption_per_mm", r.absorption_per_mm);
  fields("reduced_scattering_per_mm", r.reduced_scattering_per_mm);
  fields("relative_deviation", r.relative_deviation);
}

template <class Fields>
void describe(Fields& fields, Layer& l) {
  fields.optional("coefficients", l.coefficients);
  fields("thickness_mm", l.thickness_mm);
}

template <class Fields>
void describe(Fields& fields, Medium& m) {
  fields("refractive_index", m.refractive_index);
  fields("refractive_index_deviation", m.refractive_index_deviation);
  fields("anisotropy", m.anisotropy);
  fields("anisotropy_deviation", m.anisotropy_deviation);
  fields("thickness_mm", m.thickness_mm);
  fields("slide_index", m.slide_index);
  fields("cover", m.cover);
  fields("base", m.base);
}

template <class Fields>
void describe(Fields& fields, Reference& r) {
  fields("coefficients", r.coefficients);
  fields("region_px", r.region_px);
  fields("thickness_mm", r.thickness_mm);
}

template <class Fields>
void describe(Fields& fields, Errors& e) {
  fields("common", e.common);
  fields("own", e.own);
}

template <class Fields>
void describe(Fields& fields, Spectra& s) {
  fields("absorbers", s.absorbers);
  fields.optional("file", s.file);
}

template <class Fields>
void describe(Fields& fields, ProjectorPlace& p) {
  fields("degrees", p.degrees);
  fields("distance_mm", p.distance_mm);
}

template <class Fields>
void describe(Fields& fields, Pictures& p) {
  fields("wavelength_nm", p.wavelength_nm);
  fields("per_mm", p.per_mm);
  fields("direction_degrees", p.direction_degrees);
  fields("sample", p.sample);
  fields.optional("reference", p.reference);
  fields.optional("phases_degrees", p.phases_degrees);
  fields("dark", p.dark);
  fields("repeats", p.repeats);
  fields.kind("content", p.content, content_names, Content::light);
  fields.kind("side", p.side, side_names, Side::near);
}

template <class Fields>
void describe(Fields& fields, Series& s) {
  fields("sample", s.sample);
  fields.optional("reference", s.reference);
  fields.optional("dark", s.dark);
  fields("wavelengths_nm", s.wavelengths_nm);
  fields("per_mm", s.per_mm);
  fields.optional("phases_degrees", s.phases_degrees);
  fields("first_number", s.first_number);
  fields("direction_degrees", s.direction_degrees);
  fields("repeats", s.repeats);
  fields.kind("content", s.content, content_names, Content::light);
  fields.kind("side", s.side, side_names, Side::near);
}

template <class Fields>
void describe(Fields& fields, Description& d) {
  fields.format(format_name);
  fields("pixel_mm", d.pixel_mm);
  fields("smoothing_mm", d.smoothing_mm);
  fields.optional("channel", d.channel);
  fields("crop_px", d.crop_px);
  fields("region_px", d.region_px);
  fields("largest_code", d.largest_code);
  fields("codes_per_reflectance", d.codes_per_reflectance);
  fields("medium", d.medium);
  fields("reference", d.reference);
  fields("errors", d.errors);
  fields("spectra", d.spectra);
  fields("projector", d.projector);
  fields("series", d.series);
  fields.optional("measurements", d.measurements);
}

namespace {

class Checks {
 public:
  explicit Checks(std::string file) : file_(std::move(file)) {}

  void require(bool holds, const std::string& field, const std::string& fix) const {
    if (!holds) throw InputError(file_ + ": " + field + " " + fix);
  }
  void positive(double value, const std::string& field) const {
    require(std::isfinite(value) && value > 0.0, field,
            "is " + shown_number(value) + "; it is a number above 0");
  }
  void share(double value, const std::string& field) const {
    require(value >= 0.0 && value < 1.0, field,
            "is " + shown_number(value) + "; it is a relative deviation, 0 to 1");
  }
  void box(const std::optional<std::array<int, 4>>& b, const std::string& field) const {
    require(!b || ((*b)[0] >= 0 && (*b)[1] >= 0 && (*b)[2] > 0 && (*b)[3] > 0), field,
            "is no box of pixels: x, y, width, height");
  }

 private:
  std::string file_;
};

void check_coefficients(const Checks& checks, const std::vector<PhantomRow>& coefficients,
                        const std::string& of) {
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    const PhantomRow& row = coefficients[i];
    const std::string field = of + ".coefficients[" + std::to_string(i) + "].";
    checks.positive(row.wavelength_nm, field + "wavelength_nm");
    checks.positive(row.absorption_per_mm, field + "absorption_per_mm");
    checks.positive(row.reduced_scattering_per_mm, field + "reduced_scattering_per_mm");
    if (row.relative_deviation) {
      for (const double one : *row.relative_deviation) {
        checks.share(one, field + "relative_deviation");
      }
    }
  }
}

void check_reference(const Checks& checks, const Reference& reference) {
  check_coefficients(checks, reference.coefficients, "reference");
  checks.box(reference.region_px, "reference.region_px");
}

void check_layers(const Checks& checks, const Medium& medium) {
  if (medium.cover) {
    check_coefficients(checks, medium.cover->coefficients, "medium.cover");
    checks.require(medium.cover->thickness_mm.has_value(), "medium.cover.thickness_mm",
                   "is missing; state how thick the upper layer is");
    checks.positive(*medium.cover->thickness_mm, "medium.cover.thickness_mm");
    checks.require(!medium.base && !medium.thickness_mm, "medium.cover",
                   "lies over a half-space; leave out base and medium.thickness_mm");
  }
  if (medium.base) {
    checks.require(!medium.base->coefficients.empty(), "medium.base.coefficients",
                   "are missing; a half-space under the sample is known");
    check_coefficients(checks, medium.base->coefficients, "medium.base");
    checks.require(!medium.base->thickness_mm, "medium.base.thickness_mm",
                   "is there; the known half-space has none");
    checks.require(medium.thickness_mm.has_value(), "medium.thickness_mm",
                   "is missing; state how thick the layer over base is");
  }
}

void check_pictures(const Checks& checks, const Description& d, std::size_t index) {
  const Pictures& p = d.measurements[index];
  const std::string field = "measurements[" + std::to_string(index) + "].";
  checks.positive(p.wavelength_nm, field + "wavelength_nm");
  checks.require(p.per_mm >= 0.0 && p.per_mm * d.pixel_mm < 0.25, field + "per_mm",
                 "is " + shown_number(p.per_mm) +
                     "; a period needs more than four pixels, and even light is 0");
  const bool ratio = p.content == Content::ratio;
  checks.require(!ratio || d.reference, field + "content",
                 "is \"ratio\", sample over phantom; \"reference\" would state the phantom's "
                 "coefficients (of reflectances write \"demodulated\" and codes_per_reflectance)");
  checks.require(!ratio || p.reference.empty(), field + "reference",
                 "names pictures of a phantom, by which a ratio is divided already");
  checks.require(ratio || !d.reference || !p.reference.empty() || p.per_mm == 0.0,
                 field + "reference",
                 "is missing; name the phantom's pictures under the same light");
  checks.require(d.reference || p.reference.empty(), field + "reference",
                 "names pictures of a phantom, whose coefficients \"reference\" would state");
  checks.require(p.side == Side::near || (d.medium.thickness_mm && !d.medium.base), field + "side",
                 "is \"far\", and light shines through slabs alone; state medium.thickness_mm");
  checks.require(p.side == Side::near || !d.reference || d.reference->thickness_mm,
                 "reference.thickness_mm", "is missing; light shines through the phantom as well");
  const int repeats = p.repeats.value_or(1);
  checks.require(repeats >= 1, field + "repeats",
                 "is " + std::to_string(repeats) + "; it is a number of pictures, 1 or more");
  for (const auto* files : {&p.sample, &p.reference}) {
    const std::string which = field + (files == &p.sample ? "sample" : "reference");
    checks.require(files->size() % static_cast<std::size_t>(repeats) == 0, which,
                   "has " + std::to_string(files->size()) + " pictures, no multiple of repeats, " +
                       std::to_string(repeats));
    const std::size_t phases = files->size() / static_cast<std::size_t>(repeats);
    checks.require(p.content == Content::light || phases <= 1, which,
                   "has several pictures of a content that is one picture");
    if (p.per_mm == 0.0) continue;  // their mean is taken
    checks.require(phases != 2, which,
                   "has two pictures; one, or three and more phases, can be demodulated");
    checks.require(p.phases_degrees.empty() || phases <= 1 || phases == p.phases_degrees.size(),
                   which, "has another number of pictures than phases_degrees");
  }
}

/// Four unknowns need four lights at each wavelength.
void check_unknown_layers(const Checks& checks, const Description& d) {
  constexpr std::size_t unknowns = 4;
  checks.require(!d.projector, "medium.cover.coefficients",
                 "are missing, and both layers are found on flat samples alone; leave out "
                 "projector, or state the upper layer");
  for (const Pictures& p : d.measurements) {
    std::set<double> lights;
    for (const Pictures& other : d.measurements) {
      if (other.wavelength_nm == p.wavelength_nm) lights.insert(other.per_mm);
    }
    checks.require(lights.size() >= unknowns, "medium.cover.coefficients",
                   "are missing, and both layers need four spatial frequencies; there are " +
                       std::to_string(lights.size()) + " at " + shown_number(p.wavelength_nm) +
                       " nm");
  }
}

void check_projector(const Checks& checks, const Description& d) {
  checks.positive(d.projector->distance_mm, "projector.distance_mm");
  const double degrees = std::abs(d.projector->degrees);
  checks.require(degrees >= 1.0 && degrees < 80.0, "projector.degrees",
                 "is " + shown_number(d.projector->degrees) +
                     "; it is an angle from 1 to 80 degrees, or -1 to -80 against the sinusoid's "
                     "direction");
  checks.require(d.reference && !d.reference->region_px, "projector",
                 "needs the phantom's pictures pixel by pixel, as the plane that heights count "
                 "from; state reference without region_px");
}

}  // namespace

Description read_description(const std::filesystem::path& folder_or_file) {
  const std::filesystem::path file =
      std::filesystem::is_directory(folder_or_file) ? folder_or_file / file_name : folder_or_file;
  const io::JsonDocument document(file, "docs/sfdi.md");
  Description d;
  const io::JsonNode root = document.root();
  io::FieldNames names(root);
  describe(names, d);
  names.expect();
  io::FieldReader reader(root);
  describe(reader, d);
  d.folder = file.parent_path();

  const Checks checks(file.string());
  checks.positive(d.pixel_mm, "pixel_mm");
  checks.require(!d.smoothing_mm || (*d.smoothing_mm >= 0.0 && *d.smoothing_mm < 100.0),
                 "smoothing_mm", "is a length from 0 to 100 mm");
  checks.require(d.channel.empty() || d.channel == "R" || d.channel == "G" || d.channel == "B",
                 "channel", "is '" + shown_name(d.channel) + "'; choose R, G or B");
  checks.box(d.crop_px, "crop_px");
  checks.box(d.region_px, "region_px");
  if (d.medium.refractive_index_deviation) {
    checks.share(*d.medium.refractive_index_deviation, "medium.refractive_index_deviation");
  }
  if (d.medium.anisotropy_deviation) {
    checks.share(*d.medium.anisotropy_deviation, "medium.anisotropy_deviation");
  }
  check_layers(checks, d.medium);
  try {
    const forward::LateralReflectance model({d.medium.refractive_index, d.medium.anisotropy,
                                             d.medium.thickness_mm, d.medium.slide_index});
  } catch (const InputError& error) {
    checks.require(false, "medium:", error.what());
  }
  checks.require(d.reference.has_value() != d.codes_per_reflectance.has_value(), "reference",
                 "or codes_per_reflectance states the scale of the pictures; give one of them");
  if (d.reference) check_reference(checks, *d.reference);
  if (d.codes_per_reflectance) checks.positive(*d.codes_per_reflectance, "codes_per_reflectance");
  if (d.errors) {
    checks.share(d.errors->common, "errors.common");
    checks.share(d.errors->own, "errors.own");
  }
  if (d.series) {
    for (Pictures& p : pictures_of(*d.series, d.folder, file.string())) {
      d.measurements.push_back(std::move(p));
    }
  }
  checks.require(!d.measurements.empty(), "measurements",
                 "is missing; name the pictures there, or the rule of their names in series");
  for (Pictures& p : d.measurements) {
    for (auto* files : {&p.sample, &p.reference}) {
      std::vector<std::string> all;
      for (const std::string& name : *files) {
        for (std::string& one : pictures_named(d.folder, name)) all.push_back(std::move(one));
      }
      *files = std::move(all);
    }
  }
  for (std::size_t i = 0; i < d.measurements.size(); ++i) check_pictures(checks, d, i);
  if (d.projector) check_projector(checks, d);
  if (d.medium.cover && d.medium.cover->coefficients.empty()) check_unknown_layers(checks, d);
  for (const Pictures& p : d.measurements) {
    // Reflectance and transmittance under even light tell as much as a sinusoid.
    checks.require(std::any_of(d.measurements.begin(), d.measurements.end(),
                               [&](const Pictures& other) {
                                 return other.wavelength_nm == p.wavelength_nm &&
                                        (other.per_mm > 0.0 || other.side != p.side);
                               }),
                   "measurements",
                   "has no sinusoid at " + shown_number(p.wavelength_nm) +
                       " nm; even light alone does not tell absorption from "
                       "scattering");
    checks.require(
        std::any_of(d.measurements.begin(), d.measurements.end(),
                    [&](const Pictures& other) {
                      return other.wavelength_nm == p.wavelength_nm && other.side == Side::near;
                    }),
        "measurements",
        "has no picture of the lit side at " + shown_number(p.wavelength_nm) + " nm; add one");
  }
  check_spectra(d);
  return d;
}

}  // namespace kappamu::pipeline::sfdi
