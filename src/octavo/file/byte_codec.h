// Little-endian numbers and varints, in and out of byte strings.
//
// A varint holds 7 bits a byte, lowest first, the high bit of a byte set while more follow
// (LEB128); it is written in the fewest bytes, and any longer form is rejected. Signed numbers are
// zigzag: 0 -1 1 -2 2 ...
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "octavo/codec/entropy/byte_io.h"
#include "octavo/core/error.h"

namespace octavo {

/// Writes the bytes of `value`, lowest first, to `out`.
template <class T>
void store_little_endian(T value, std::uint8_t* out) {
  static_assert(std::is_unsigned_v<T>);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    out[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}

/// The number whose bytes, lowest first, stand at `in`.
template <class T>
T load_little_endian(const std::uint8_t* in) {
  static_assert(std::is_unsigned_v<T>);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{in[i]} << (8 * i);
  return static_cast<T>(value);
}

/// Appends numbers to a byte string.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::uint8_t>& out) : out_(out) {}

  void put_u8(std::uint8_t value) { out_.push_back(value); }

  void put_u32(std::uint32_t value) { put_fixed(value); }

  void put_u64(std::uint64_t value) { put_fixed(value); }

  void put_varint(std::uint64_t value) { octavo::put_varint(out_, value); }

  void put_signed(std::int64_t value) { put_varint(zigzag(value)); }

 private:
  template <class T>
  void put_fixed(T value) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    store_little_endian(value, out_.data() + at);
  }

  std::vector<std::uint8_t>& out_;
};

/// Takes numbers from a byte string; every call throws Error{corrupt} naming `what` when there is
/// no such number left.
class ByteReader {
 public:
  ByteReader(std::span<const std::uint8_t> bytes, const char* what) : bytes_(bytes), what_(what) {}

  std::size_t left() const { return bytes_.size(); }

  std::uint8_t u8() { return take(1)[0]; }

  std::uint32_t u32() { return load_little_endian<std::uint32_t>(take(4).data()); }

  std::uint64_t u64() { return load_little_endian<std::uint64_t>(take(8).data()); }

  std::span<const std::uint8_t> take(std::size_t count) {
    if (count > bytes_.size()) fail("ends early");
    const auto head = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return head;
  }

  std::uint64_t varint() {
    try {
      return take_varint(bytes_);
    } catch (const Error& error) {
      fail(error.detail());
    }
  }

  std::int64_t signed_varint() { return unzigzag(varint()); }

  /// Requires that every byte has been taken.
  void expect_end() const {
    if (!bytes_.empty()) fail(std::to_string(bytes_.size()) + " bytes longer than its contents");
  }

  [[noreturn]] void fail(const std::string& how) const {
    throw Error(ErrorKind::corrupt, std::string(what_) + ": " + how);
  }

 private:
  std::span<const std::uint8_t> bytes_;
  const char* what_;
};

}  // namespace octavo
