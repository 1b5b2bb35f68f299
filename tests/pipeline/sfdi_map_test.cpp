// Maps from pictures that the forward model itself drew: the chain of description, demodulation,
// calibration and deviations. Real photographs are `kappamu-studies sfdi`.
#include "pipeline/sfdi/sfdi_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>

#include "core/random.h"
#include "forward/lateral/chromophores.h"
#include "forward/lateral/layered_transport.h"
#include "io/npy.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::pipeline::sfdi {
namespace {

constexpr int side = 96;
constexpr double pixel_mm = 0.3, frequency = 0.2, exposure = 500.0;

struct Sample {
  double mua = 0.0, musp = 0.0;
};
constexpr Sample phantom{0.02, 1.0}, tissue{0.035, 1.4};

/// Writes a picture under 1 + cos, with white noise of `noise` codes.
void draw(const std::filesystem::path& file, const Sample& sample, double degrees, double per_mm,
          double noise, std::uint64_t seed) {
  const forward::LateralReflectance model({1.4, 0.9, {}});
  const double even = exposure * model(0.0, sample.mua, sample.musp).reflectance;
  const double wave =
      per_mm > 0.0 ? exposure * model(per_mm, sample.mua, sample.musp).reflectance : 0.0;
  std::vector<float> values;
  for (std::uint64_t y = 0; y < side; ++y) {
    for (std::uint64_t x = 0; x < side; ++x) {
      const double phase =
          2.0 * std::numbers::pi * (per_mm * pixel_mm * static_cast<double>(x) + degrees / 360.0);
      // The light is darker to the left, for sample and phantom alike.
      const double shade = 0.8 + 0.2 * static_cast<double>(x) / side;
      const double white = std::sqrt(12.0) * (uniform(key_of({seed, x, y})) - 0.5);
      values.push_back(static_cast<float>(shade * (even + wave * std::cos(phase)) + noise * white));
    }
  }
  io::write_npy(file, {side, side}, std::span<const float>(values));
}

void write_pictures(const OwnFolder& folder, double noise, std::uint64_t seed) {
  for (const auto& [name, sample] : {std::pair{"t", tissue}, std::pair{"p", phantom}}) {
    for (const int degrees : {0, 120, 240}) {
      draw(folder / (name + std::to_string(degrees) + ".npy"), sample, degrees, frequency, noise,
           ++seed * 1000);
    }
    draw(folder / (std::string(name) + "even.npy"), sample, 0.0, 0.0, noise, ++seed * 1000);
  }
}

const std::string three_phases =
    R"({"wavelength_nm": 700, "per_mm": 0.2, "sample": ["t0.npy", "t120.npy", "t240.npy"],
        "reference": ["p0.npy", "p120.npy", "p240.npy"]})";
const std::string single =
    R"({"wavelength_nm": 700, "per_mm": 0, "sample": ["teven.npy"], "reference": ["peven.npy"]},
       {"wavelength_nm": 700, "per_mm": 0.2, "sample": ["t120.npy"], "reference": ["p0.npy"]})";
const std::string reference =
    R"("reference": {"coefficients": [
       {"wavelength_nm": 600, "absorption_per_mm": 0.03, "reduced_scattering_per_mm": 1.2,
        "relative_deviation": [0.03, 0.02]},
       {"wavelength_nm": 800, "absorption_per_mm": 0.01, "reduced_scattering_per_mm": 0.8,
        "relative_deviation": [0.03, 0.02]}]})";

Maps map(const OwnFolder& folder, const std::string& measurements,
         const std::string& scale = reference, const std::string& more = "") {
  std::ofstream(folder / file_name)
      << R"({"format": "kappamu-sfdi", "version": 1, "pixel_mm": 0.3, "smoothing_mm": 0, )" << more
      << R"("medium": {"refractive_index": 1.4, "anisotropy": 0.9}, "region_px": [20, 20, 56, 56], )"
      << scale << R"(, "measurements": [)" << measurements << "]}";
  Progress quiet;
  return measure_maps(read_description(folder), quiet);
}

