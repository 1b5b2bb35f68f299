// Stages of a calibration: progress, time and warnings of each.
#pragma once

#include <string>

#include "calib/calibrate.h"
#include "core/processor_time.h"
#include "core/progress.h"

namespace kappamu::calib {

class Stages {
 public:
  Stages(CalibrationResult& result, Progress& progress) : result_(result), progress_(progress) {}

  template <class Work>
  void run(const std::string& stage, double from, const Work& work) {
    progress_.update("calibrate", from, stage);
    const Stopwatch watch;
    work();
    result_.seconds[stage] += watch.seconds();
  }

  void warn(const std::string& sentence) {
    result_.warnings.push_back(sentence);
    progress_.warn(sentence);
  }

 private:
  CalibrationResult& result_;
  Progress& progress_;
};

}  // namespace kappamu::calib
