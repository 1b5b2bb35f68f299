#include "io/npy.h"

#include <limits>

#include "tests/io/python.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using Npy = FolderTest;

/// A version 1.0 file with the given dictionary and data.
std::string npy_text(std::string header, const std::string& data) {
  header += "\n";
  std::string text("\x93NUMPY\x01\x00", 8);
  text += static_cast<char>(header.size());
  text += '\0';
  return text + header + data;
}

TEST_F(Npy, FloatsComeBackBitByBit) {
  std::vector<float> values(30);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 0.1F * static_cast<float>(i) - 1.0F;
  values[3] = std::numeric_limits<float>::infinity();
  values[4] = std::numeric_limits<float>::denorm_min();
  write_npy(folder_ / "a.npy", {2, 3, 5}, std::span<const float>(values));
  const NpyArray array = read_npy(folder_ / "a.npy");
  EXPECT_THAT(array.shape, ElementsAre(2, 3, 5));
  EXPECT_EQ(array.values, values);
}

TEST_F(Npy, DataBeginsOnA64ByteBoundary) {
  for (std::size_t n = 1; n < 12; ++n) {
    const std::vector<std::size_t> shape(n, 1);
    write_npy(folder_ / "a.npy", shape, std::span<const float>(std::vector<float>{1.0F}));
    EXPECT_EQ((read_bytes(folder_ / "a.npy").size() - sizeof(float)) % 64, 0U);
    EXPECT_EQ(read_npy(folder_ / "a.npy").shape, shape);
  }
}

TEST_F(Npy, EmptyAndScalarShapes) {
  write_npy(folder_ / "a.npy", {0, 4}, std::span<const float>());
  EXPECT_THAT(read_npy(folder_ / "a.npy").shape, ElementsAre(0, 4));
  write_npy(folder_ / "a.npy", {}, std::span<const float>(std::vector<float>{7.0F}));
  EXPECT_THAT(read_npy(folder_ / "a.npy").values, ElementsAre(7.0F));
}

TEST_F(Npy, NumPyReadsWhatWeWrite) {
  const std::vector<float> values{0, 1, 2, 3, 4, 5};
  const std::vector<std::uint8_t> bytes{0, 1, 255};
  const std::vector<double> doubles{1e-300};
  write_npy(folder_ / "f.npy", {1, 2, 3}, std::span<const float>(values));
  write_npy(folder_ / "u.npy", {3}, std::span<const std::uint8_t>(bytes));
  write_npy(folder_ / "d.npy", {}, std::span<const double>(doubles));
  KAPPAMU_NEED_PYTHON("numpy");
  EXPECT_EQ(run_python("import numpy as n\n"
                       "f, u, d = (n.load(c + '.npy') for c in 'fud')\n"
                       "print(f.dtype, f.shape, f[0, 1, 0], u.dtype, u.shape, u[2], d.dtype, d)",
                       folder_),
            "float32 (1, 2, 3) 3.0 uint8 (3,) 255 float64 1e-300\n");
}

