// Images: [y][x][channel], channel fastest, row 0 on top; the centre of the first pixel is at (0,
// 0), as in OpenCV.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace kappamu {

template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels, T value = T{})
      : width_(width),
        height_(height),
        channels_(channels),
        data_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                  static_cast<std::size_t>(channels),
              value) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return data_.empty(); }
  std::size_t size() const { return data_.size(); }
  T& operator()(int x, int y, int c = 0) { return data_[index(x, y, c)]; }
  const T& operator()(int x, int y, int c = 0) const { return data_[index(x, y, c)]; }
  std::vector<T>& values() { return data_; }
  const std::vector<T>& values() const { return data_; }
  bool same_shape(const auto& other) const {
    return width_ == other.width() && height_ == other.height() && channels_ == other.channels();
  }

 private:
  std::size_t index(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * width_ + x) * static_cast<std::size_t>(channels_) + c;
  }

  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<T> data_;
};

}  // namespace kappamu
