#include "data_synthetic/score.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/calibration_file.h"
#include "core/appearance_error.h"
#include "core/error.h"
#include "core/numbers/gaussian_sum.h"
#include "core/numbers/median.h"
#include "core/processor_time.h"
#include "data_synthetic/transport.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/json_node.h"
#include "io/npy.h"
#include "io/volume/npy_volume.h"

namespace kappamu::synthetic {

namespace {

constexpr int score_refinement =
    2;  // cells per fitted voxel and side when a run's volumes are solved

/// Relative errors of one coefficient, median by layer; appends all of them to `all`.
std::vector<double> errors_by_depth(const Volume<double>& found, const Volume<double>& truth,
                                    Face lit_face, std::vector<double>& all) {
  const GridShape& grid = truth.shape();
  const FaceShape face = face_shape(grid, lit_face);
  std::vector<double> layers;
  for (int depth = 0; depth < grid.extent(axis_of(lit_face)); ++depth) {
    std::vector<double> errors;
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const std::size_t cell = face_cell(grid, lit_face, u, v, depth);
        errors.push_back(std::abs(found[cell] / truth[cell] - 1.0));
      }
    }
    all.insert(all.end(), errors.begin(), errors.end());
    layers.push_back(upper_median(std::move(errors)));
  }
  return layers;
}

/// What the run states of one channel.
struct Stated {
  Volume<double> std_kappa, std_mu;               ///< of the values
  std::vector<double> kappa_fwhm_mm, mu_fwhm_mm;  ///< from the seen face on
};

/// Empty where the run was fitted without deviations.
std::optional<Stated> read_stated(const std::filesystem::path& fit, const std::string& channel,
                                  const GridShape& grid) {
  const auto file = [&](const char* of) { return fit / (of + channel + ".npy"); };
  if (!std::filesystem::exists(file("std_kappa_"))) return std::nullopt;
  Stated stated{io::read_npy_volume(file("std_kappa_"), grid),
                io::read_npy_volume(file("std_mu_"), grid),
                {},
                {}};
  const io::JsonDocument report(fit / "fit.json", "fit again");
  for (const io::JsonNode& of : report.root()["channels"].items(1)) {
    if (of["name"].text() != channel) continue;
    for (const io::JsonNode& layer : of["uncertainty"]["layers"].items(1)) {
      stated.kappa_fwhm_mm.push_back(layer["kappa_fwhm_mm"].number());
      stated.mu_fwhm_mm.push_back(layer["mu_fwhm_mm"].number());
    }
  }
  return stated;
}

/// `deviation`: stated of `found` itself, as a mean over `fwhm_mm`.
Coverage coverage_of(const Volume<double>& found, const Volume<double>& true_values,
                     Volume<double> deviation, const std::vector<double>& fwhm_mm,
                     const Truth& truth) {
  for (std::size_t i = 0; i < found.size(); ++i) deviation[i] /= found[i];
  return coverage(found, resolved(true_values, truth.seen_face, fwhm_mm), deviation,
                  truth.lit_face);
}

void score_hdr(const std::filesystem::path& run, const Truth& truth,
               const std::filesystem::path& truth_folder, Score& score) {
  std::vector<double> all;
  std::size_t on_sample = 0;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(truth_folder / "radiance")) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files) {
    const std::filesystem::path found_file = run / "hdr" / file.filename();
    if (!std::filesystem::exists(found_file)) continue;
    const Image<float> expected = io::read_float_image(file);
    std::vector<double> errors;
    const auto open = [&](const io::ExrHeader& header) -> io::TakeExrRows {
      const auto channel = [&](const std::string& name) {
        const auto at = std::find(header.channels.begin(), header.channels.end(), name);
        if (at != header.channels.end()) {
          return static_cast<std::size_t>(at - header.channels.begin());
        }
        throw InputError(found_file.string() + ": channel " + truth.channels.front() +
                         " or its flags are missing; make the file again with `kappamu merge`");
      };
      std::vector<std::array<std::size_t, 2>> places;  // of value and flags
      for (const std::string& name : truth.channels) {
        places.push_back({channel(name), channel("flags." + name)});
      }
      return [&, places, data = header.data, stored = header.channels.size()](int first, int rows,
                                                                              const float* values) {
        for (int k = 0; k < rows * data.width; ++k, values += stored) {
          const int x = data.left + k % data.width, y = data.top + first + k / data.width;
          for (std::size_t c = 0; c < places.size(); ++c) {
            const double true_value = expected(x, y, static_cast<int>(c));
            if (true_value <= 0.0) continue;  // beside the sample
            ++on_sample;
            if (values[places[c][1]] != 0.0F) continue;
            errors.push_back(std::abs(values[places[c][0]] / true_value - 1.0));
          }
        }
      };
    };
    io::read_exr_rows(found_file, open, [&](const io::ImageSize& size) {
      if (size.width == expected.width() && size.height == expected.height()) return;
      throw InputError(found_file.string() + ": is not of the size of " + file.string() +
                       "; is this the run of that simulation?");
    });
    all.insert(all.end(), errors.begin(), errors.end());
    if (!errors.empty()) {
      score.hdr_relative_error_by_pattern[file.stem().string()] = upper_median(std::move(errors));
    }
  }
  if (all.empty()) return;
  score.hdr_valid_fraction = static_cast<double>(all.size()) / static_cast<double>(on_sample);
  score.hdr_relative_error_median = upper_median(std::move(all));
}

