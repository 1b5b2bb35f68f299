#include "capture/response/noise_model.h"

#include <algorithm>

namespace kappamu::capture {

NoiseModel::NoiseModel(const std::vector<double>& response, const Noise& noise, Rounding rounding)
    : table_(entries) {
  const double read = noise.read_noise_electrons / noise.electrons_full_scale;
  std::size_t code = 0;
  for (int i = 0; i < entries; ++i) {
    const double root = static_cast<double>(i) / (entries - 1);
    const double x = root * root;
    while (code + 1 < response.size() && response[code] < x) ++code;
    double spread = 0.0;
    if (rounding == Rounding::to_codes) {
      const std::size_t low = code > 0 ? code - 1 : 0;
      const std::size_t high = std::min(code + 1, response.size() - 1);
      const double slope = (response[high] - response[low]) / static_cast<double>(high - low);
      spread = slope * slope / 12.0;
    }
    table_[static_cast<std::size_t>(i)] =
        static_cast<float>(x / noise.electrons_full_scale + read * read + spread);
  }
  shot_per_signal_ = static_cast<float>(1.0 / noise.electrons_full_scale);
  least_ = 0.25F * table_.front();
  constexpr float tolerance = 1e-3F;  // the entries' own
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const float root = static_cast<float>(i) / (entries - 1);
    const float sum = table_.front() + root * root * shot_per_signal_;
    straight_ = straight_ && std::abs(sum - table_[i]) < tolerance * sum;
  }
}

}  // namespace kappamu::capture
