// What shooting a plan does again and again: put things before the rig, show, expose, meter, list.
#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "capture/response/response.h"
#include "capture/rig/shoot.h"
#include "capture/rig/shown_pictures.h"
#include "core/error.h"
#include "io/image/image_file.h"

namespace kappamu::capture {

/// Without a device it rehearses: nothing is exposed or written, only listed.
class Photographer {
 public:
  Photographer(const Camera& camera, const Projector& projector, const CapturePlan& plan,
               const std::filesystem::path& folder, Progress& progress)
      : plan_(plan), progress_(progress) {
    session_.folder = folder;
    session_.description = plan.description;
    session_.setup = plan.setup;
    session_.sample = plan.sample;
    session_.camera = camera;
    session_.projector = projector;
    session_.calibration_station = plan.calibration_station;
    session_.pattern_station = plan.pattern_station;
    session_.calibration.board = plan.board;
    if (chessboards(plan_.plane_light)) session_.calibration.projected_board = plan.projected_board;
    exposures_ = plan.exposures_s;
    target_exposures_ = plan.target_exposures_s.empty() ? exposures_ : plan.target_exposures_s;
    all_exposures_ = exposures_;
    all_exposures_.insert(all_exposures_.end(), target_exposures_.begin(), target_exposures_.end());
    std::sort(all_exposures_.begin(), all_exposures_.end());
    all_exposures_.erase(std::unique(all_exposures_.begin(), all_exposures_.end()),
                         all_exposures_.end());
  }

 protected:
  bool rehearsing() const { return device_ == nullptr; }

  // `subject` and `shows`: what stands there and what the projector throws on it, in words.
  void place(const Scene& scene, const std::string& subject, const std::string& shows) {
    now_.subject = subject;
    now_.station = scene.station;
    now_.show = shows;
    if (!rehearsing()) device_->place(scene);
  }
  void show(const std::string& picture) {
    now_.show = picture;
    if (!rehearsing()) device_->show(pictures_.at(picture));
  }

  Frame save(const std::string& file, double exposure_s, const Image<std::uint16_t>& codes) {
    const Camera& camera = session_.camera;
    if (codes.width() != camera.width || codes.height() != camera.height || codes.channels() != 3) {
      throw InputError("camera: " + file + " came as " + std::to_string(codes.width()) + " x " +
                       std::to_string(codes.height()) + " in " + std::to_string(codes.channels()) +
                       " channels instead of " + std::to_string(camera.width) + " x " +
                       std::to_string(camera.height) + " in 3; correct the driver.");
    }
    io::write_code_image(session_.folder / file, codes, session_.camera.bit_depth);
    const Frame frame = list(file, exposure_s);
    progress_.update("shoot", static_cast<double>(shots_.size()) / static_cast<double>(total_),
                     file);
    return frame;
  }
  Frame list(const std::string& file, double exposure_s, bool metered = false) {
    Shot& shot = shots_.emplace_back(now_);
    shot.file = file;
    shot.exposure_s = exposure_s;
    shot.metered = metered;
    return {file, exposure_s};
  }
  Frame expose(const std::string& file, double exposure_s) {
    if (rehearsing()) return list(file, exposure_s);
    return save(file, exposure_s, device_->expose(exposure_s));
  }
  Stack stack(const std::string& stem, const std::vector<double>& exposures) {
    Stack frames;
    for (const double exposure : exposures) {
      frames.push_back(expose(stem + "_" + std::to_string(frames.size()) + ".png", exposure));
    }
    return frames;
  }

  // One frame at the longest time that hardly saturates, by trial; the trial is kept.
  Frame metered(const std::string& file) {
    if (rehearsing()) return list(file, exposures_.front(), true);
    const int saturated_from = saturation_code(session_.camera.bit_depth);
    // Begins where the last subject of the kind ended and goes to shorter times.
    std::size_t at = std::min(meter_, all_exposures_.size() - 1);
    for (;; --at) {
      const Image<std::uint16_t> codes = device_->expose(all_exposures_[at]);
      const auto saturated =
          std::count_if(codes.values().begin(), codes.values().end(),
                        [&](std::uint16_t code) { return code >= saturated_from; });
      const bool good =
          static_cast<double>(saturated) <= saturated_share * static_cast<double>(codes.size());
      if (!good && at > 0) continue;
      if (!good) {
        progress_.warn(file + " is saturated even at the plan's shortest exposure.");
      }
      meter_ = at;
      return save(file, all_exposures_[at], codes);
    }
  }
  void reset_meter() { meter_ = all_exposures_.size(); }

  RigDevice* device_ = nullptr;  // none while rehearsing
  const CapturePlan& plan_;
  Progress& progress_;
  Session session_;
  std::vector<double> exposures_;
  std::vector<double> target_exposures_;
  std::vector<double> all_exposures_;
  std::size_t meter_ = 0;  // exposure that metering tries first, cut to the last
  std::map<std::string, Image<std::uint8_t>> pictures_;
  Shot now_;  // what stands there and what is shown
  std::vector<Shot> shots_;
  std::size_t total_ = 1;

 private:
  static constexpr double saturated_share = 0.002;
};

}  // namespace kappamu::capture
