#include "io/npy.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <ostream>
#include <string_view>
#include <system_error>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "arrays are copied to and from little-endian files as they are");

namespace {

constexpr std::string_view magic = "\x93NUMPY";
constexpr std::size_t alignment = 64;

[[noreturn]] void fail(const fs::path& file, const std::string& why) {
  throw InputError(file.string() + ": " + why);
}

/// Reads NumPy's header, a Python dictionary of three entries.
class HeaderParser {
 public:
  HeaderParser(std::string_view text, const fs::path& file) : text_(text), file_(file) {}

  void parse() {
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr") {
        if (peek() != '\'' && peek() != '"') {
          fail(file_, "structured NumPy arrays are not supported; save one plain float32 array");
        }
        type = quoted();
      } else if (key == "fortran_order") {
        fortran_order = word() == "True";
      } else if (key == "shape") {
        parse_shape();
      } else {
        broken();
      }
      if (!accept(',') && peek() != '}') broken();
    }
    if (type.empty() || !has_shape_) broken();
  }

  std::string type;
  bool fortran_order = false;
  std::vector<std::size_t> shape;

 private:
  [[noreturn]] void broken() const { fail(file_, "broken NumPy header; write the file again"); }
  char peek() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    if (at_ == text_.size()) broken();
    return text_[at_];
  }
  bool accept(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) broken();
  }
  std::string quoted() {
    const char quote = peek();
    if (quote != '\'' && quote != '"') broken();
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) broken();
    std::string result(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return result;
  }
  std::string word() {
    peek();
    std::string result;
    while (at_ < text_.size() && std::isalpha(static_cast<unsigned char>(text_[at_]))) {
      result += text_[at_++];
    }
    if (result != "True" && result != "False") broken();
    return result;
  }
  void parse_shape() {
    expect('(');
    while (!accept(')')) {
      peek();
      std::size_t extent = 0;
      const char* begin = text_.data() + at_;
      const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), extent);
      if (error != std::errc()) broken();
      at_ += static_cast<std::size_t>(end - begin);
      shape.push_back(extent);
      if (!accept(',') && peek() != ')') broken();
    }
    has_shape_ = true;
  }

  std::string_view text_;
  const fs::path& file_;
  std::size_t at_ = 0;
  bool has_shape_ = false;
};

/// Numbers of type T from the stream, in blocks: the file is never in memory whole.
template <class T>
bool read_values(std::istream& in, std::vector<float>& values) {
  constexpr std::size_t block = 1 << 16;
  std::vector<T> numbers(std::min(block, values.size()));
  for (std::size_t begin = 0; begin < values.size(); begin += block) {
    const std::size_t count = std::min(block, values.size() - begin);
    if (!in.read(reinterpret_cast<char*>(numbers.data()),
                 static_cast<std::streamsize>(count * sizeof(T)))) {
      return false;
    }
    std::transform(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(count),
                   values.begin() + static_cast<std::ptrdiff_t>(begin),
                   [](T number) { return static_cast<float>(number); });
  }
  return true;
}

struct ElementType {
  const char* name;
  std::size_t size;
  bool (*read)(std::istream&, std::vector<float>&);
};
constexpr ElementType element_types[] = {
    {"<f4", 4, read_values<float>},        {"<f8", 8, read_values<double>},
    {"<i4", 4, read_values<std::int32_t>}, {"<i8", 8, read_values<std::int64_t>},
    {"|u1", 1, read_values<std::uint8_t>}, {"|b1", 1, read_values<std::uint8_t>},
};

template <class T>
void write_array(const fs::path& file, const char* type, const std::vector<std::size_t>& shape,
                 std::span<const T> values) {
  std::size_t count = 1;
  for (const std::size_t extent : shape) count *= extent;
  check(count == values.size(), "array for " + file.string() + " has " +
                                    std::to_string(values.size()) + " values, its shape says " +
                                    std::to_string(count));
  const std::string header = npy_header(type, shape);
  write_stream_atomically(file, [&](std::ostream& out) {
    out << header;
    out.write(reinterpret_cast<const char*>(values.data()),
              static_cast<std::streamsize>(values.size_bytes()));
  });
}