TEST(SfdiMap, RecoversASampleByAPhantomBetweenItsWavelengths) {
  const OwnFolder folder;
  write_pictures(folder, 0.0, 1);
  for (const std::string& measurements : {three_phases, single}) {
    const Maps maps = map(folder, measurements);
    ASSERT_EQ(maps.wavelengths.size(), 1U);
    EXPECT_TRUE(maps.warnings.empty()) << maps.warnings.front();
    const RegionMean& region = *maps.wavelengths.front().region;
    EXPECT_EQ(region.pixels, 56U * 56U);
    constexpr double window = 3e-3;  // the shade's slope in a single picture's window
    EXPECT_NEAR(region.mean.mua / tissue.mua, 1.0, window);
    EXPECT_NEAR(region.mean.musp / tissue.musp, 1.0, window);
    // The phantom's deviation is most of it, and near its own.
    EXPECT_NEAR(region.deviation[1] / tissue.musp, 0.02, 0.01);
  }
}

TEST(SfdiMap, AbsoluteScaleNeedsNoPhantom) {
  const OwnFolder folder;
  write_pictures(folder, 0.0, 1);
  const std::string measurement =
      R"({"wavelength_nm": 700, "per_mm": 0.2, "sample": ["t0.npy", "t120.npy", "t240.npy"]})";
  const Maps maps = map(folder, measurement, R"("codes_per_reflectance": 500)");
  const WavelengthMap& m = maps.wavelengths.front();
  const int x = side - 1;  // where the shade is nearly 1
  EXPECT_NEAR(m.musp(x, 40) / tissue.musp, 1.0, 0.01);
  EXPECT_NEAR(m.kappa(x, 40), 1.0 / (3.0 * (m.mua(x, 40) + m.musp(x, 40))), 1e-6);
}

TEST(SfdiMap, NoiseDeviationsAreTheSpreadOverPixels) {
  const OwnFolder folder;
  write_pictures(folder, 1.5, 40);
  const std::string exact =
      R"("reference": {"coefficients": [{"wavelength_nm": 700, "absorption_per_mm": 0.02,
         "reduced_scattering_per_mm": 1.0}]})";
  const WavelengthMap m = map(folder, three_phases, exact).wavelengths.front();
  const RegionMean& region = *m.region;
  const auto noise = m.parts[static_cast<std::size_t>(Part::noise)];
  EXPECT_NEAR(region.spread[0] / (noise[0] * tissue.mua), 1.0, 0.15);
  EXPECT_NEAR(region.spread[1] / (noise[1] * tissue.musp), 1.0, 0.15);
}

/// A sample of haemoglobin, water and a law of scattering at four wavelengths, on an absolute
/// scale.
TEST(SfdiMap, SeveralWavelengthsGiveAmountsSaturationAndTheLawOfScattering) {
  const OwnFolder folder;
  constexpr double oxygenated = 45.0, without = 15.0, water = 0.6, at_500nm = 1.6, exponent = 1.1;
  std::string measurements;
  for (const int nm : {560, 660, 850, 970}) {
    const double mua = oxygenated * chromophore_absorption(Chromophore::hbo2, nm) +
                       without * chromophore_absorption(Chromophore::hb, nm) +
                       water * chromophore_absorption(Chromophore::water, nm);
    const Sample sample{mua, at_500nm * std::pow(nm / 500.0, -exponent)};
    std::string files;
    for (const int degrees : {0, 120, 240}) {
      const std::string name = std::to_string(nm) + "_" + std::to_string(degrees) + ".npy";
      draw(folder / name, sample, degrees, frequency, 0.0, 1);
      files += (files.empty() ? "\"" : ", \"") + name + "\"";
    }
    measurements += (measurements.empty() ? "" : ", ") + std::string(R"({"wavelength_nm": )") +
                    std::to_string(nm) + R"(, "per_mm": 0.2, "sample": [)" + files + "]}";
  }
  const std::string scale = R"("codes_per_reflectance": 500)";
  const Maps maps =
      map(folder, measurements, scale, R"("spectra": {"absorbers": ["hbo2", "hb", "water"]}, )");
  const int x = side - 1;  // where the shade is nearly 1
  const auto near = [&](const std::string& name, double truth, double relative) {
    const auto found = std::find_if(maps.spectral.begin(), maps.spectral.end(),
                                    [&](const SpectralMap& map) { return map.name == name; });
    ASSERT_NE(found, maps.spectral.end()) << name;
    EXPECT_NEAR(found->value(x, 40) / truth, 1.0, relative) << name;
  };
  near("hbo2", oxygenated, 0.03);
  near("hb", without, 0.03);
  near("water", water, 0.03);
  near("saturation", oxygenated / (oxygenated + without), 0.01);
  near("scattering_500nm", at_500nm, 0.02);
  near("scattering_exponent", exponent, 0.02);

  const auto refused = [&](const std::string& spectra, const std::string& part) {
    const std::string sentence =
        sentence_of([&] { map(folder, measurements, scale, R"("spectra": {)" + spectra + "}, "); });
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
    EXPECT_NE(sentence.find(file_name), std::string::npos) << sentence;
  };
  refused(R"("absorbers": ["hbo2", "gold"])", "'gold' is no absorber");
  refused(R"("absorbers": ["hbo2", "hbo2"])", "alike");
  refused(R"("absorbers": ["hbo2", "hb", "water", "fat", "melanin"])", "for 4 wavelengths");
  refused(R"("absorbers": ["../x"])", "small letters");
  std::ofstream(folder / "ink.csv") << "wavelength_nm,ink\n500,0.1\n900,0.2\n";
  refused(R"("absorbers": ["ink"], "file": "ink.csv")", "does not reach 970 nm");
}

