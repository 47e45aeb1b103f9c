#include "octavo/file/mend.h"

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

#include "octavo/codec/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/interrupted.h"
#include "octavo/file/layout.h"
#include "octavo/file/temporary.h"
#include "octavo/file/writer.h"

namespace octavo {

namespace {

constexpr std::size_t kCopyBytes = std::size_t{1} << 20;

// A source with some bits turned round.
class FlippedSource final : public ByteSource {
 public:
  FlippedSource(std::shared_ptr<const ByteSource> inner, std::vector<BitFlip> flips)
      : inner_(std::move(inner)), flips_(std::move(flips)) {}

  std::uint64_t size() const override { return inner_->size(); }
  const std::string& name() const override { return inner_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    inner_->read(offset, out);
    for (const BitFlip& flip : flips_) {
      if (flip.byte < offset || flip.byte - offset >= out.size()) continue;
      out[static_cast<std::size_t>(flip.byte - offset)] ^=
          static_cast<std::uint8_t>(1 << flip.bit);
    }
  }

 private:
  std::shared_ptr<const ByteSource> inner_;
  std::vector<BitFlip> flips_;
};

// The flip, if one is needed and will do, in bytes that end in their own checksum.
void mend_block(const ByteSource& source, std::uint64_t offset, std::uint64_t length,
                std::vector<BitFlip>& flips) {
  Bytes bytes(static_cast<std::size_t>(length));
  source.read(offset, bytes);
  const std::size_t end = bytes.size() - sizeof(std::uint32_t);
  const std::uint32_t found = crc32c(ByteSpan(bytes).first(end));
  const auto stored = load_little_endian<std::uint32_t>(bytes.data() + end);
  if (found == stored) return;
  const auto flip = locate_bit_flip(found, stored, {offset, end, offset + end});
  if (flip) flips.push_back(*flip);
}

void mend_section(const ByteSource& source, const Section& section, std::vector<BitFlip>& flips) {
  Bytes bytes(static_cast<std::size_t>(section.length));
  source.read(section.offset, bytes);
  const std::uint32_t found = crc32c(bytes);
  if (found == section.crc) return;
  const auto flip = locate_bit_flip(found, section.crc, {section.offset, section.length});
  if (flip) flips.push_back(*flip);
}

// Refuses the header of a file that was still growing.
void refuse_growing(const HeaderBlock& block, const std::string& input) {
  if (encode_header(parse_unsealed_header(block)) != block) return;
  throw Error(ErrorKind::corrupt,
              "not sealed, and without the journal of its build, in which its coarse levels stood: "
              "nothing can be repaired; build it again from its source",
              input);
}

// The flips without which nothing in the file can be found: in header, trailer, metadata and root.
std::vector<BitFlip> envelope_flips(const std::shared_ptr<const ByteSource>& source) {
  std::vector<BitFlip> flips;
  if (source->size() < kHeaderBytes) return flips;
  mend_block(*source, 0, kHeaderBytes, flips);
  HeaderBlock block{};
  FlippedSource(source, flips).read(0, block);
  refuse_growing(block, source->name());
  if (source->size() < kHeaderBytes + kTrailerBytes) return flips;
  const FileHeader header = parse_header(block, source->size());
  mend_block(*source, source->size() - kTrailerBytes, kTrailerBytes, flips);
  mend_section(*source, header.metadata, flips);
  mend_section(*source, header.root, flips);
  return flips;
}

bool comes_before(const BitFlip& a, const BitFlip& b) {
  return std::tie(a.byte, a.bit) < std::tie(b.byte, b.bit);
}

// The flips, and every bit that explains a damage, once: one can be met by several checksums.
std::vector<BitFlip> with_flips_of(const VerifyReport& report, std::vector<BitFlip> flips) {
  for (const Damage& damage : report.damages) {
    if (damage.flipped_byte) flips.push_back({*damage.flipped_byte, damage.flipped_bit});
  }
  std::ranges::sort(flips, comes_before);
  const auto same = [](const BitFlip& a, const BitFlip& b) {
    return !comes_before(a, b) && !comes_before(b, a);
  };
  flips.erase(std::unique(flips.begin(), flips.end(), same), flips.end());
  return flips;
}

[[noreturn]] void refuse(const Damage& damage, const std::string& input) {
  throw Error(ErrorKind::corrupt,
              damage.detail + ": more than one flipped bit, which nothing can turn back; export "
                              "--salvage writes what is whole",
              input, damage.offset);
}

VerifyReport verified(std::shared_ptr<const ByteSource> source, const MendOptions& options,
                      Progress& progress) {
  VerifyOptions verifying;
  verifying.for_each = options.for_each;
  return verify_file(std::move(source), verifying, progress);
}

void copy(const ByteSource& source, StorageFile& out) {
  Bytes buffer(kCopyBytes);
  for (std::uint64_t at = 0; at < source.size(); at += kCopyBytes) {
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(kCopyBytes, source.size() - at));
    const auto part = std::span(buffer).first(count);
    source.read(at, part);
    out.write(at, part);
  }
}

}  // namespace

MendResult mend_file(Storage& storage, const std::string& input, const std::string& output,
                     const MendOptions& options, Progress& progress) {
  check_target(storage, output, options.overwrite);
  if (!options.overwrite) refuse_interrupted(storage, output);
  const std::shared_ptr<const ByteSource> source = open_byte_source(storage, input);
  MendResult result;
  result.file_bytes = source->size();
  result.flips = envelope_flips(source);
  const VerifyReport report =
      verified(std::make_shared<FlippedSource>(source, result.flips), options, progress);
  if (report.is_sound() && result.flips.empty()) return result;
  result.flips = with_flips_of(report, std::move(result.flips));
  if (result.flips.empty()) refuse(report.damages.front(), input);

  TemporaryFile temporary = create_temporary(storage, output);
  try {
    copy(FlippedSource(source, result.flips), *temporary.file);
    temporary.file->sync();
    const VerifyReport left =
        verified(open_byte_source(storage, temporary.path), options, progress);
    if (!left.is_sound()) refuse(left.damages.front(), input);
    temporary.file->close();
    if (options.overwrite) {
      storage.rename(temporary.path, output);
    } else {
      storage.rename_new(temporary.path, output);
    }
  } catch (...) {
    storage.remove(temporary.path);
    throw;
  }
  storage.sync_folder(folder_of(output));
  return result;
}

}  // namespace octavo
