// Plain numbers and arrays to bytes and back, for checkpoints: native byte order, because a
// checkpoint is resumed on the machine that wrote it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/error.h"
#include "core/numbers/fnv.h"

namespace kappamu::inverse {

/// Takes numbers, enumerators, strings, optional values, vectors of any of them, and what a
/// function transfer(bytes, value) in this namespace is for: the same one writes and reads.
class ByteWriter {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  template <class E>
  void enumerator(const E& value, E /*last*/) {
    put(value);
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  template <class T>
  void put(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      append(&value, sizeof(T));
    } else {
      transfer(*this, value);
    }
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    if constexpr (std::is_arithmetic_v<T>) {
      append(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) put(value);
    }
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  void put(const std::string& text) { put(std::vector<char>(text.begin(), text.end())); }
  void append(const void* data, std::size_t count) {
    if (count == 0) return;
    const std::size_t end = bytes_.size();
    bytes_.resize(end + count);
    std::memcpy(bytes_.data() + end, data, count);
  }
  std::vector<std::byte> bytes_;
};

/// Throws InputError when the bytes end early or hold what no writer puts: the end of a sentence
/// "A checkpoint ...". Allocates no more than a small multiple of the bytes that are there.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  /// From 0 to `last`.
  template <class E>
  void enumerator(E& value, E last) {
    std::underlying_type_t<E> number{};
    get(number);
    if (number < 0 || number > static_cast<std::underlying_type_t<E>>(last)) throw impossible();
    value = static_cast<E>(number);
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  template <class T>
  void get(T& value) {
    static_assert(!std::is_enum_v<T>, "its last enumerator is to be given");
    if constexpr (std::is_arithmetic_v<T>) {
      std::memcpy(&value, take(sizeof(T)), sizeof(T));
    } else {
      transfer(*this, value);
    }
  }
  void get(bool& value) {
    std::uint8_t byte = 0;
    get(byte);
    if (byte > 1) throw impossible();
    value = byte == 1;
  }
  template <class T>
  void get(std::vector<T>& values) {
    std::uint64_t count = 0;
    get(count);
    if constexpr (std::is_arithmetic_v<T>) {
      if (count > bytes_.size() / sizeof(T)) throw truncated();
      const std::byte* from = take(count * sizeof(T));
      values.resize(count);
      if (count > 0) std::memcpy(values.data(), from, count * sizeof(T));
    } else {
      for (std::uint64_t k = 0; k < count; ++k) get(values.emplace_back());
    }
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool has_value = false;
    get(has_value);
    if (has_value) get(value.emplace());
  }
  void get(std::string& text) {
    std::vector<char> characters;
    get(characters);
    text.assign(characters.begin(), characters.end());
  }
  static InputError truncated() { return InputError("is damaged: it ends too early"); }
  static InputError impossible() { return InputError("is damaged: it holds impossible values"); }
  const std::byte* take(std::size_t count) {
    if (count > bytes_.size()) throw truncated();
    const std::byte* begin = bytes_.data();
    bytes_ = bytes_.subspan(count);
    return begin;
  }
  std::span<const std::byte> bytes_;
};

/// Identifies the inputs that a checkpoint belongs to.
class Fingerprint {
 public:
  template <class T>
  void add(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    hash_.add(&value, sizeof(T));
  }
  template <class T>
  void add(std::span<const T> values) {
    add(static_cast<std::uint64_t>(values.size()));
    hash_.add(values.data(), values.size_bytes());
  }
  void add(const std::string& text) { add(std::span<const char>(text.data(), text.size())); }
  std::uint64_t value() const { return hash_.value(); }

 private:
  Fnv hash_;
};

}  // namespace kappamu::inverse
