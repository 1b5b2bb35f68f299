// TIFF of plain pages, byte by byte, as other programs may write them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/io/image/plain_exr.h"

namespace kappamu::io {

struct Tag {
  unsigned number, type;  ///< type: 1 byte, 2 text, 3 short, 4 long, 5 fraction, 10 signed fraction
  std::vector<std::uint32_t> values;
};

/// A page of 16-bit codes 1000 (x + 1) + 100 y in each of its samples, or of `pixels`.
struct Page {
  unsigned photometric = 1, subfile = 0;
  unsigned width = 4, height = 2, samples = 1;
  std::vector<Tag> more{};
  unsigned bits = 16, strips = 1;
  std::string pixels{};
  unsigned compression = 1;
};

/// A minimal DNG: of a Bayer sensor, or without colour filters where `cfa` is false.
inline Page dng(bool cfa, std::vector<Tag> more) {
  Page page{cfa ? 32803U : 34892U, 0, 64, 48, 1, std::move(more)};
  if (cfa) {
    page.more.push_back({33421, 3, {2, 2}});
    page.more.push_back({33422, 1, {0, 1, 1, 2}});
  }
  page.more.push_back({271, 2, {'T', 'e', 's', 't', 0}});
  page.more.push_back({272, 2, {'C', 'a', 'm', 0}});
  page.more.push_back({50706, 1, {1, 4, 0, 0}});
  page.more.push_back({50708, 2, {'T', 'e', 's', 't', ' ', 'C', 'a', 'm', 0}});
  page.more.push_back({50714, 4, {64}});
  page.more.push_back({50717, 4, {65000}});
  return page;
}

inline std::string tiff(const std::vector<Page>& pages) {
  constexpr std::array<int, 11> sizes{0, 1, 1, 2, 4, 4, 0, 0, 0, 0, 4};  // of a value's numbers
  std::string bytes("II*\0", 4);
  std::size_t link = bytes.size();
  put_number(bytes, 0, 4);
  const auto patch = [&](std::size_t at, std::size_t value) {
    std::string number;
    put_number(number, value, 4);
    bytes.replace(at, 4, number);
  };
  for (const Page& page : pages) {
    const std::size_t pixels = bytes.size();
    bytes += page.pixels;
    for (unsigned y = 0; page.pixels.empty() && y < page.height; ++y) {
      for (unsigned i = 0; i < page.width * page.samples; ++i) {
        put_number(bytes, 1000 * (i / page.samples + 1) + 100 * y, 2);
      }
    }
    const std::size_t size = (bytes.size() - pixels) / page.strips;
    std::vector<std::uint32_t> offsets;
    for (unsigned k = 0; k < page.strips; ++k) {
      offsets.push_back(static_cast<std::uint32_t>(pixels + k * size));
    }
    std::vector<Tag> tags{
        {254, 4, {page.subfile}},
        {256, 4, {page.width}},
        {257, 4, {page.height}},
        {258, 3, std::vector<std::uint32_t>(page.samples, page.bits)},
        {259, 3, {page.compression}},
        {262, 3, {page.photometric}},
        {273, 4, offsets},
        {277, 3, {page.samples}},
        {278, 4, {page.height}},
        {279, 4, std::vector<std::uint32_t>(page.strips, static_cast<std::uint32_t>(size))}};
    tags.insert(tags.end(), page.more.begin(), page.more.end());
    std::stable_sort(tags.begin(), tags.end(),
                     [](const Tag& a, const Tag& b) { return a.number < b.number; });
    std::string entries;
    for (const Tag& tag : tags) {
      std::string values;
      for (const std::uint32_t value : tag.values) put_number(values, value, sizes[tag.type]);
      const std::size_t count = tag.values.size() / (tag.type == 5 || tag.type == 10 ? 2 : 1);
      put_number(entries, tag.number, 2);
      put_number(entries, tag.type, 2);
      put_number(entries, count, 4);
      if (values.size() > 4) {
        if (bytes.size() % 2 != 0) bytes += '\0';
        put_number(entries, bytes.size(), 4);
        bytes += values;
      } else {
        entries += values + std::string(4 - values.size(), '\0');
      }
    }
    if (bytes.size() % 2 != 0) bytes += '\0';
    patch(link, bytes.size());
    put_number(bytes, tags.size(), 2);
    bytes += entries;
    link = bytes.size();
    put_number(bytes, 0, 4);
  }
  return bytes;
}

}  // namespace kappamu::io
