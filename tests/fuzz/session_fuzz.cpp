// libFuzzer: any bytes as session.json are read or refused (scripts/fuzz.sh).
#include "capture/session/session.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path file = kappamu::fuzz_file(data, size, "session.json");
  kappamu::refused_or_read([&] {
    // What is read can be written, and is the same when read again.
    const kappamu::capture::Session session = kappamu::capture::read_session(file.parent_path());
    kappamu::capture::write_session(session);
    kappamu::capture::read_session(file.parent_path());
  });
  return 0;
}
