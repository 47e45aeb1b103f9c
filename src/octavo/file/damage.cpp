#include "octavo/file/damage.h"

#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/file/open_file.h"
#include "octavo/file/slab_trailer.h"

namespace octavo {

namespace {

// "brick o-code 0x1a3 level 5 at byte 81920", "index page 3 of tier 0 at byte 4711", ..
std::string place_text(const Damage& place) {
  if (place.what == "brick") {
    return describe(Piece{place.offset, place.length, 0, place.level, place.code});
  }
  const bool is_numbered = place.what == "model" || place.what == "index page" ||
                           place.what == kSlabTrailer || place.what == "plane";
  std::string text = place.what;
  if (is_numbered) text += " " + std::to_string(place.code);
  if (place.what == "index page") text += " of tier " + std::to_string(place.tier);
  return text + " at byte " + std::to_string(place.offset);
}

}  // namespace

Damage damaged(Damage place, const std::string& problem) {
  const std::string name = place.what + ": ";
  const bool has_name = problem.compare(0, name.size(), name) == 0;
  place.detail = place_text(place) + ": " + (has_name ? problem.substr(name.size()) : problem);
  return place;
}

std::optional<Damage> checksum_damage(Damage place, std::uint32_t found, std::uint32_t stored,
                                      const CheckedBytes& checked) {
  if (checksum_matches(found, stored)) return std::nullopt;
  place.found = found;
  place.stored = stored;
  if (const auto flip = locate_bit_flip(found, stored, checked)) {
    place.flipped_byte = flip->byte;
    place.flipped_bit = flip->bit;
  }
  return damaged(std::move(place), describe_checksums(found, stored, checked));
}

std::optional<Damage> checksum_damage(const Damage& place, std::uint32_t found,
                                      std::uint32_t stored) {
  return checksum_damage(place, found, stored, {place.offset, place.length});
}

void require_damage(const Error& error) {
  if (error.kind() == ErrorKind::corrupt || error.kind() == ErrorKind::limit_exceeded) return;
  throw error;
}

}  // namespace octavo