TEST_F(Npy, WhatNumPyWritesIsRead) {
  KAPPAMU_NEED_PYTHON("numpy");
  ASSERT_EQ(run_python("import numpy as n\n"
                       "a = n.arange(-3, 21).reshape(2, 3, 4)\n"
                       "for t in ('<f4', '<f8', '<i4', '<i8'): n.save(t[1:], a.astype(t))\n"
                       "n.save('u1', n.arange(5).astype('u1'))\n"
                       "n.save('b1', n.arange(5) > 2)\n"
                       "n.lib.format.write_array(open('v2.npy', 'wb'), a.astype('f4'), (2, 0))\n"
                       "n.save('fortran', n.asfortranarray(a.astype('f4')))\n"
                       "n.save('big', a.astype('>f4'))\n"
                       "n.save('complex', a.astype('c8'))\n"
                       "n.save('record', n.zeros(2, dtype=[('a', 'f4')]))\n",
                       folder_),
            "");
  for (const char* name : {"f4", "f8", "i4", "i8", "v2"}) {
    const NpyArray array = read_npy(folder_ / (std::string(name) + ".npy"));
    EXPECT_THAT(array.shape, ElementsAre(2, 3, 4)) << name;
    EXPECT_EQ(array.values.front(), -3.0F) << name;
    EXPECT_EQ(array.values.back(), 20.0F) << name;
  }
  EXPECT_THAT(read_npy(folder_ / "u1.npy").values, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(read_npy(folder_ / "b1.npy").values, ElementsAre(0, 0, 0, 1, 1));
  const auto sentence = [&](const char* name) {
    return sentence_of([&] { read_npy(folder_ / name); });
  };
  EXPECT_THAT(sentence("fortran.npy"), HasSubstr("fortran.npy: array is in Fortran order; save it "
                                                 "with numpy.ascontiguousarray"));
  EXPECT_THAT(sentence("big.npy"), HasSubstr("element type '>f4' is not supported"));
  EXPECT_THAT(sentence("complex.npy"), HasSubstr("element type '<c8' is not supported"));
  EXPECT_THAT(sentence("record.npy"), HasSubstr("structured NumPy arrays are not supported"));
}

TEST_F(Npy, WrongShapeNamesBoth) {
  write_npy(folder_ / "a.npy", {2, 3}, std::span<const float>(std::vector<float>(6)));
  EXPECT_EQ(sentence_of([&] {
              read_npy(folder_ / "a.npy", {3, 2});
            }),
            (folder_ / "a.npy").string() + ": array has shape [2][3] instead of [3][2]");
}

TEST_F(Npy, MissingFileAndFolderAreTold) {
  EXPECT_EQ(sentence_of([&] { read_npy(folder_ / "a.npy"); }),
            "cannot read " + (folder_ / "a.npy").string() + ": there is no such file");
  EXPECT_EQ(sentence_of([&] { read_npy(folder_); }),
            "cannot read " + folder_.string() + ": it is a folder, not a file");
}

TEST_F(Npy, TruncatedFilesAreRefused) {
  write_npy(folder_ / "a.npy", {7, 5}, std::span<const float>(std::vector<float>(35, 1.0F)));
  expect_truncations_are_refused(folder_ / "a.npy", [](const auto& file) { read_npy(file); });
}

TEST_F(Npy, BrokenHeadersAreRefused) {
  const std::string good = "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), }";
  const std::string data(4, '\0');
  write_text_atomically(folder_ / "a.npy", npy_text(good, data));
  ASSERT_NO_THROW(read_npy(folder_ / "a.npy"));
  for (const std::string& header :
       {std::string("{}"), std::string("{"), std::string("'descr"), good.substr(0, 30),
        std::string("{'descr': '<f4', 'fortran_order': False, 'shape': (-1,), }"),
        std::string("{'descr': '<f4', 'fortran_order': Maybe, 'shape': (1,), }"),
        std::string("{'descr': '<f4', 'fortran_order': False, 'shape': (1 1), }"),
        std::string("{'descr': '<f4', 'fortran_order': False, 'form': (1,), }")}) {
    write_text_atomically(folder_ / "a.npy", npy_text(header, data));
    EXPECT_THAT(sentence_of([&] { read_npy(folder_ / "a.npy"); }),
                HasSubstr("a.npy: broken NumPy header"))
        << header;
  }
  write_text_atomically(folder_ / "a.npy", "P6 1 1 255 ");
  EXPECT_THAT(sentence_of([&] { read_npy(folder_ / "a.npy"); }),
              HasSubstr("not a NumPy .npy file"));
  // Extents whose product overflows must not pass for a small array.
  write_text_atomically(
      folder_ / "a.npy",
      npy_text("{'descr': '<f4', 'fortran_order': False, 'shape': (4294967296, 4294967296), }",
               data));
  EXPECT_THAT(sentence_of([&] { read_npy(folder_ / "a.npy"); }), HasSubstr("is too large"));
}

TEST_F(Npy, OverlongFilesAreRefused) {
  write_npy(folder_ / "a.npy", {2}, std::span<const float>(std::vector<float>(2)));
  write_text_atomically(folder_ / "a.npy", read_text(folder_ / "a.npy") + "x");
  EXPECT_THAT(sentence_of([&] { read_npy(folder_ / "a.npy"); }), HasSubstr("overlong"));
}

}  // namespace
}  // namespace kappamu::io
