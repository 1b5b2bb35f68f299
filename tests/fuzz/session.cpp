// session.json, and the table of photographs that import reads.
#include "capture/session/session.h"
#include "capture/import/import_photographs.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "tests/fuzz/targets.h"

namespace kappamu::fuzz {

namespace fs = std::filesystem;

namespace {

/// The session of docs/formats.md.
std::string documented_session() {
  const std::string text = io::read_text(fs::path(KAPPAMU_SOURCE_DIR) / "docs" / "formats.md");
  const std::size_t begin = text.find("```json\n") + 8;
  return text.substr(begin, text.find("```", begin) - begin);
}

}  // namespace

void read_session(Bytes bytes) {
  write(folder() / "session.json", bytes);
  // What is read can be written, and is the same when read again.
  const capture::Session session = capture::read_session(folder());
  capture::write_session(session);
  capture::read_session(folder());
}

void seed_session(const fs::path& seeds) {
  std::string text = documented_session();
  write(seeds / "documented.json", bytes_of(text));
  const std::string encoding = "\"encoding\": \"response\"";
  text.replace(text.find(encoding), encoding.size(),
               "\"encoding\": \"linear\", \"raw_layout\": {\"bits\": 16, \"byte_order\": \"big\", "
               "\"offset\": 2, \"mosaic\": \"RGGB\"}");
  write(seeds / "headerless.json", bytes_of(text));
}

void read_import(Bytes bytes) {
  static const fs::path photographs = [] {
    const fs::path made = folder() / "photographs";
    for (const char* name : {"a.png", "b.png"}) {
      io::write_image(made / name, Image<std::uint8_t>(8, 6, 3, 90));
    }
    return made;
  }();
  write(folder() / "table.csv", bytes);
  Progress progress;
  const auto found = capture::find_photographs(
      {photographs, folder() / "table.csv", capture::Links::within}, progress);
  capture::require_exposure_times(found);
  capture::check_settings(found);
}

void seed_import(const fs::path& seeds) {
  write(seeds / "table.csv",
        bytes_of("file,shot,exposure_s\na.png,fit_00,1/30\nb.png,plane_02_gray_03,0.5\n"));
}

}  // namespace kappamu::fuzz
