#include "io/atomic_file.h"

#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <ostream>
#include <span>

#include "tests/io/support.h"

namespace kappamu::io {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

using AtomicFile = FolderTest;

constexpr int child_cannot_prepare = 77;

/// Runs `act` in a child process (limits and mounts of its own) and returns what it wrote to `note`
/// in the test's folder; empty when the child could not prepare itself.
template <class Act>
std::string in_child(const fs::path& note, const Act& act) {
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string text = act();
    if (text.empty()) std::_Exit(child_cannot_prepare);
    // The note is smaller than any limit under test.
    std::ofstream(note) << text;
    std::_Exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status)) << "the child died of signal " << WTERMSIG(status);
  if (WEXITSTATUS(status) == child_cannot_prepare) return "";
  return read_text(note);
}

TEST_F(AtomicFile, TextComesBack) {
  write_text_atomically(folder_ / "a.txt", "one\ntwo");
  EXPECT_EQ(read_text(folder_ / "a.txt"), "one\ntwo");
  write_text_atomically(folder_ / "a.txt", "");
  EXPECT_EQ(read_text(folder_ / "a.txt"), "");
  EXPECT_THAT(listing(), ElementsAre("a.txt"));
}

TEST_F(AtomicFile, MissingParentFoldersAreMade) {
  write_text_atomically(folder_ / "b" / "c" / "a.txt", "x");
  EXPECT_EQ(read_text(folder_ / "b" / "c" / "a.txt"), "x");
}

