// `kappamu render --frames` and `--turntable`: a scene's frames as numbered pictures and a film.
#pragma once

#include <filesystem>
#include <functional>

#include "app/command.h"
#include "render/render_scene.h"
#include "render/scene/frames.h"

namespace kappamu::app {

/// Renders what of the frames is not there yet of the same inputs: an interrupted command goes on,
/// and after a change only frames that it concerns are rendered again. Where a scene states no
/// exposure all frames have the first one's. `chosen` is called on every frame's scene and settles
/// its model; `frames_file` is among the inputs, "" for none.
void render_frames(const render::Frames& frames, const std::filesystem::path& frames_file,
                   const std::function<void(render::Scene&)>& chosen,
                   const std::filesystem::path& out, Globals& globals);

}  // namespace kappamu::app
