#include "io/mat_file.h"

#include <gtest/gtest.h>
#include <matio.h>

#include <array>
#include <fstream>
#include <vector>

#include "core/error.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::io {
namespace {

/// Numbers 0, 1, 2, ... in MATLAB's order: down the columns, then page by page.
template <class Number>
void add(mat_t* mat, const char* name, matio_classes kind, matio_types type,
         std::vector<std::size_t> dims) {
  std::size_t size = 1;
  for (const std::size_t one : dims) size *= one;
  std::vector<Number> numbers(size);
  for (std::size_t i = 0; i < size; ++i) numbers[i] = static_cast<Number>(i);
  matvar_t* variable = Mat_VarCreate(name, kind, type, static_cast<int>(dims.size()), dims.data(),
                                     numbers.data(), 0);
  ASSERT_EQ(Mat_VarWrite(mat, variable, MAT_COMPRESSION_ZLIB), 0);
  Mat_VarFree(variable);
}

class MatFiles : public testing::TestWithParam<mat_ft> {
 protected:
  std::filesystem::path write(bool several) {
    const std::filesystem::path file = folder_ / "frames.mat";
    mat_t* mat = Mat_CreateVer(file.c_str(), nullptr, GetParam());
    add<std::uint16_t>(mat, "frames", MAT_C_UINT16, MAT_T_UINT16, {2, 3, 4});
    if (several) {
      add<double>(mat, "four", MAT_C_DOUBLE, MAT_T_DOUBLE, {2, 3, 1, 4});
      add<double>(mat, "colours", MAT_C_DOUBLE, MAT_T_DOUBLE, {2, 3, 3, 4});
      add<double>(mat, "flat", MAT_C_DOUBLE, MAT_T_DOUBLE, {3, 2});  // the last: what is cut off
    }
    Mat_Close(mat);
    return file;
  }
  OwnFolder folder_;
};

TEST_P(MatFiles, RowsAreYAndPagesAreChosen) {
  const Image<float> page = read_mat_picture(write(false), "", 2);
  ASSERT_EQ(page.width(), 3);
  ASSERT_EQ(page.height(), 2);
  EXPECT_EQ(page(0, 0), 12.0F);
  EXPECT_EQ(page(0, 1), 13.0F);
  EXPECT_EQ(page(2, 1), 17.0F);
  EXPECT_EQ(count_mat_pages(write(false), ""), 4U);
  EXPECT_EQ(count_mat_pages(write(true), "flat"), 1U);
  const Image<float> flat = read_mat_picture(write(true), "flat", 0);
  ASSERT_EQ(flat.width(), 2);
  EXPECT_EQ(flat(1, 0), 3.0F);
  EXPECT_EQ(count_mat_pages(write(true), "four"), 4U);
  EXPECT_EQ(read_mat_picture(write(true), "four", 2)(2, 1), 17.0F);
}

TEST_P(MatFiles, RefusesInOneSentence) {
  const std::filesystem::path file = write(true);
  const auto refused = [&](const std::string& name, std::size_t page, const std::string& part) {
    const std::string sentence = sentence_of([&] { read_mat_picture(file, name, page); });
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
    EXPECT_NE(sentence.find(file.string()), std::string::npos) << sentence;
  };
  refused("", 0, "3 numeric arrays");
  refused("colours", 0, "several are [row][column][page]");
  refused("light", 0, "it holds");
  refused("frames", 4, "no page 4");
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_THROW(read_mat_picture(file, "flat", 0), InputError);
  std::ofstream(file) << "text";
  refused("frames", 0, "no MATLAB file");
}

INSTANTIATE_TEST_SUITE_P(Levels, MatFiles, testing::Values(MAT_FT_MAT5, MAT_FT_MAT73));

}  // namespace
}  // namespace kappamu::io