TEST_F(AtomicFile, StreamIsSeekable) {
  write_stream_atomically(folder_ / "a.bin", [](std::ostream& out) {
    out << "head";
    out << std::string(200'000, 'x');  // beyond the buffer
    const auto end = out.tellp();
    out.seekp(0);
    out << "HEAD";
    out.seekp(end);
    out << "tail";
  });
  const std::string text = read_text(folder_ / "a.bin");
  EXPECT_EQ(text.size(), 200'008U);
  EXPECT_EQ(text.substr(0, 5), "HEADx");
  EXPECT_EQ(text.substr(text.size() - 5), "xtail");
}

// Beyond the system's cache whole blocks alone may be written: sizes around theirs, and a turn
// back.
TEST_F(AtomicFile, BypassingTheCacheWritesTheSame) {
  constexpr std::size_t block = std::size_t{1} << 22;
  std::string text(2 * block + 8192, '\0');
  for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>(i * 2654435761U >> 13);
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, std::size_t{4096}, block - 1,
                                 block, block + 4096, 2 * block + 5000}) {
    const auto in_parts = [&](std::ostream& out) {
      for (std::size_t at = 0; at < size; at += 300'001)
        out.write(&text[at],
                  static_cast<std::streamsize>(std::min<std::size_t>(300'001, size - at)));
    };
    write_stream_atomically(folder_ / "a.bin", in_parts, Cache::bypassed);
    EXPECT_EQ(read_text(folder_ / "a.bin", text.size()), text.substr(0, size)) << size;
  }
  const auto turning_back = [&](std::ostream& out) {
    out.write(text.data(), static_cast<std::streamsize>(block + 10));
    out.seekp(0);
    out << "HEAD";
    out.seekp(static_cast<std::streamoff>(block + 10));
    out.write(&text[block + 10], 1000);
  };
  write_stream_atomically(folder_ / "a.bin", turning_back, Cache::bypassed);
  EXPECT_EQ(read_text(folder_ / "a.bin", text.size()), "HEAD" + text.substr(4, block + 1006));
}

TEST_F(AtomicFile, PartsAreTheWhole) {
  std::string text(200'000, 'x');
  text += "end";
  write_text_atomically(folder_ / "a.txt", text);
  // What the system's cache is bypassed for: a hole, and an end that is no whole block.
  std::ofstream(folder_ / "large.bin") << text;
  fs::resize_file(folder_ / "large.bin", cache_bypass + 777);
  std::string read;
  read_parts(folder_ / "a.txt",
             [&](std::span<const char> part) { read.append(part.data(), part.size()); });
  EXPECT_EQ(read, text);
  std::size_t size = 0, others = 0;
  read_parts(folder_ / "large.bin", [&](std::span<const char> part) {
    size += part.size();
    others += static_cast<std::size_t>(
        std::count_if(part.begin(), part.end(), [](char c) { return c != '\0'; }));
  });
  EXPECT_EQ(size, cache_bypass + 777);
  EXPECT_EQ(others, text.size());
  EXPECT_THAT(sentence_of([&] { read_parts(folder_ / "none", [](std::span<const char>) {}); }),
              HasSubstr("none"));
}

TEST_F(AtomicFile, FailingWriterLeavesTheOldFileAndNoTemporary) {
  write_text_atomically(folder_ / "a.txt", "old");
  const auto partly = [](const fs::path& temporary) {
    std::ofstream(temporary) << "new";
    throw std::runtime_error("the lamp went out");
  };
  const std::string sentence = sentence_of([&] { write_atomically(folder_ / "a.txt", partly); });
  EXPECT_EQ(sentence, "cannot write " + (folder_ / "a.txt").string() + ": the lamp went out");
  EXPECT_EQ(read_text(folder_ / "a.txt"), "old");
  EXPECT_THAT(listing(), ElementsAre("a.txt"));
}

TEST_F(AtomicFile, WriterThatMakesNoFileIsToldSo) {
  const std::string sentence =
      sentence_of([&] { write_atomically(folder_ / "a.txt", [](const fs::path&) {}); });
  EXPECT_THAT(sentence, HasSubstr("a.txt: No such file or directory"));
}

TEST_F(AtomicFile, TargetThatIsAFolderIsRefused) {
  fs::create_directories(folder_ / "a.txt");
  const std::string sentence = sentence_of([&] { write_text_atomically(folder_ / "a.txt", "x"); });
  EXPECT_THAT(sentence, HasSubstr("a.txt: Is a directory"));
  EXPECT_THAT(listing(), ElementsAre("a.txt"));
}

TEST_F(AtomicFile, ParentThatIsAFileIsRefused) {
  write_text_atomically(folder_ / "a", "x");
  EXPECT_THAT(sentence_of([&] { write_text_atomically(folder_ / "a" / "b.txt", "x"); }),
              HasSubstr("b.txt: Not a directory"));
}

TEST_F(AtomicFile, FileSizeLimitGivesOneSentence) {
  write_text_atomically(folder_ / "a.bin", "old");
  const std::string sentence = in_child(folder_ / "note", [&]() -> std::string {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{8192, 8192};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return "";
    try {
      write_text_atomically(folder_ / "a.bin", std::string(300'000, 'x'));
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  });
  EXPECT_EQ(sentence, "cannot write " + (folder_ / "a.bin").string() +
                          ": File too large; the file system or a limit of this account refuses a "
                          "file of this size, choose another folder");
  EXPECT_EQ(read_text(folder_ / "a.bin"), "old");
  EXPECT_THAT(listing(), testing::UnorderedElementsAre("a.bin", "note"));
}

TEST_F(AtomicFile, FullDiskGivesOneSentence) {
  const fs::path disk = folder_ / "disk";
  fs::create_directories(disk);
  const std::string report = in_child(folder_ / "note", [&]() -> std::string {
    // A file system of 64 KiB that only this child sees and that ends with it.
    if (::unshare(CLONE_NEWNS) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return "";
    ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
    if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=64k") != 0) return "";
    write_text_atomically(disk / "x.npy", "old");
    std::string text = "no error";
    try {
      write_text_atomically(disk / "x.npy", std::string(300'000, 'x'));
    } catch (const InputError& error) {
      text = error.what();
    }
    text += "|" + read_text(disk / "x.npy");
    for (const auto& entry : fs::directory_iterator(disk)) {
      text += "|" + entry.path().filename().string();
    }
    return text;
  });
  if (report.empty()) GTEST_SKIP() << "this account may not mount a small file system";
  EXPECT_EQ(report, "cannot write " + (disk / "x.npy").string() +
                        ": No space left on device; free space or choose another folder"
                        "|old|x.npy");
}

TEST_F(AtomicFile, TemporariesAreRemovedAndWhatLooksLikeOneStays) {
  fs::create_directories(folder_ / "sub");
  const std::vector<std::string> stay{"a.npy", ".a.partial-x", ".a.partial-7-x.npy",
                                      "a.partial-7-0.npy", ".a.partial-7-0copy"};
  for (const std::string& name : stay) write_text_atomically(folder_ / "sub" / name, "x");
  for (const char* name : {".a.partial-7-0.npy", ".a.partial-123456-12"}) {
    write_text_atomically(folder_ / "sub" / name, "x");
  }
  fs::create_directory_symlink(folder_, folder_ / "sub" / ".b.partial-7-0.npy");
  EXPECT_EQ(remove_temporaries(folder_), 2U);
  std::vector<std::string> expected = stay;
  expected.insert(expected.end(), {"sub", ".b.partial-7-0.npy"});
  EXPECT_THAT(listing(), testing::UnorderedElementsAreArray(expected));
  EXPECT_EQ(remove_temporaries(folder_ / "missing"), 0U);
}

}  // namespace
}  // namespace kappamu::io
