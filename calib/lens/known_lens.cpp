#include "calib/lens/known_lens.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/opencv_yaml.h"
#include "core/error.h"
#include "io/json_reason.h"
#include "io/read_file.h"

namespace kappamu::calib {
namespace {

using Json = nlohmann::json;
using Names = std::initializer_list<const char*>;

/// Numbers of a list, of lists of lists, or of OpenCV's {"rows", "cols", "data"}.
void gather(const Json& value, std::vector<double>& numbers) {
  if (value.is_number()) {
    numbers.push_back(value.get<double>());
  } else if (value.is_array()) {
    for (const Json& part : value) gather(part, numbers);
  } else if (value.is_object() && value.contains("data")) {
    gather(value["data"], numbers);
  }
}

/// The fields of either kind of file.
class LensFile {
 public:
  explicit LensFile(const std::filesystem::path& file) {
    const std::string text = io::read_text(file);
    const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (first == std::string::npos || text[first] != '{') {
      if (first != std::string::npos && text[first] == '<') {
        throw InputError(file.string() + ": is XML; save it as YAML or JSON");
      }
      yaml_.emplace(file, "correct it");
      return;
    }
    try {
      json_ = Json::parse(text.substr(first));
    } catch (const Json::exception& error) {
      throw InputError(file.string() + ": " + io::json_reason(error));
    }
  }

  /// Empty where there is none of these names.
  std::vector<double> numbers(Names names) const {
    std::vector<double> found;
    for (const char* name : names) {
      if (yaml_) {
        found = yaml_->numbers(name);
      } else if (json_.contains(name)) {
        gather(json_[name], found);
      }
      if (!found.empty()) break;
    }
    return found;
  }

  bool mentions_fisheye() const {
    const std::vector<double> flag = numbers({"fisheye_model"});
    if (!flag.empty() && flag[0] != 0.0) return true;
    std::string model;
    if (yaml_) {
      if (yaml_->has("distortion_model")) yaml_->text("distortion_model", model);
    } else if (json_.contains("distortion_model") && json_["distortion_model"].is_string()) {
      model = json_["distortion_model"];
    }
    return model == "fisheye" || model == "equidistant";
  }

 private:
  std::optional<YamlReader> yaml_;
  Json json_;
};

}  // namespace

KnownLens read_known_lens(const std::filesystem::path& file, LensUse use) {
  const LensFile fields(file);
  const auto bad = [&](const std::string& reason) {
    return InputError(file.string() + ": " + reason);
  };
  const std::vector<double> matrix =
      fields.numbers({"camera_matrix", "Camera_Matrix", "cameraMatrix", "mtx", "K"});
  const std::vector<double> distortion =
      fields.numbers({"distortion_coefficients", "Distortion_Coefficients", "distCoeffs",
                      "dist_coeffs", "dist_coeff", "dist", "D"});
  if (matrix.size() != 9) {
    throw bad("has no camera_matrix of 3 x 3 numbers; write it as OpenCV's FileStorage does");
  }
  if (distortion.empty()) {
    throw bad("has no distortion_coefficients; write five zeros for a lens without distortion");
  }
  const auto finite = [](double value) { return std::isfinite(value); };
  const bool is_matrix = std::all_of(matrix.begin(), matrix.end(), finite) && matrix[0] > 0.0 &&
                         matrix[4] > 0.0 && matrix[1] == 0.0 && matrix[3] == 0.0 &&
                         matrix[6] == 0.0 && matrix[7] == 0.0 && matrix[8] == 1.0;
  if (!is_matrix) throw bad("camera_matrix is not (fx 0 cx; 0 fy cy; 0 0 1) with positive fx, fy");
  KnownLens known;
  known.use = use;
  known.file = file;
  Lens& lens = known.lens;
  const std::size_t held = lens.distortion.size();
  if (!std::all_of(distortion.begin(), distortion.end(), finite)) {
    throw bad("distortion_coefficients are not all finite");
  }
  const bool more = std::any_of(
      distortion.begin() + static_cast<std::ptrdiff_t>(std::min(held, distortion.size())),
      distortion.end(), [](double value) { return value != 0.0; });
  if (more || fields.mentions_fisheye()) {
    throw bad(
        "is of a lens model that is not ours (k1, k2, p1, p2, k3 to k6); calibrate that "
        "camera again without thin prism, tilt or fisheye terms");
  }
  lens.fx = matrix[0];
  lens.fy = matrix[4];
  lens.cx = matrix[2];
  lens.cy = matrix[5];
  std::copy_n(distortion.begin(), std::min(held, distortion.size()), lens.distortion.begin());
  const auto size = [&](Names names) {
    const std::vector<double> found = fields.numbers(names);
    return found.size() == 1 ? static_cast<int>(std::clamp(found[0], 0.0, 1e6)) : 0;
  };
  lens.width = size({"image_width", "image_Width", "width"});
  lens.height = size({"image_height", "image_Height", "height"});
  return known;
}

void require_size(const KnownLens& known, int width, int height) {
  const auto extent = [](int columns, int rows) {
    return std::to_string(columns) + " x " + std::to_string(rows) + " pixels";
  };
  const Lens& lens = known.lens;
  if (lens.width > 0 && lens.height > 0 && (lens.width != width || lens.height != height)) {
    throw InputError(known.file.string() + ": is of pictures of " +
                     extent(lens.width, lens.height) + ", and the photographs have " +
                     extent(width, height) + "; give the lens for this size");
  }
  if (lens.cx < 0.0 || lens.cy < 0.0 || lens.cx >= width || lens.cy >= height) {
    throw InputError(known.file.string() +
                     ": its principal point lies outside the photographs of " +
                     extent(width, height) + "; give the lens for this size");
  }
}

}  // namespace kappamu::calib
