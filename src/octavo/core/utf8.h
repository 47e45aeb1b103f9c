// The characters of UTF-8 text that may be damaged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace octavo {

/// What stands at the beginning of a text: a character, or bytes that begin one and break off.
struct Utf8Piece {
  std::size_t bytes = 0;
  bool is_character = false;
};

/// Requires a text that is not empty. No overlong forms, no surrogates, nothing above U+10FFFF.
Utf8Piece first_piece(std::string_view text) noexcept;

/// `text` with U+FFFD in place of every piece that is no character.
std::string as_utf8(std::string_view text);

bool is_utf8(std::string_view text) noexcept;

/// Whether UTF-8 holds a control character, U+0000 to U+001F or U+007F to U+009F; those of
/// `allowed`, which are of one byte, do not count.
bool has_control(std::string_view text, std::string_view allowed = {}) noexcept;

/// Whether UTF-8 holds a character that changes the direction of what follows, or ends a line:
/// U+2028 to U+202E, U+2066 to U+2069.
bool turns_text(std::string_view text) noexcept;

/// Appends the character with this number. Requires one of Unicode, no surrogate.
void append_utf8(std::string& text, std::uint32_t character);

/// Latin-1 as UTF-8.
std::string utf8_of_latin1(std::string_view text);

/// The beginning of UTF-8 `text`, at most max_bytes of it and whole characters.
std::string_view cut_utf8(std::string_view text, std::size_t max_bytes) noexcept;

}  // namespace octavo
