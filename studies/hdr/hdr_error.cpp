// HDR merges side by side on a simulated bracket of an eight-bit camera, whose true response all
// are given: error of radiance and time against the number of exposures, two to nine of them evenly
// spaced in ln t. OpenCV's merges run in the same program on the same frames.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/photo.hpp>
#include <sstream>

#include "capture/radiance/merge.h"
#include "core/processor_time.h"
#include "data_synthetic/rig/sensor.h"
#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

constexpr double shortest_s = 1.0 / 30.0;
constexpr double longest_s = 8.0;
constexpr double darkest = 0.002;  // full scales per second
constexpr double brightest = 20.0;
constexpr double near_saturation = 0.9;
constexpr int fewest = 2, most = 9;  // exposures

struct Bracket {
  std::vector<capture::ExposedFrame> frames;
  std::vector<cv::Mat> images;
  std::vector<float> times;
};

Image<float> ramp(int width, int height) {
  Image<float> scene(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double share = (x + 0.5) / width;
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

/// <exposures>_<index>.png: with response.txt all that other programs need to merge the same.
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

/// The linear value of each code, a column per channel.
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

/// relative_rms: root mean square of radiance / truth - 1 over four decades of radiance, where the
/// shortest frame does not saturate; the common factor (median) is taken out, as OpenCV's is
/// arbitrary. dark_rms: the same over the darkest decade.
Json score(const std::vector<float>& found, const Image<float>& truth) {
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
  return {{"relative_rms", rms(ratios)}, {"dark_rms", rms(dark)}};
}

void measure(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  const int width = quick ? 64 : 320, height = quick ? 48 : 240;
  const int repetitions = request.count("repetitions", 3);
  synthetic::SensorModel sensor;
  sensor.bit_depth = 8;
  sensor.black_level = 0.0;  // the papers and OpenCV know of no pedestal
  sensor.seed = request.seed;
  const capture::Radiometry radiometry = true_radiometry(sensor);
  const cv::Mat response = opencv_response(radiometry);
  const Image<float> scene = ramp(width, height);
  const std::filesystem::path frames = request.folder / "frames";
  if (request.has("frames")) {
    std::filesystem::create_directories(frames);
    write_response(radiometry, frames / "response.txt");
  }
  Json rows = Json::array();
  for (int exposures = fewest; exposures <= most; ++exposures) {
    progress.update("bench hdr", static_cast<double>(exposures - fewest) / (most - fewest + 1),
                    std::to_string(exposures) + " exposures");
    const Bracket bracket = shoot(sensor, scene, exposures);
    if (request.has("frames")) write_frames(bracket, frames);
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
      std::vector<double> seconds;
      std::vector<float> merged;
      for (int repetition = 0; repetition < repetitions; ++repetition) {
        const double start = processor_seconds();
        merged = merge();
        seconds.push_back(processor_seconds() - start);
      }
      Json row{{"method", name}, {"exposures", exposures}};
      row.update(score(merged, scene));
      row["seconds"] = median(seconds);  // of processor time, of the merge alone
      rows.push_back(row);
    }
  }
  save({{"opencv", CV_VERSION},
        {"scene",
         {{"width", width},
          {"height", height},
          {"radiance_full_scales_per_s", {darkest, brightest}},
          {"exposures_s", {shortest_s, longest_s}}}},
        {"repetitions", repetitions},
        {"rows", rows}});
}

}  // namespace

Subject hdr_subject() {
  return {"hdr",
          "Error and CPU time of merged radiance against the number of exposures (docs/hdr.md)",
          R"(  kappamu-studies hdr -o out/

Ours beside OpenCV's merges, on a simulated eight-bit camera; every method gets its true
response.)",
          {{"hdr", "two to nine exposures", measure}},
          {{"repetitions", "Merges timed (default 3)", Setting::Kind::number, 1, 1000},
           {"frames",
            "Also write frames/ with what other programs need to merge the same "
            "(studies/references/hdr_peers.py)",
            Setting::Kind::flag}}};
}

}  // namespace kappamu::studies
