#include "core/shown_text.h"

#include <gtest/gtest.h>

#include "core/file_name.h"

namespace kappamu {
namespace {

TEST(ShownText, WhatPeopleWriteStaysAsItIs) {
  for (const char* text : {"", "block 3 (left)", "Mörtel κ µ 大理石", "a\\b/c'd\""}) {
    EXPECT_EQ(shown_text(text), text);
  }
}

TEST(ShownText, WhatSteersTerminalsOrHidesIsEscaped) {
  EXPECT_EQ(shown_text("a\x1b[2Jb\n\x7f"), "a\\x1b[2Jb\\x0a\\x7f");
  EXPECT_EQ(shown_text("\u202Egnp.exe"), "\\u202egnp.exe");
  EXPECT_EQ(shown_text("\u2066x\u200f"), "\\u2066x\\u200f");
  EXPECT_EQ(shown_text("\u009b2J"), "\\u009b2J") << "the one-character escape of C1";
  EXPECT_EQ(shown_text("a\xff"
                       "b\xc3"),
            "a\\xffb\\xc3")
      << "no UTF-8";
  EXPECT_EQ(shown_text("\xc0\xaf"), "\\xc0\\xaf") << "an overlong slash";
  EXPECT_EQ(shown_text("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half of a surrogate pair";
}

TEST(ShownText, LongValuesAreShortened) {
  const std::string eighty(80, 'x');
  EXPECT_EQ(shown_name(eighty), eighty);
  EXPECT_EQ(shown_name(eighty + "y"), eighty + "...");
  std::string letters;
  for (int i = 0; i < 81; ++i) letters += "ö";
  EXPECT_EQ(shown_name(letters), letters.substr(0, 160) + "...") << "characters, not bytes";
}

}  // namespace
}  // namespace kappamu