NpyLayout read_layout(std::istream& in, const fs::path& file) {
  constexpr std::size_t longest_header = std::size_t{1} << 16;
  const auto truncated = [&] { fail(file, "truncated NumPy file; write or copy it again"); };
  std::error_code unknown_size;
  const std::uintmax_t size = fs::file_size(file, unknown_size);
  std::string text(12, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!std::string_view(text).starts_with(magic)) fail(file, "not a NumPy .npy file");
  if (!in) truncated();
  const auto byte = [&](std::size_t i) { return std::size_t{static_cast<unsigned char>(text[i])}; };
  const std::size_t version = byte(6);
  if (version < 1 || version > 3) fail(file, "unknown NumPy format version; save it again");
  // Version 1 has a 16-bit header length, versions 2 and 3 a 32-bit one.
  const std::size_t begin = version == 1 ? 10 : 12;
  std::size_t length = byte(8) | byte(9) << 8;
  if (version > 1) length |= byte(10) << 16 | byte(11) << 24;
  if (begin + length > size) truncated();
  if (length > longest_header) fail(file, "broken NumPy header; write the file again");
  text.resize(length);
  in.seekg(static_cast<std::streamoff>(begin));
  if (!in.read(text.data(), static_cast<std::streamsize>(length))) truncated();

  HeaderParser header(text, file);
  header.parse();
  const auto* type = std::find_if(std::begin(element_types), std::end(element_types),
                                  [&](const ElementType& t) { return header.type == t.name; });
  if (type == std::end(element_types)) {
    fail(file, "element type '" + header.type +
                   "' is not supported; save it as float32 (array.astype('<f4'))");
  }
  if (header.fortran_order) {
    fail(file, "array is in Fortran order; save it with numpy.ascontiguousarray");
  }
  std::size_t count = 1;
  for (const std::size_t extent : header.shape) {
    if (extent != 0 && count > std::numeric_limits<std::size_t>::max() / 16 / extent) {
      fail(file, "shape " + shape_to_string(header.shape) + " is too large");
    }
    count *= extent;
  }
  const std::size_t available = size - begin - length;
  if (available != count * type->size) {
    fail(file, std::string(available < count * type->size ? "truncated" : "overlong") +
                   " NumPy file: shape " + shape_to_string(header.shape) + " of " + header.type +
                   " takes " + std::to_string(count * type->size) + " bytes, the file holds " +
                   std::to_string(available) + "; write or copy it again");
  }
  return {header.shape, header.type, begin + length};
}

std::size_t count_of(const std::vector<std::size_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

std::vector<float> read_from(std::istream& in, const fs::path& file, const NpyLayout& layout,
                             std::size_t first, std::size_t count) {
  const auto* type = std::find_if(std::begin(element_types), std::end(element_types),
                                  [&](const ElementType& t) { return layout.type == t.name; });
  std::vector<float> values(count);
  in.seekg(static_cast<std::streamoff>(layout.begin + first * type->size));
  if (!type->read(in, values)) fail(file, "truncated NumPy file; write or copy it again");
  return values;
}

}  // namespace

NpyLayout read_npy_layout(const fs::path& file) {
  std::ifstream in = open_file(file);
  return read_layout(in, file);
}

NpyArray read_npy(const fs::path& file, const ShapeCheck& expected) {
  std::ifstream in = open_file(file);
  const NpyLayout layout = read_layout(in, file);
  if (expected) expected(layout.shape);
  return {layout.shape, read_from(in, file, layout, 0, count_of(layout.shape))};
}

std::vector<float> read_npy_part(const fs::path& file, std::size_t first, std::size_t count) {
  std::ifstream in = open_file(file);
  const NpyLayout layout = read_layout(in, file);
  check(first + count <= count_of(layout.shape), "the part lies in the array of " + file.string());
  return read_from(in, file, layout, first, count);
}

NpyArray read_npy(const fs::path& file, const std::vector<std::size_t>& shape) {
  return read_npy(file, [&](const std::vector<std::size_t>& found) {
    if (found == shape) return;
    fail(file,
         "array has shape " + shape_to_string(found) + " instead of " + shape_to_string(shape));
  });
}

void write_npy(const fs::path& file, const std::vector<std::size_t>& shape,
               std::span<const float> values) {
  write_array(file, "<f4", shape, values);
}
void write_npy(const fs::path& file, const std::vector<std::size_t>& shape,
               std::span<const double> values) {
  write_array(file, "<f8", shape, values);
}
void write_npy(const fs::path& file, const std::vector<std::size_t>& shape,
               std::span<const std::uint8_t> values) {
  write_array(file, "|u1", shape, values);
}

std::string npy_header(const std::string& type, const std::vector<std::size_t>& shape) {
  std::string axes;
  for (const std::size_t extent : shape) axes += std::to_string(extent) + ", ";
  // A tuple of one needs its comma, longer ones do not: (5,) but (5, 3).
  if (shape.size() == 1) axes.pop_back();
  if (shape.size() > 1) axes.resize(axes.size() - 2);
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + axes + "), }";
  const std::size_t preamble = magic.size() + 4;
  header.append(alignment - 1 - (preamble + header.size()) % alignment, ' ');
  header += '\n';
  check(header.size() <= 0xFFFF, "a NumPy header is too long");
  std::string text(magic);
  text += {'\x01', '\x00', static_cast<char>(header.size() & 0xFF),
           static_cast<char>(header.size() >> 8)};
  return text + header;
}

std::string shape_to_string(const std::vector<std::size_t>& shape) {
  if (shape.empty()) return "[]";
  std::string result;
  for (const std::size_t extent : shape) {
    result.append("[").append(std::to_string(extent)).append("]");
  }
  return result;
}

}  // namespace kappamu::io
