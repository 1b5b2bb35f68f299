// One table in every dialect that spreadsheets write reads alike; what is none is refused by line.
#include "io/csv_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CsvTable : public FolderTest {
 protected:
  using Rows = std::vector<std::vector<std::string>>;
  Rows rows(const std::string& text) {
    write_text_atomically(file_, text);
    Rows rows;
    read_csv(file_, {{"file"}, {"shot"}, {"exposure_s", false}},
             [&](const auto& cells, const std::string&) { rows.push_back(cells); });
    return rows;
  }
  std::string refusal(const std::string& text) {
    return sentence_of([&] { rows(text); });
  }
  const std::filesystem::path file_ = folder_ / "table.csv";
  const Rows plain_{{"a.png", "fit", "0.5"}, {"b.png", "dark", ""}};
};

TEST_F(CsvTable, DialectsReadAlike) {
  for (const char* text :
       {"file,shot,exposure_s\na.png,fit,0.5\nb.png,dark,\n",
        "\xEF\xBB\xBF"
        "file,shot,exposure_s\na.png,fit,0.5\nb.png,dark,\n",
        "file;shot;exposure_s\na.png;fit;0.5\nb.png;dark;\n",
        "file\tshot\texposure_s\na.png\tfit\t0.5\nb.png\tdark\n",
        "sep=;\r\nfile;shot;exposure_s\r\na.png;fit;0.5\r\nb.png;dark;\r\n",
        "file,shot,exposure_s\r\n\r\na.png,fit,0.5\r\nb.png,dark,\r\n\r\n,,\r\n",
        "file,shot,exposure_s\ra.png,fit,0.5\rb.png,dark,\r",
        "\n File , SHOT,Exposure_S \na.png , fit, 0.5\nb.png,dark",
        "\"file\",\"shot\",\"exposure_s\"\n\"a.png\",\"fit\",\"0.5\"\n \"b.png\" ,dark,\"\"\n",
        "shot,note,file,exposure_s\nfit,\"two\nlines, \"\"quoted\"\"\",a.png,0.5\ndark,,b.png,\n",
        "file,shot,exposure_s,,\na.png,fit,0.5,,\nb.png,dark,,,\n",
        // No-break, narrow no-break and zero-width spaces, as copied from a page.
        "file\u00a0,shot,exposure_s\na.png,\u202f fit,\u00a00.5\u00a0\n\ufeff"
        "b.png\u200b,dark,\u00a0\n"}) {
    EXPECT_EQ(rows(text), plain_) << text;
  }
  EXPECT_EQ(rows("shot,file\nfit,\"a, \"\"b\"\".png\"\n"), (Rows{{"a, \"b\".png", "fit", ""}}));
}

TEST_F(CsvTable, NumbersMayHaveADecimalComma) {
  EXPECT_EQ(csv_number("0.5"), 0.5);
  EXPECT_EQ(csv_number("0,5"), 0.5);
  EXPECT_EQ(csv_number("-2"), -2.0);
  for (const char* text : {"", "1.000,5", "1,000,5", "x", "0.5 s", "nan", "inf"}) {
    EXPECT_FALSE(csv_number(text)) << text;
  }
}

TEST_F(CsvTable, WhatIsNoTableIsRefusedByLine) {
  EXPECT_THAT(refusal("name,shot\na,b\n"),
              AllOf(HasSubstr("table.csv: line 1 names no column 'file' but 'name', 'shot'")));
  EXPECT_THAT(refusal(""), HasSubstr("table.csv: line 1 is empty"));
  EXPECT_THAT(refusal("file,shot,File\na,b,c\n"), HasSubstr("names the column 'file' twice"));
  EXPECT_THAT(refusal("file,shot\na,b\n\nb\n"), HasSubstr("line 4 has no shot"));
  EXPECT_THAT(refusal("file,shot\na,b,c\n"),
              HasSubstr("line 2 has 3 cells, the first line names 2"));
  EXPECT_THAT(refusal("file,shot\n\"x\ny\",b\n\"a,b\n"), HasSubstr("line 4 opens a quote"));
  EXPECT_THAT(refusal(std::string("\xFF\xFE"
                                  "f\0i\0l\0e\0",
                                  10)),
              HasSubstr("UTF-16"));
  EXPECT_THAT(refusal(std::string("\xFE\xFF\0f\0i\0l\0e", 10)), HasSubstr("UTF-16"));
}

}  // namespace
}  // namespace kappamu::io