void score_coefficients(const std::vector<Medium>& media, const Truth& truth,
                        const std::filesystem::path& run, const std::filesystem::path& truth_folder,
                        Score& score) {
  std::vector<double> kappa_errors;
  std::vector<double> mu_errors;
  for (std::size_t c = 0; c < truth.channels.size(); ++c) {
    const std::string& name = truth.channels[c];
    const auto [kappa, mu] = true_medium(truth, truth_folder, name);
    score.kappa_relative_error_by_depth[name] =
        errors_by_depth(media[c].kappa, kappa, truth.lit_face, kappa_errors);
    score.mu_relative_error_by_depth[name] =
        errors_by_depth(media[c].mu, mu, truth.lit_face, mu_errors);
    const std::optional<Stated> stated = read_stated(run / "fit", name, truth.grid);
    if (!stated) continue;
    score.kappa_coverage[name] =
        coverage_of(media[c].kappa, kappa, stated->std_kappa, stated->kappa_fwhm_mm, truth);
    score.mu_coverage[name] =
        coverage_of(media[c].mu, mu, stated->std_mu, stated->mu_fwhm_mm, truth);
  }
  score.kappa_relative_error = upper_median(std::move(kappa_errors));
  score.mu_relative_error = upper_median(std::move(mu_errors));
}

}  // namespace

Volume<double> average_volume(const Volume<double>& fine, const GridShape& coarse) {
  const int factor = fine.shape().nx / coarse.nx;
  Volume<double> out(coarse);
  const double weight = 1.0 / (factor * factor * factor);
  for (int z = 0; z < fine.shape().nz; ++z) {
    for (int y = 0; y < fine.shape().ny; ++y) {
      for (int x = 0; x < fine.shape().nx; ++x) {
        out(x / factor, y / factor, z / factor) += weight * fine(x, y, z);
      }
    }
  }
  return out;
}

Volume<double> resolved(Volume<double> truth, Face seen, const std::vector<double>& fwhm_mm) {
  if (fwhm_mm.empty()) return truth;
  for (double& value : truth.values()) value = std::log(value);
  truth = gaussian_means(truth, seen, fwhm_mm);
  for (double& value : truth.values()) value = std::exp(value);
  return truth;
}

Coverage coverage(const Volume<double>& found, const Volume<double>& truth,
                  const Volume<double>& log_deviation, Face lit_face) {
  const GridShape& grid = truth.shape();
  const FaceShape face = face_shape(grid, lit_face);
  Coverage result;
  std::vector<double> z;
  double all = 0.0;
  for (int depth = 0; depth < grid.extent(axis_of(lit_face)); ++depth) {
    double within = 0.0;
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const std::size_t cell = face_cell(grid, lit_face, u, v, depth);
        z.push_back(std::abs(std::log(found[cell] / truth[cell])) / log_deviation[cell]);
        within += z.back() <= 2.0 ? 1.0 : 0.0;
      }
    }
    result.within_two_by_depth.push_back(within / static_cast<double>(face.cells()));
    all += within;
  }
  result.within_two = all / static_cast<double>(grid.cells());
  result.median = upper_median(std::move(z));
  return result;
}

