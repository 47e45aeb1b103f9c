#include "octavo/file/repair/repaired_source.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/directory.h"

namespace octavo {

namespace {

bool comes_before(const BitFlip& a, const BitFlip& b) {
  return std::tie(a.byte, a.bit) < std::tie(b.byte, b.bit);
}

void turn_round(const BitFlip& flip, std::uint64_t offset, std::span<std::uint8_t> bytes) {
  bytes[static_cast<std::size_t>(flip.byte - offset)] ^= static_cast<std::uint8_t>(1 << flip.bit);
}

// Turns the bit back, if one is needed and will do, in bytes that end in their own checksum.
// Returns  whether the checksum matches then
bool repair_block(std::span<std::uint8_t> bytes, std::uint64_t offset,
                  std::vector<BitFlip>& flips) {
  const std::size_t end = bytes.size() - sizeof(std::uint32_t);
  const std::uint32_t found = crc32c(bytes.first(end));
  const auto stored = load_little_endian<std::uint32_t>(bytes.data() + end);
  if (found == stored) return true;
  const auto flip = locate_bit_flip(found, stored, {offset, end, offset + end});
  if (!flip) return false;
  turn_round(*flip, offset, bytes);
  flips.push_back(*flip);
  return true;
}

// UTF-8 without control characters but line ends and tabs.
bool is_text(ByteSpan bytes) {
  std::size_t following = 0;
  for (const std::uint8_t byte : bytes) {
    const bool follows = (byte & 0xc0) == 0x80;
    if (follows != (following > 0)) return false;
    if (follows) {
      --following;
    } else if (byte < 0x80) {
      if (byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r') return false;
    } else if (byte > 0xf4) {
      return false;
    } else {
      following = byte >= 0xf0 ? 3 : byte >= 0xe0 ? 2 : 1;
    }
  }
  return following == 0;
}

void repair_root(const ByteSource& source, const Section& section, std::vector<BitFlip>& flips) {
  const Bytes bytes = read_arriving(source, section.offset, section.length);
  const std::uint32_t found = crc32c(bytes);
  if (found == section.crc) return;
  const auto flip = locate_bit_flip(found, section.crc, {section.offset, section.length});
  if (flip) flips.push_back(*flip);
}

// What the metadata say is proven by nothing else; but they are text.
void repair_metadata(const ByteSource& source, const Section& section,
                     std::vector<BitFlip>& flips) {
  if (!is_safe_guess(section.length, OtherProof::content)) return;
  Bytes bytes = read_arriving(source, section.offset, section.length);
  const auto flip = find_bit_flip(crc32c(bytes), section.crc, section.length);
  if (!flip) return;
  turn_round(*flip, 0, bytes);
  if (is_text(bytes)) flips.push_back({section.offset + flip->byte, flip->bit});
}

// Whether the bytes parse as the directory of the file, though this program may not know a part.
bool is_directory(ByteSpan bytes, const FileHeader& header) {
  try {
    parse_directory(bytes, header);
    return true;
  } catch (const Error& error) {
    return error.kind() == ErrorKind::unsupported_version;
  }
}

// Tags are proven by nothing else; but parts tile the file.
void repair_directory(const ByteSource& source, const FileHeader& header,
                      std::vector<BitFlip>& flips) {
  const Section& section = header.directory;
  if (!is_safe_guess(section.length, OtherProof::content)) return;
  Bytes bytes = read_arriving(source, section.offset, section.length);
  const auto flip = find_bit_flip(crc32c(bytes), section.crc, section.length);
  if (!flip) return;
  turn_round(*flip, 0, bytes);
  if (is_directory(bytes, header)) flips.push_back({section.offset + flip->byte, flip->bit});
}

// Rejects the header of a file that was still growing.
void reject_growing(const HeaderBlock& block, const std::string& input) {
  if (encode_header(parse_unsealed_header(block)) != block) return;
  throw Error(ErrorKind::corrupt,
              "not sealed, and without the journal of its build, in which its coarse levels stood: "
              "nothing can be repaired; build it again from its source",
              input)
      .with_field("repair.source");
}

// A whole trailer that does not belong to the header stays: one of the two is wrong, and nothing
// says which.
void repair_trailer(const ByteSource& source, const FileHeader& header, Repairs& repairs) {
  TrailerBlock block{};
  const std::uint64_t offset = header.file_bytes - kTrailerBytes;
  source.read(offset, block);
  std::vector<BitFlip> flips;
  if (repair_block(block, offset, flips)) {
    add_flips(repairs, flips);
  } else {
    repairs.trailer = encode_trailer({header.build_id, header.file_bytes, header.crc, 0, {}});
  }
}

Repairs repairs_of(const ByteSource& source) {
  Repairs repairs;
  repairs.size = source.size();
  if (repairs.size < kHeaderBytes) return repairs;
  HeaderBlock block{};
  source.read(0, block);
  std::vector<BitFlip> flips;
  repair_block(block, 0, flips);
  reject_growing(block, source.name());
  repairs.size = std::min(repairs.size, load_file_bytes(block));
  const FileHeader header = parse_header(block, repairs.size);
  repair_metadata(source, header.metadata, flips);
  repair_root(source, header.root, flips);
  repair_directory(source, header, flips);
  add_flips(repairs, flips);
  repair_trailer(source, header, repairs);
  return repairs;
}

}  // namespace

void add_flips(Repairs& repairs, const std::vector<BitFlip>& flips) {
  repairs.flips.insert(repairs.flips.end(), flips.begin(), flips.end());
  std::ranges::sort(repairs.flips, comes_before);
  const auto is_same = [](const BitFlip& a, const BitFlip& b) {
    return !comes_before(a, b) && !comes_before(b, a);
  };
  const auto end = std::unique(repairs.flips.begin(), repairs.flips.end(), is_same);
  repairs.flips.erase(end, repairs.flips.end());
}

Repairs repair_envelope(const ByteSource& source) {
  try {
    return repairs_of(source);
  } catch (const Error& error) {
    throw error.with_path(source.name());
  }
}

RepairedSource::RepairedSource(std::shared_ptr<const ByteSource> inner, Repairs repairs)
    : inner_(std::move(inner)), repairs_(std::move(repairs)) {}

void RepairedSource::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
  inner_->read(offset, out);
  const auto& flips = repairs_.flips;
  auto flip = std::ranges::lower_bound(flips, BitFlip{offset, 0}, comes_before);
  for (; flip != flips.end() && flip->byte - offset < out.size(); ++flip) {
    turn_round(*flip, offset, out);
  }
  if (!repairs_.trailer) return;
  const std::uint64_t start = repairs_.size - kTrailerBytes;
  for (std::uint64_t at = std::max(start, offset); at < offset + out.size(); ++at) {
    out[static_cast<std::size_t>(at - offset)] =
        (*repairs_.trailer)[static_cast<std::size_t>(at - start)];
  }
}

}  // namespace octavo
