#include "app/render_frames.h"

#include <spawn.h>
#include <sys/wait.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/registry.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/fingerprint.h"
#include "pipeline/verify.h"
#include "render/machine_costs.h"

extern char** environ;

namespace kappamu::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* film_name = "film.mp4";

std::string name_of_frame(int frame) {
  return formatted("frame-%05d", frame);
}

/// The scenes of all frames, and every file that they name. All are read before the first is
/// rendered.
struct Sequence {
  std::vector<render::Scene> scenes;
  std::vector<fs::path> files;
};

Sequence read_all(const render::Frames& frames, const fs::path& frames_file,
                  const std::function<void(render::Scene&)>& chosen) {
  Sequence sequence;
  if (!frames_file.empty()) sequence.files.push_back(frames_file);
  for (int i = 0; i < frames.count(); ++i) {
    sequence.scenes.push_back(frames.scene(i));
    chosen(sequence.scenes.back());
    for (const fs::path& file : render::files_of(sequence.scenes.back())) {
      if (std::find(sequence.files.begin(), sequence.files.end(), file) == sequence.files.end()) {
        sequence.files.push_back(file);
      }
    }
  }
  return sequence;
}

/// Of what a frame depends on but for the exposure.
std::string inputs_of(const std::string& text, const render::Scene& scene, const Globals& globals) {
  pipeline::Fingerprint print;
  print.add(pipeline::program_fingerprint()).add(text).add(globals.device);
  print.add(std::to_string(globals.seed)).add(scene.model.name);
  for (const auto& [name, value] : scene.model.parameters) {
    print.add(name);
    std::visit([&](const auto& own) { print.add(nlohmann::json(own).dump()); }, value);
  }
  const std::vector<fs::path> files = render::files_of(scene);
  for (std::size_t i = 1; i < files.size(); ++i) {  // the first is the scene, which the text is of
    if (!fs::is_directory(files[i])) {
      print.add_file(files[i]);
      continue;
    }
    std::vector<fs::path> inside;
    std::error_code ignored;
    const auto links = fs::directory_options::follow_directory_symlink;
    std::set<fs::path> folders{fs::canonical(files[i])};  // links may lead round in a circle
    for (fs::recursive_directory_iterator entry(files[i], links), end; entry != end; ++entry) {
      const fs::path& path = entry->path();
      if (fs::is_regular_file(path, ignored)) inside.push_back(path);
      if (fs::is_directory(path, ignored) && !folders.insert(fs::canonical(path)).second) {
        entry.disable_recursion_pending();
      }
    }
    std::sort(inside.begin(), inside.end());
    for (const fs::path& file : inside) print.add_file(file);
  }
  return print.text();
}

/// Where this frame lies complete, and its exposure: in the folder, or in an interrupted attempt.
std::optional<double> kept(const fs::path& out, const fs::path& partial, const std::string& name,
                           const std::string& inputs) {
  if (const auto exposure = render::frame_exposure(partial, name, inputs)) return exposure;
  const auto exposure = render::frame_exposure(out, name, inputs);
  if (!exposure) return std::nullopt;
  for (const char* ending : {".png", ".json"}) {
    fs::copy_file(out / (name + ending), partial / (name + ending),
                  fs::copy_options::overwrite_existing);
  }
  return exposure;
}

/// Exit code of a program that is found by its name, or nothing where it is not there.
std::optional<int> run_program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0) {
    return std::nullopt;
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Why there is no film; empty: there is one.
std::string film(const fs::path& folder, double rate) {
  const std::optional<int> code =
      run_program({"ffmpeg", "-v", "error", "-y", "-framerate", formatted("%g", rate), "-i",
                   (folder / "frame-%05d.png").string(), "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                   "-pix_fmt", "yuv420p", "-crf", "16", (folder / film_name).string()});
  if (!code) return "ffmpeg is not installed, so there are pictures and no film";
  if (*code == 0) return "";
  fs::remove(folder / film_name);
  return "ffmpeg made no film of the pictures; its exit code is " + std::to_string(*code);
}

/// What an interrupted attempt has of frames that there are no more.
void remove_all_but(const std::vector<std::string>& outputs, const fs::path& folder) {
  const std::set<std::string> mine(outputs.begin(), outputs.end());
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!mine.contains(entry.path().filename())) others.push_back(entry.path());
  }
  for (const fs::path& file : others) fs::remove(file);
}

}  // namespace

void render_frames(const render::Frames& frames, const fs::path& frames_file,
                   const std::function<void(render::Scene&)>& chosen, const fs::path& out,
                   Globals& globals) {
  const auto progress = make_progress();
  const Sequence sequence = read_all(frames, frames_file, chosen);
  pipeline::require_as_written(sequence.files);
  std::vector<std::string> outputs{film_name};
  for (int i = 0; i < frames.count(); ++i) {
    outputs.push_back(name_of_frame(i) + ".png");
    outputs.push_back(name_of_frame(i) + ".json");
  }
  pipeline::OutputFolder folder(out, "frames", sequence.files, outputs, pipeline::Former::removed,
                                "frames", pipeline::Interrupted::continued);
  remove_all_but(outputs, folder.partial());
  Progress silent;
  int rendered = 0;
  std::optional<double> first_exposure;
  std::vector<std::string> warnings;
  for (int i = 0; i < frames.count(); ++i) {
    const std::string name = name_of_frame(i);
    progress->update("frames", static_cast<double>(i) / frames.count(), name);
    render::Scene scene = sequence.scenes[static_cast<std::size_t>(i)];
    if (!scene.film.exposure) scene.film.exposure = first_exposure;
    std::string inputs = inputs_of(frames.text(i), scene, globals);
    if (scene.film.exposure) inputs += formatted("-%.17g", *scene.film.exposure);
    std::optional<double> exposure = kept(folder.path(), folder.partial(), name, inputs);
    if (!exposure) {
      render::RenderOptions options{globals.device, globals.seed};
      if (forward::object_model(scene.model.name).can.chooses) {
        options.costs = render::read_machine_costs(globals.device);
      }
      const auto model = forward::make_object_model(scene.model.name, forward::ModelError::warned,
                                                    scene.model.parameters);
      const render::RenderResult result = [&] {
        try {
          return render::render_scene(scene, *model, options, silent);
        } catch (const InputError& error) {
          throw InputError("frame " + std::to_string(i) + ": " + error.what(), error.options());
        }
      }();
      render::write_frame(result, scene, options, inputs, folder.partial(), name);
      exposure = result.exposure;
      ++rendered;
      if (!result.converged) globals.exit_code = 3;
      for (const std::string& warning : result.warnings) {
        if (std::find(warnings.begin(), warnings.end(), warning) != warnings.end()) continue;
        warnings.push_back(warning);
        progress->warn(name + ": " + warning);
      }
    }
    if (!first_exposure) first_exposure = exposure;
  }
  progress->update("frames", 1.0, "");
  const std::string no_film = film(folder.partial(), frames.rate());
  folder.commit();
  if (!no_film.empty()) progress->warn(no_film);
  if (globals.json) {
    return print_json({{"frames", frames.count()},
                       {"rendered", rendered},
                       {"kept", frames.count() - rendered},
                       {"film", no_film.empty() ? (out / film_name).string() : ""},
                       {"folder", out.string()}});
  }
  std::printf("frames               %d, %d of them kept from before\n", frames.count(),
              frames.count() - rendered);
  std::printf("pictures             %s\n", (out / (name_of_frame(0) + ".png")).c_str());
  if (no_film.empty()) std::printf("film                 %s\n", (out / film_name).c_str());
}

}  // namespace kappamu::app
