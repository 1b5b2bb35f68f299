// The tables of docs/limits.md: their text, and that each has its place there.
#include "bench/limit_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "bench/limits.h"
#include "tests/sentence.h"

namespace kappamu::bench {
namespace {

using ::testing::HasSubstr;

const std::vector<Record> records{
    {{"kind", "a"}, {"contrast", 1.0}, {"count", 3}},
    {{"kind", "a"}, {"contrast", 1e4}, {"count", 4}},
    {{"kind", "b"}, {"contrast", 1e4}, {"count", 5}},
};

TEST(LimitTable, WritesFiguresShort) {
  EXPECT_EQ(to_text(1.2345e-6), "1.2e-6");
  EXPECT_EQ(to_text(1e6), "1e6");
  EXPECT_EQ(to_text(1e-12), "1e-12");
  EXPECT_EQ(to_text(0.25), "0.25");
  EXPECT_EQ(to_text(17), "17");
}

TEST(LimitTable, CrossesLinesAndColumns) {
  EXPECT_EQ(cross_table(records, "kind", "contrast",
                        [](const Record& r) { return to_text(figure(r, "count")); }),
            "| kind | contrast 1 | contrast 1e4 |\n|---|---|---|\n| a | 3 | 4 |\n| b |  | 5 |\n");
}

TEST(LimitTable, ListsTheColumnsAskedFor) {
  EXPECT_EQ(flat_table({records[2]}, {"count", "kind"}),
            "| count | kind |\n|---|---|\n| 5 | b |\n");
}

TEST(LimitTable, ReplacesItsPlaceAndNoOther) {
  const std::string document =
      "x\n<!-- limits:one -->\nold\n<!-- limits:end -->\ny\n<!-- limits:two -->\nkept\n"
      "<!-- limits:end -->\n";
  const std::string renewed = with_table(document, {"one", {}, "new\n"}, "d.md");
  EXPECT_EQ(renewed,
            "x\n<!-- limits:one -->\n\nnew\n\n<!-- limits:end -->\ny\n<!-- limits:two -->\nkept\n"
            "<!-- limits:end -->\n");
  EXPECT_EQ(with_table(renewed, {"one", {}, "new\n"}, "d.md"), renewed);
  EXPECT_THAT(sentence_of([&] {
                with_table(document, {"three", {}, ""}, "d.md");
              }),
              HasSubstr("d.md: no place for the table 'three'"));
}

TEST(LimitTable, EveryOneHasItsPlaceInTheDocument) {
  std::ifstream file(KAPPAMU_SOURCE_DIR "/docs/limits.md");
  std::ostringstream text;
  text << file.rdbuf();
  for (const LimitName& limit : limit_names()) {
    EXPECT_NO_THROW(with_table(text.str(), {limit.id, {}, ""}, "docs/limits.md")) << limit.id;
  }
}

TEST(LimitTable, UnknownNamesAreRefusedWithTheKnownOnes) {
  Progress silent;
  EXPECT_THAT(sentence_of([&] { measure_limit("weather", {}, silent); }),
              HasSubstr("limit 'weather' is unknown; choose one of 'contrast', 'size'"));
}

}  // namespace
}  // namespace kappamu::bench
