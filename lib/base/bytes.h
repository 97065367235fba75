#pragma once
/// Plain values as bytes and back: little endian; the length of a list or text stands before it. Nothing is aligned.
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/error.h"

namespace surveymc {

static_assert(std::endian::native == std::endian::little, "journals and part files are little endian");

class ByteWriter {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T x) { put(&x, sizeof x); }
  void put(std::string_view text) {
    put(std::uint64_t{text.size()});
    bytes_.append(text);
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(const std::vector<T>& list) {
    put(std::uint64_t{list.size()});
    put(list.data(), list.size() * sizeof(T));
  }
  void put(const std::vector<std::string>& list) {
    put(std::uint64_t{list.size()});
    for (const std::string& text : list) put(text);
  }
  void put(const void* data, std::size_t size) {
    if (size > 0) bytes_.append(static_cast<const char*>(data), size);
  }

  /// Values one after the other: ByteReader::fields() of the same ones reads them.
  template <class... T>
  void fields(const T&... values) {
    (put(values), ...);
  }
  /// The length of lists that are equally long: ByteReader::length_of() gives it to them.
  template <class List, class... Lists>
  void length_of(std::size_t /*least*/, const List& list, const Lists&...) {
    put(std::uint64_t{list.size()});
  }

  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads the bytes that a ByteWriter wrote. Throws IoError where the bytes end too early or a length cannot be right,
/// so that a reader never allocates more than the number of bytes it was given.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : left_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    if constexpr (std::is_same_v<T, bool>) {  // a bool of another value is undefined behaviour
      const auto byte = get<unsigned char>();
      if (byte > 1) throw IoError("damaged: a yes or no is neither");
      return byte == 1;
    } else {
      T x;
      std::memcpy(&x, raw(sizeof x).data(), sizeof x);
      return x;
    }
  }
  std::string text() { return std::string(raw(length(1))); }
  template <class T>
  requires std::is_arithmetic_v<T> std::vector<T> list() {
    const std::size_t n = length(sizeof(T));
    std::vector<T> values(n);
    get(values.data(), n * sizeof(T));
    return values;
  }
  void get(void* data, std::size_t size) {
    const std::string_view from = raw(size);
    if (size > 0) std::memcpy(data, from.data(), size);
  }
  std::string_view raw(std::size_t size) {
    if (size > left_.size()) throw IoError("damaged: the data end too early");
    const std::string_view bytes = left_.substr(0, size);
    left_.remove_prefix(size);
    return bytes;
  }
  /// How many items follow, none of which is smaller than `least` bytes.
  std::size_t length(std::size_t least) {
    const auto n = get<std::uint64_t>();
    if (n > left_.size() / least) throw IoError("damaged: a length is larger than the data");
    return static_cast<std::size_t>(n);
  }
  std::size_t left() const { return left_.size(); }
  template <class... T>
  void fields(T&... values) {
    (take(values), ...);
  }
  /// `least`: bytes of what follows for each item.
  template <class... Lists>
  void length_of(std::size_t least, Lists&... lists) {
    const std::size_t n = length(least);
    (lists.resize(n), ...);
  }

 private:
  template <class T>
  requires std::is_arithmetic_v<T>
  void take(T& x) { x = get<T>(); }
  void take(std::string& x) { x = text(); }
  void take(std::vector<std::string>& x) {
    length_of(8, x);
    for (std::string& each : x) each = text();
  }
  template <class T>
  void take(std::vector<T>& x) {
    x = list<T>();
  }

  std::string_view left_;
};

/// The bytes of what `fields(bytes, value)` lists; it is called with a ByteWriter, and by value_from() with a
/// ByteReader.
template <class T, class Fields>
std::string bytes_of(const T& value, const Fields& fields) {
  ByteWriter out;
  fields(out, value);
  return out.take();
}
/// Throws IoError as ByteReader does.
template <class T, class Fields>
T value_from(std::string_view bytes, const Fields& fields) {
  ByteReader in(bytes);
  T value;
  fields(in, value);
  return value;
}

}  // namespace surveymc
