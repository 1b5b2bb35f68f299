#include "core/file_name.h"

#include <gtest/gtest.h>

namespace kappamu {
namespace {

TEST(FileName, PlainNamesStayInTheirFolder) {
  for (const char* name : {"R", "fit_00", "a.b-c", "-", "0", "a..b"}) {
    EXPECT_TRUE(is_plain_name(name)) << name;
  }
  EXPECT_TRUE(is_plain_name(std::string(100, 'a')));
  EXPECT_FALSE(is_plain_name(std::string(101, 'a')));
  for (const char* name :
       {"", ".", "..", ".a", "a/b", "a\\b", "a b", "a\n", "é", "a:b", "a*", "../a", "/a"}) {
    EXPECT_FALSE(is_plain_name(name)) << name;
  }
  EXPECT_FALSE(is_plain_name(std::string_view("a\0b", 3)));
}

TEST(FileName, PathsThatLeaveAreSeen) {
  for (const char* path : {"a", "a/b.png", "./a", "a/./b", "Foto (1).png", "a..b/..c", "a/"}) {
    EXPECT_TRUE(stays_inside(path)) << path;
  }
  for (const char* path : {"", "/a", "..", "../a", "a/..", "a/../b", "a/../../b", "a\nb"}) {
    EXPECT_FALSE(stays_inside(path)) << path;
  }
  EXPECT_FALSE(stays_inside(std::string_view("a\0b", 3)));
}

}  // namespace
}  // namespace kappamu
