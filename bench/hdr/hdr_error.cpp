#include "bench/hdr/hdr_error.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/photo.hpp>
#include <sstream>

#include "capture/radiance/merge.h"
#include "data_synthetic/rig/sensor.h"
#include "io/atomic_file.h"
#include "io/image/image_file.h"

namespace kappamu::bench {
namespace {

constexpr double shortest_s = 1.0 / 30.0;
constexpr double longest_s = 8.0;
constexpr double darkest = 0.002;  // full scales per second
constexpr double brightest = 20.0;
constexpr double near_saturation = 0.9;

struct Bracket {
  std::vector<capture::ExposedFrame> frames;
  std::vector<cv::Mat> images;
  std::vector<float> times;
};

Image<float> ramp(const HdrErrorOptions& options) {
  Image<float> scene(options.width, options.height, 3);
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const double share = (x + 0.5) / options.width;
      for (int c = 0; c < 3; ++c) {
        scene(x, y, c) = static_cast<float>(darkest * std::pow(brightest / darkest, share));
      }
    }
  }
  return scene;
}

Bracket shoot(const synthetic::SensorModel& sensor, const Image<float>& scene, int exposures) {
  Bracket bracket;
  for (int i = 0; i < exposures; ++i) {
    const double t =
        shortest_s * std::pow(longest_s / shortest_s, static_cast<double>(i) / (exposures - 1));
    const auto number = static_cast<std::uint64_t>(100 * exposures + i);
    bracket.frames.push_back({synthetic::expose(sensor, scene, t, number, 1), t});
    const Image<std::uint16_t>& codes = bracket.frames.back().pixels;
    cv::Mat image(codes.height(), codes.width(), CV_8UC3);
    for (std::size_t k = 0; k < codes.size(); ++k) {
      image.data[k] = static_cast<unsigned char>(codes.values()[k]);
    }
    bracket.images.push_back(image);
    bracket.times.push_back(static_cast<float>(t));
  }
  return bracket;
}

// The inverse of the sensor's curve by bisection.
capture::Radiometry true_radiometry(const synthetic::SensorModel& sensor) {
  capture::Radiometry radiometry;
  radiometry.bit_depth = sensor.bit_depth;
  const int top = (1 << sensor.bit_depth) - 1;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> linear;
    for (int code = 0; code <= top; ++code) {
      double low = 0.0;
      double high = 1.0;
      for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        (synthetic::encode(sensor, middle, c) * top < code ? low : high) = middle;
      }
      linear.push_back(code == top ? 1.0 : 0.5 * (low + high));
    }
    radiometry.response.linear.push_back(std::move(linear));
    radiometry.black_level.push_back(0.0);
    radiometry.noise.push_back({sensor.electrons_full_scale, sensor.read_noise_electrons, false});
  }
  return radiometry;
}

cv::Mat opencv_response(const capture::Radiometry& radiometry) {
  cv::Mat response(256, 1, CV_32FC3);
  for (int code = 0; code < 256; ++code) {
    for (int c = 0; c < 3; ++c) {
      const auto& linear = radiometry.response.linear[static_cast<std::size_t>(c)];
      // OpenCV takes its logarithm.
      response.at<cv::Vec3f>(code, 0)[c] =
          static_cast<float>(std::max(linear[static_cast<std::size_t>(code)], 1e-6));
    }
  }
  return response;
}

void write_frames(const Bracket& bracket, const std::filesystem::path& folder) {
  for (std::size_t i = 0; i < bracket.frames.size(); ++i) {
    const Image<std::uint16_t>& codes = bracket.frames[i].pixels;
    Image<std::uint8_t> image(codes.width(), codes.height(), codes.channels());
    std::transform(codes.values().begin(), codes.values().end(), image.values().begin(),
                   [](std::uint16_t code) { return static_cast<std::uint8_t>(code); });
    io::write_image(
        folder / (std::to_string(bracket.frames.size()) + "_" + std::to_string(i) + ".png"), image);
  }
}

void write_response(const capture::Radiometry& radiometry, const std::filesystem::path& file) {
  std::ostringstream text;
  text.precision(9);
  const auto& linear = radiometry.response.linear;
  for (std::size_t code = 0; code < linear[0].size(); ++code) {
    text << linear[0][code] << ' ' << linear[1][code] << ' ' << linear[2][code] << '\n';
  }
  io::write_text_atomically(file, text.str());
}

std::vector<float> values_of(const cv::Mat& merged) {
  const auto* first = merged.ptr<float>(0);
  return {first, first + merged.total() * 3};
}

