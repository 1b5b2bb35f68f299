#include "core/threads/side_by_side.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <numeric>
#include <thread>

#include "core/error.h"

namespace kappamu {

namespace {

class Together {
 public:
  Together(std::string stage, const std::vector<std::string>& names, Progress& listener)
      : stage_(std::move(stage)),
        names_(names),
        done_(names.size(), 0.0),
        kept_(names.size()),
        ended_(names.size(), false),
        listener_(listener) {
    for (std::size_t i = 0; i < names.size(); ++i) stage_ += (i == 0 ? " " : ", ") + names[i];
  }

  void update(std::size_t index, double fraction, const std::string& detail) {
    const std::scoped_lock lock(lock_);
    if (failure_) throw Cancelled();
    done_[index] = fraction;
    const double sum = std::accumulate(done_.begin(), done_.end(), 0.0);
    listener_.update(stage_, sum / static_cast<double>(done_.size()),
                     names_[index] + ": " + detail);
  }
  void warn(std::size_t index, const std::string& sentence) {
    const std::scoped_lock lock(lock_);
    if (index == first_open_) {
      listener_.warn(sentence);
    } else {
      kept_[index].push_back(sentence);
    }
  }
  void end(std::size_t index) {
    const std::scoped_lock lock(lock_);
    ended_[index] = true;
    while (ended_[first_open_] && ++first_open_ < names_.size()) {
      for (const std::string& sentence : kept_[first_open_]) listener_.warn(sentence);
    }
  }
  void fail(std::exception_ptr failure) {
    const std::scoped_lock lock(lock_);
    if (!failure_) failure_ = std::move(failure);
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex lock_;
  std::string stage_;
  const std::vector<std::string>& names_;
  std::vector<double> done_;
  std::vector<std::vector<std::string>> kept_;  ///< warnings of works behind the first open one
  std::vector<bool> ended_;
  std::size_t first_open_ = 0;
  Progress& listener_;
  std::exception_ptr failure_;
};

class OfOne : public Progress {
 public:
  OfOne(Together& all, std::size_t index) : all_(all), index_(index) {}
  void update(const std::string& /*stage*/, double fraction, const std::string& detail) override {
    all_.update(index_, fraction, detail);
  }
  void warn(const std::string& sentence) override { all_.warn(index_, sentence); }

 private:
  Together& all_;
  std::size_t index_;
};

}  // namespace

void side_by_side(const std::string& stage, const std::vector<std::string>& names, int at_once,
                  Progress& listener,
                  const std::function<void(std::size_t index, Progress& progress)>& work) {
  if (at_once <= 1 || names.size() <= 1) {
    for (std::size_t i = 0; i < names.size(); ++i) work(i, listener);
    return;
  }
  Together all(stage, names, listener);
  std::atomic<std::size_t> next = 0;
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < std::min(at_once, static_cast<int>(names.size())); ++k) {
      threads.emplace_back([&] {
        for (std::size_t i = next++; i < names.size(); i = next++) {
          try {
            OfOne progress(all, i);
            work(i, progress);
          } catch (...) {
            all.fail(std::current_exception());
            next = names.size();
          }
          all.end(i);
        }
      });
    }
  }
  all.rethrow();
}

}  // namespace kappamu
