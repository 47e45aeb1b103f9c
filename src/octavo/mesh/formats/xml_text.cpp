#include "octavo/mesh/formats/xml_text.h"

#include "octavo/core/utf8.h"

namespace octavo {

std::string xml_text(std::string_view text) {
  constexpr std::string_view kReplacement = "\xef\xbf\xbd";
  std::string escaped;
  for (std::string_view rest = text; !rest.empty();) {
    const Utf8Piece piece = first_piece(rest);
    const std::string_view character = rest.substr(0, piece.bytes);
    rest.remove_prefix(piece.bytes);
    const char first = character.front();
    const bool is_control = static_cast<unsigned char>(first) < 0x20;
    if (!piece.is_character || character == "\xef\xbf\xbe" || character == "\xef\xbf\xbf") {
      escaped += kReplacement;
    } else if (first == '\n' || first == '\t' || first == '\r') {
      escaped += ' ';
    } else if (is_control) {
      escaped += kReplacement;
    } else if (first == '&') {
      escaped += "&amp;";
    } else if (first == '<') {
      escaped += "&lt;";
    } else if (first == '>') {
      escaped += "&gt;";
    } else if (first == '"') {
      escaped += "&quot;";
    } else {
      escaped += character;
    }
  }
  return escaped;
}

}  // namespace octavo