/// A tilted, raised sample under a projector at 20 degrees, 300 mm away: heights by the fringes
/// take out what distance and angle do to its light.
TEST(SfdiMap, HeightAndTiltAreMeasuredAndCorrected) {
  const OwnFolder folder;
  constexpr double distance = 300.0, angle = 20.0 * std::numbers::pi / 180.0;
  const double px = distance * std::sin(angle), pz = distance * std::cos(angle);
  const forward::LateralReflectance model({1.4, 0.9, {}});
  const auto draw_at = [&](const std::string& name, const Sample& sample, double degrees,
                           double raised, double slope) {
    std::vector<float> values;
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const double u = (x - 0.5 * (side - 1)) * pixel_mm, v = (y - 0.5 * (side - 1)) * pixel_mm;
        const double h = raised + slope * u;
        // The ray from the projector through (u, v, h), on the plane.
        const auto on_plane = [&](double at) {
          const double z = raised + slope * at;
          return px + pz / (pz - z) * (at - px);
        };
        const double frequency_here =
            frequency * (on_plane(u + 0.01) - on_plane(u - 0.01)) / 0.02 / std::hypot(1.0, slope);
        const double to_u = px - u, up = pz - h;
        const double light = exposure * (up - slope * to_u) / std::hypot(1.0, slope) /
                             std::pow(std::hypot(to_u, v, up), 3.0) * distance * distance *
                             distance / pz;
        const double phase = 2.0 * std::numbers::pi * (frequency * on_plane(u) + degrees / 360.0);
        values.push_back(
            static_cast<float>(light * (model(0.0, sample.mua, sample.musp).reflectance +
                                        model(frequency_here, sample.mua, sample.musp).reflectance *
                                            std::cos(phase))));
      }
    }
    io::write_npy(folder / name, {side, side}, std::span<const float>(values));
  };
  for (const int degrees : {0, 120, 240}) {
    draw_at("t" + std::to_string(degrees) + ".npy", tissue, degrees, 5.0, 0.15);
    draw_at("p" + std::to_string(degrees) + ".npy", phantom, degrees, 0.0, 0.0);
  }
  const std::string exact =
      R"("reference": {"coefficients": [{"wavelength_nm": 700, "absorption_per_mm": 0.02,
         "reduced_scattering_per_mm": 1.0}]})";
  const Maps corrected =
      map(folder, three_phases, exact, R"("projector": {"degrees": 20, "distance_mm": 300}, )");
  EXPECT_TRUE(corrected.warnings.empty()) << corrected.warnings.front();
  const WavelengthMap& m = corrected.wavelengths.front();
  for (const int x : {20, 48, 75}) {
    EXPECT_NEAR(m.height_mm(x, 50), 5.0 + 0.15 * (x - 0.5 * (side - 1)) * pixel_mm, 0.02) << x;
    EXPECT_NEAR(m.mua(x, 50) / tissue.mua, 1.0, 0.02) << x;
    EXPECT_NEAR(m.musp(x, 50) / tissue.musp, 1.0, 0.02) << x;
  }
  const Maps flat = map(folder, three_phases, exact);
  ASSERT_EQ(flat.warnings.size(), 1U);
  EXPECT_NE(flat.warnings.front().find("higher or lower"), std::string::npos)
      << flat.warnings.front();
  EXPECT_GT(std::abs(flat.wavelengths.front().mua(48, 50) / tissue.mua - 1.0), 0.05);
  const std::string sentence = sentence_of([&] {
    map(folder, three_phases, exact, R"("projector": {"degrees": 0, "distance_mm": 300}, )");
  });
  EXPECT_NE(sentence.find("projector.degrees"), std::string::npos) << sentence;
}