Medium true_medium(const Truth& truth, const std::filesystem::path& truth_folder,
                   const std::string& channel) {
  const auto volume = [&](const std::string& what) {
    return average_volume(
        io::read_npy_volume(
            truth_folder / std::string(what).append("_").append(channel).append(".npy"),
            truth.transport_grid),
        truth.grid);
  };
  return {volume("kappa"), volume("mu")};
}

double truth_error(const std::vector<Medium>& media, const Truth& truth,
                   const std::filesystem::path& truth_folder, const std::string& device,
                   Progress& progress, std::map<std::string, double>* by_channel) {
  const FaceShape lit = face_shape(truth.grid, truth.lit_face);
  const FaceShape seen = face_shape(truth.grid, truth.seen_face);
  const auto size = [](int value) { return static_cast<std::size_t>(value); };
  const std::size_t patterns = size(truth.holdout * truth.holdout);
  const io::NpyArray light =
      io::read_npy(truth_folder / "holdout_irradiance.npy", {patterns, size(lit.nv), size(lit.nu)});
  const io::NpyArray expected =
      io::read_npy(truth_folder / "holdout_exitance.npy",
                   {truth.channels.size(), patterns, size(seen.nv), size(seen.nu)});
  const std::vector<double> irradiance = split_cells(
      std::vector<double>(light.values.begin(), light.values.end()), lit, score_refinement);

  const GridShape fine = truth.grid.refined(score_refinement);
  Transport transport({fine, truth.eta, truth.lit_face, truth.sides}, device);
  if (!transport.warning().empty()) progress.warn(transport.warning());
  const bool lit_is_seen = truth.lit_face == truth.seen_face;
  AppearanceError all;
  for (std::size_t c = 0; c < truth.channels.size(); ++c) {
    transport.set_medium({split_cells(media[c].kappa, score_refinement),
                          split_cells(media[c].mu, score_refinement)});
    const std::vector<double> found = average_cells(
        transport.exitance(irradiance, truth.seen_face,
                           [&](double fraction) {
                             progress.update("held-out light",
                                             (static_cast<double>(c) + fraction) /
                                                 static_cast<double>(truth.channels.size()),
                                             truth.channels[c]);
                           }),
        face_shape(fine, truth.seen_face), score_refinement);
    AppearanceError error;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (lit_is_seen && light.values[i] > 0.0F) continue;
      error.add(found[i], expected.values[c * found.size() + i]);
    }
    if (by_channel != nullptr) (*by_channel)[truth.channels[c]] = error.E();
    all.add(error);
  }
  return all.E();
}

Score score_run(const std::filesystem::path& run, const std::filesystem::path& truth_folder,
                const std::string& device, Progress& progress) {
  const Stopwatch watch;
  const Truth truth = read_truth(truth_folder);
  Score score;
  score.channels = truth.channels;
  const bool has_hdr = std::filesystem::is_directory(run / "hdr");
  const bool has_fit =
      std::filesystem::exists(run / "fit" / ("kappa_" + truth.channels.front() + ".npy"));
  const bool has_calibration = std::filesystem::exists(run / "calibration" / "calibration.json");
  if (!has_hdr && !has_fit && !has_calibration) {
    throw InputError(run.string() +
                     ": has neither calibration/ nor hdr/ nor fit/; score a folder "
                     "that `kappamu run` has made");
  }
  if (has_hdr) score_hdr(run, truth, truth_folder, score);
  if (has_calibration) {
    score.calibration = calibration_errors(calib::load_calibration(run / "calibration"), truth);
  }
  if (has_fit) {
    std::vector<Medium> media;
    for (const std::string& name : truth.channels) {
      media.push_back({io::read_npy_volume(run / "fit" / ("kappa_" + name + ".npy"), truth.grid),
                       io::read_npy_volume(run / "fit" / ("mu_" + name + ".npy"), truth.grid)});
      validate(media.back(), (run / "fit").string());
    }
    score_coefficients(media, truth, run, truth_folder, score);
    if (truth.holdout > 0) {
      score.truth_E =
          truth_error(media, truth, truth_folder, device, progress, &score.truth_E_by_channel);
    }
  }
  score.seconds = watch.seconds();
  return score;
}

}  // namespace kappamu::synthetic