void score(const std::vector<float>& found, const Image<float>& truth, HdrErrorRow& row) {
  std::vector<double> ratios;
  std::vector<double> dark;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double radiance = truth.values()[i];
    if (radiance * shortest_s > near_saturation) continue;
    ratios.push_back(found[i] / radiance);
    if (radiance < 10.0 * darkest) dark.push_back(ratios.back());
  }
  const double scale = median(ratios);
  const auto rms = [scale](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += (value / scale - 1.0) * (value / scale - 1.0);
    return std::sqrt(sum / static_cast<double>(values.size()));
  };
  row.relative_rms = rms(ratios);
  row.dark_rms = rms(dark);
}

}  // namespace

std::vector<HdrErrorRow> compare_hdr_merges(const HdrErrorOptions& options, Progress& progress) {
  synthetic::SensorModel sensor;
  sensor.bit_depth = 8;
  sensor.black_level = 0.0;  // the papers and OpenCV know of no pedestal
  sensor.seed = options.seed;
  const capture::Radiometry radiometry = true_radiometry(sensor);
  const cv::Mat response = opencv_response(radiometry);
  const Image<float> scene = ramp(options);
  if (options.frames) {
    std::filesystem::create_directories(*options.frames);
    write_response(radiometry, *options.frames / "response.txt");
  }
  std::vector<HdrErrorRow> rows;
  for (int exposures = options.fewest; exposures <= options.most; ++exposures) {
    progress.update(
        "bench hdr",
        static_cast<double>(exposures - options.fewest) / (options.most - options.fewest + 1),
        std::to_string(exposures) + " exposures");
    const Bracket bracket = shoot(sensor, scene, exposures);
    if (options.frames) write_frames(bracket, *options.frames);
    const auto ours = [&] {
      return capture::merge_frames(bracket.frames, radiometry, "bench").radiance.values();
    };
    const auto opencv = [&](const cv::Ptr<cv::MergeExposures>& merge) {
      return [&, merge] {
        cv::Mat merged;
        merge->process(bracket.images, merged, bracket.times, response);
        return values_of(merged);
      };
    };
    const std::vector<std::pair<std::string, std::function<std::vector<float>()>>> methods{
        {"ours", ours},
        {"OpenCV MergeDebevec", opencv(cv::createMergeDebevec())},
        {"OpenCV MergeRobertson", opencv(cv::createMergeRobertson())}};
    for (const auto& [name, merge] : methods) {
      HdrErrorRow row{name, exposures};
      std::vector<double> seconds;
      std::vector<float> merged;
      for (int repetition = 0; repetition < options.repetitions; ++repetition) {
        const std::clock_t start = std::clock();
        merged = merge();
        seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
      }
      row.seconds = median(seconds);
      score(merged, scene, row);
      rows.push_back(row);
    }
  }
  progress.update("bench hdr", 1.0, "done");
  return rows;
}

namespace {

void measure(const Request& request, Progress& progress, const Save& save) {
  HdrErrorOptions options;
  options.seed = request.seed;
  const bool quick = request.size == Size::quick;
  options.width = request.count("width", quick ? 64 : options.width);
  options.height = request.count("height", quick ? 48 : options.height);
  options.repetitions = request.count("repetitions", options.repetitions);
  if (request.has("frames")) options.frames = request.folder / "frames";
  Json rows = Json::array();
  for (const HdrErrorRow& row : compare_hdr_merges(options, progress)) {
    rows.push_back({{"method", row.method},
                    {"exposures", row.exposures},
                    {"relative_rms", row.relative_rms},
                    {"dark_rms", row.dark_rms},
                    {"seconds", row.seconds}});
  }
  save({{"opencv", CV_VERSION},
        {"scene",
         {{"width", options.width},
          {"height", options.height},
          {"radiance_full_scales_per_s", {darkest, brightest}},
          {"exposures_s", {shortest_s, longest_s}}}},
        {"repetitions", options.repetitions},
        {"rows", rows}});
}

}  // namespace

Subject hdr_subject() {
  return {
      "hdr",
      "Error and CPU time of merged radiance against the number of exposures (docs/hdr.md)",
      "  kappamu bench hdr -o out/\n\n"
      "Ours beside OpenCV's merges, on a simulated eight-bit camera; every method gets its true\n"
      "response.",
      {{"hdr", "two to nine exposures", measure}},
      {{"width", "Of the frames [px] (default 320)", Setting::Kind::number, 16, 10000},
       {"height", "Of the frames [px] (default 240)", Setting::Kind::number, 16, 10000},
       {"repetitions", "Merges timed (default 3)", Setting::Kind::number, 1, 1000},
       {"frames",
        "Also write frames/ with what other programs need to merge the same "
        "(scripts/referees/hdr_peers.py)",
        Setting::Kind::flag}}};
}

}  // namespace kappamu::bench
