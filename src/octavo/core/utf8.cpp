#include "octavo/core/utf8.h"

#include <algorithm>

namespace octavo {

namespace {

struct Lead {
  std::size_t bytes = 0;       // of the character; 0: no character begins so
  std::uint8_t lowest = 0x80;  // second byte
  std::uint8_t highest = 0xbf;
};

Lead lead_of(std::uint8_t byte) noexcept {
  if (byte < 0x80) return {1};
  if (byte < 0xc2) return {0};
  if (byte < 0xe0) return {2};
  if (byte == 0xe0) return {3, 0xa0};
  if (byte == 0xed) return {3, 0x80, 0x9f};
  if (byte < 0xf0) return {3};
  if (byte == 0xf0) return {4, 0x90};
  if (byte < 0xf4) return {4};
  if (byte == 0xf4) return {4, 0x80, 0x8f};
  return {0};
}

}  // namespace

Utf8Piece first_piece(std::string_view text) noexcept {
  const Lead lead = lead_of(static_cast<std::uint8_t>(text.front()));
  if (lead.bytes == 0) return {1, false};
  for (std::size_t i = 1; i < lead.bytes; ++i) {
    if (i == text.size()) return {i, false};
    const auto byte = static_cast<std::uint8_t>(text[i]);
    const bool follows = i == 1 ? byte >= lead.lowest && byte <= lead.highest
                                : byte >= 0x80 && byte <= 0xbf;
    if (!follows) return {i, false};
  }
  return {lead.bytes, true};
}

std::string as_utf8(std::string_view text) {
  std::string valid;
  while (!text.empty()) {
    const Utf8Piece piece = first_piece(text);
    valid += piece.is_character ? text.substr(0, piece.bytes) : "\xef\xbf\xbd";
    text.remove_prefix(piece.bytes);
  }
  return valid;
}

bool is_utf8(std::string_view text) noexcept {
  while (!text.empty()) {
    const Utf8Piece piece = first_piece(text);
    if (!piece.is_character) return false;
    text.remove_prefix(piece.bytes);
  }
  return true;
}

bool has_control(std::string_view text, std::string_view allowed) noexcept {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool is_short = byte < 0x20 || byte == 0x7f;
    if (is_short && allowed.find(text[i]) == std::string_view::npos) return true;
    const bool is_long = byte == 0xc2 && i + 1 < text.size() &&
                         static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (is_long) return true;
  }
  return false;
}

bool turns_text(std::string_view text) noexcept {
  for (std::size_t at = text.find('\xe2'); at < text.size(); at = text.find('\xe2', at + 1)) {
    const std::string_view next = text.substr(at + 1, 2);
    if (next >= "\x80\xa8" && next <= "\x80\xae") return true;
    if (next >= "\x81\xa6" && next <= "\x81\xa9") return true;
  }
  return false;
}

void append_utf8(std::string& text, std::uint32_t character) {
  const auto tail = [&](int shift) {
    return static_cast<char>(0x80 | (character >> shift & 0x3f));
  };
  if (character < 0x80) {
    text += static_cast<char>(character);
  } else if (character < 0x800) {
    text += {static_cast<char>(0xc0 | character >> 6), tail(0)};
  } else if (character < 0x10000) {
    text += {static_cast<char>(0xe0 | character >> 12), tail(6), tail(0)};
  } else {
    text += {static_cast<char>(0xf0 | character >> 18), tail(12), tail(6), tail(0)};
  }
}

std::string utf8_of_latin1(std::string_view text) {
  std::string wide;
  for (const char byte : text) append_utf8(wide, static_cast<std::uint8_t>(byte));
  return wide;
}

std::string_view cut_utf8(std::string_view text, std::size_t max_bytes) noexcept {
  if (text.size() <= max_bytes) return text;
  std::size_t end = max_bytes;
  while (end > 0 && (static_cast<std::uint8_t>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end);
}

}  // namespace octavo
