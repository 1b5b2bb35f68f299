#include "render/live/live_picture.h"

namespace kappamu::render {

std::optional<Picture> LivePicture::next(const World& world, const Environment* environment,
                                         const std::vector<ObjectExitance>& exitance,
                                         const PictureView& view, std::uint64_t seed,
                                         Progress& progress) {
  if (!shading_) {
    sources_ = make_light_sources(world.outer_lights());
    shading_ =
        std::make_unique<Shading>(world, sources_, environment, exitance, std::nullopt, &progress);
  }
  if (!maker_ || !(view == view_)) {
    view_ = view;
    Film film;
    film.width = view.width;
    film.height = view.height;
    film.samples = view.samples;
    maker_ = std::make_unique<PictureMaker>(view.camera, film, seed);
  }
  if (maker_->done()) return std::nullopt;
  try {
    maker_->pass(*shading_, progress);
  } catch (...) {
    maker_.reset();
    throw;
  }
  return maker_->picture();
}

void LivePicture::reset() {
  maker_.reset();
  shading_.reset();
}

}  // namespace kappamu::render