TEST(SfdiMap, SaturatedPixelsAreLeftOutAndCounted) {
  const OwnFolder folder;
  write_pictures(folder, 0.0, 1);
  const Maps maps = map(folder, three_phases, reference, R"("largest_code": 260, )");
  const WavelengthMap& m = maps.wavelengths.front();
  EXPECT_GT(m.checks.front().saturated, 0U);
  for (std::size_t i = 0; i < m.mua.size(); ++i) {
    ASSERT_EQ(std::isfinite(m.mua.values()[i]), m.verdict.values()[i] == 0);
  }
  std::string all;
  for (const std::string& warning : maps.warnings) all += warning;
  EXPECT_NE(all.find("saturated pixels are left out"), std::string::npos) << all;
}

// Clipped at the top of eight bits, with nothing stated: crests that are cut off must not pass for
// light, nor for a projector that is not linear.
TEST(SfdiMap, CodesClippedAtTheTopOfTheirBitsAreSaturated) {
  const OwnFolder folder;
  write_pictures(folder, 0.0, 1);
  for (const char* name : {"t0", "t120", "t240"}) {
    io::NpyArray picture = io::read_npy(folder / (std::string(name) + ".npy"));
    for (float& value : picture.values) value = std::min(value, 255.0F);
    io::write_npy(folder / (std::string(name) + ".npy"), {side, side},
                  std::span<const float>(picture.values));
  }
  const Maps maps = map(folder, three_phases);
  EXPECT_GT(maps.wavelengths.front().checks.front().saturated, 100U);
  std::string all;
  for (const std::string& warning : maps.warnings) all += warning;
  EXPECT_NE(all.find("saturated pixels are left out"), std::string::npos) << all;
  EXPECT_EQ(all.find("not linear"), std::string::npos) << all;
}

TEST(SfdiMap, WhereNeighboursMatterItNamesTheFitThatTakesThemIntoAccount) {
  const OwnFolder folder;
  write_pictures(folder, 0.0, 1);
  const auto said = [&] {
    const Maps maps = map(folder, three_phases);
    return std::any_of(maps.warnings.begin(), maps.warnings.end(), [](const std::string& warning) {
      return warning.find("fit a volume") != std::string::npos &&
             warning.find("start_kappa") != std::string::npos &&
             warning.find("--") == std::string::npos;
    });
  };
  EXPECT_FALSE(said());
  // The left half of the sample absorbs and scatters as the phantom.
  for (const int degrees : {0, 120, 240}) {
    const std::string name = std::to_string(degrees) + ".npy";
    io::NpyArray sample = io::read_npy(folder / ("t" + name));
    const io::NpyArray other = io::read_npy(folder / ("p" + name));
    for (std::size_t i = 0; i < sample.values.size(); ++i) {
      if (i % side < side / 2) sample.values[i] = other.values[i];
    }
    io::write_npy(folder / ("t" + name), {side, side}, std::span<const float>(sample.values));
  }
  EXPECT_TRUE(said());
}

TEST(SfdiMap, RefusesInOneSentence) {
  const OwnFolder folder;
  write_pictures(folder, 0.0, 1);
  const auto refused = [&](const std::string& measurements, const std::string& scale,
                           const std::string& part) {
    const std::string sentence = sentence_of([&] { map(folder, measurements, scale); });
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
    EXPECT_NE(sentence.find(folder.path().string()), std::string::npos) << sentence;
  };
  const std::string even =
      R"({"wavelength_nm": 700, "per_mm": 0, "sample": ["teven.npy"], "reference": ["peven.npy"]})";
  refused(even, reference, "no sinusoid at 700 nm");
  refused(R"({"wavelength_nm": 900, "per_mm": 0.2, "sample": ["t0.npy"], "reference": ["p0.npy"]})",
          reference, "reach from 600 to 800 nm");
  refused(R"({"wavelength_nm": 700, "per_mm": 0.2, "sample": ["t0.npy"]})", reference,
          "measurements[0].reference is missing");
  refused(R"({"wavelength_nm": 700, "per_mm": 0.2, "sample": ["t0.npy", "t120.npy"],
             "reference": ["p0.npy"]})",
          reference, "two pictures");
  refused(
      R"({"wavelength_nm": 700, "per_mm": 0.2, "sample": ["none.npy"], "reference": ["p0.npy"]})",
      reference, "none.npy");
  refused(three_phases, reference + R"(, "codes_per_reflectance": 500)", "give one of them");
}

/// Demodulated pictures of two layers at six frequencies, the upper one's thickness stated alone.
TEST(SfdiMap, BothLayersAreFoundFromSeveralFrequencies) {
  const OwnFolder folder;
  const forward::LayeredTransport transport(1.4, 0.9);
  constexpr double endless = std::numeric_limits<double>::infinity();
  const Sample upper{0.06, 1.8}, lower{0.015, 1.0};
  const std::array<forward::TransportLayer, 2> layers{
      {{upper.mua, upper.musp, 1.5}, {lower.mua, lower.musp, endless}}};
  std::string measurements;
  int number = 0;
  for (const double f : {0.0, 0.02, 0.05, 0.1, 0.2, 0.4}) {
    const double light = exposure * transport(layers, f).reflectance;
    const std::vector<float> values(std::size_t{side} * side, static_cast<float>(light));
    const std::string name = std::to_string(number++) + ".npy";
    io::write_npy(folder / name, {side, side}, std::span<const float>(values));
    measurements += std::string(measurements.empty() ? "" : ", ") +
                    R"({"wavelength_nm": 700, "content": "demodulated", "per_mm": )" +
                    std::to_string(f) + R"(, "sample": [")" + name + R"("]})";
  }
  const auto measured = [&](const std::string& cover) {
    std::ofstream(folder / file_name)
        << R"({"format": "kappamu-sfdi", "version": 1, "pixel_mm": 0.3, "smoothing_mm": 0,
               "codes_per_reflectance": 500, "region_px": [20, 20, 56, 56],
               "errors": {"common": 0, "own": 0.003}, "medium": {"refractive_index": 1.4, "anisotropy": 0.9,
               "cover": {)"
        << cover << R"(}}, "measurements": [)" << measurements << "]}";
    Progress quiet;
    return measure_maps(read_description(folder), quiet);
  };
  const Maps maps = measured(R"("thickness_mm": 1.5)");
  const WavelengthMap& map = maps.wavelengths.front();
  ASSERT_TRUE(map.layers.has_value());
  const TwoLayers& found = *map.layers;
  EXPECT_TRUE(found.converged);
  const std::array<double, 4> off{
      std::log(found.upper.mua / upper.mua), std::log(found.upper.musp / upper.musp),
      std::log(found.lower.mua / lower.mua), std::log(found.lower.musp / lower.musp)};
  for (std::size_t i = 0; i < off.size(); ++i) {
    EXPECT_LT(std::abs(off[i]), found.relative_deviation[i]) << i;
    EXPECT_TRUE(found.determined[i]) << i << ": " << found.relative_deviation[i];
  }
  // The map is of the lower layer.
  EXPECT_NEAR(map.region->mean.mua / found.lower.mua, 1.0, 0.02);
  EXPECT_NEAR(map.region->mean.musp / found.lower.musp, 1.0, 0.02);
  measurements = measurements.substr(0, measurements.rfind(", {"));
  measurements = measurements.substr(0, measurements.rfind(", {"));
  measurements = measurements.substr(0, measurements.rfind(", {"));
  EXPECT_NE(sentence_of([&] {
              measured(R"("thickness_mm": 1.5)");
            }).find("both layers need four spatial frequencies; there are 3"),
            std::string::npos);
}

}  // namespace
}  // namespace kappamu::pipeline::sfdi
