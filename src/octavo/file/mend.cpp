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
#include "octavo/file/open_file.h"
#include "octavo/file/temporary.h"
#include "octavo/file/writer.h"

namespace octavo {

namespace {

constexpr std::size_t kCopyBytes = std::size_t{1} << 20;

// Damages that one round describes; the next round finds the others.
constexpr std::size_t kListedInARound = std::size_t{1} << 16;

bool comes_before(const BitFlip& a, const BitFlip& b) {
  return std::tie(a.byte, a.bit) < std::tie(b.byte, b.bit);
}

// A source with some bits, in the order of the file, turned round.
class FlippedSource final : public ByteSource {
 public:
  FlippedSource(std::shared_ptr<const ByteSource> inner, std::vector<BitFlip> flips)
      : inner_(std::move(inner)), flips_(std::move(flips)) {}

  std::uint64_t size() const override { return inner_->size(); }
  const std::string& name() const override { return inner_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    inner_->read(offset, out);
    auto flip = std::ranges::lower_bound(flips_, BitFlip{offset, 0}, comes_before);
    for (; flip != flips_.end() && flip->byte - offset < out.size(); ++flip) {
      out[static_cast<std::size_t>(flip->byte - offset)] ^=
          static_cast<std::uint8_t>(1 << flip->bit);
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

void mend_root(const ByteSource& source, const Section& section, std::vector<BitFlip>& flips) {
  Bytes bytes(static_cast<std::size_t>(section.length));
  source.read(section.offset, bytes);
  const std::uint32_t found = crc32c(bytes);
  if (found == section.crc) return;
  const auto flip = locate_bit_flip(found, section.crc, {section.offset, section.length});
  if (flip) flips.push_back(*flip);
}

// What the metadata say is proven by nothing else; but they are text.
void mend_metadata(const ByteSource& source, const Section& section, std::vector<BitFlip>& flips) {
  if (!is_safe_guess(section.length, OtherProof::content)) return;
  Bytes bytes(static_cast<std::size_t>(section.length));
  source.read(section.offset, bytes);
  const auto flip = find_bit_flip(crc32c(bytes), section.crc, section.length);
  if (!flip) return;
  bytes[static_cast<std::size_t>(flip->byte)] ^= static_cast<std::uint8_t>(1 << flip->bit);
  if (is_text(bytes)) flips.push_back({section.offset + flip->byte, flip->bit});
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
  mend_metadata(*source, header.metadata, flips);
  mend_root(*source, header.root, flips);
  std::ranges::sort(flips, comes_before);
  return flips;
}

// The flips, and every bit that explains a damage, once: one can be met by several checksums.
std::vector<BitFlip> with_flips_of(const VerifyReport& report, std::vector<BitFlip> flips) {
  for (const Damage& damage : report.damages) {
    flips.push_back({*damage.flipped_byte, damage.flipped_bit});
  }
  std::ranges::sort(flips, comes_before);
  const auto same = [](const BitFlip& a, const BitFlip& b) {
    return !comes_before(a, b) && !comes_before(b, a);
  };
  flips.erase(std::unique(flips.begin(), flips.end(), same), flips.end());
  return flips;
}

[[noreturn]] void refuse(const Damage& damage, const std::string& input) {
  const char* reason = damage.flipped_byte
                           ? "one flipped bit would explain it, but so would other damage of a "
                             "part this long"
                           : "more than one flipped bit, which nothing can turn back";
  throw Error(ErrorKind::corrupt,
              damage.detail + ": " + reason + "; export --salvage writes what is whole", input,
              damage.offset);
}

VerifyReport verified(std::shared_ptr<const ByteSource> source, const MendOptions& options,
                      Progress& progress) {
  VerifyOptions verifying;
  verifying.for_each = options.for_each;
  verifying.max_listed = kListedInARound;
  return verify_file(std::move(source), verifying, progress);
}

// The flips that make the file sound. A damaged index page hides damaged bricks, a damaged model
// those that do not decode: each round finds what the flips of those before brought to light.
std::vector<BitFlip> all_flips(const std::shared_ptr<const ByteSource>& source,
                               const MendOptions& options, Progress& progress) {
  std::vector<BitFlip> flips = envelope_flips(source);
  for (;;) {
    const VerifyReport report =
        verified(std::make_shared<FlippedSource>(source, flips), options, progress);
    if (report.is_sound()) return flips;
    for (const Damage& damage : report.damages) {
      if (!damage.is_mendable()) refuse(damage, source->name());
    }
    const std::size_t count = flips.size();
    flips = with_flips_of(report, std::move(flips));
    if (flips.size() == count) refuse(report.damages.front(), source->name());
  }
}

void copy(const ByteSource& source, StorageFile& out, Progress& progress) {
  const ProgressScope scope(progress, "writing", static_cast<std::int64_t>(source.size()),
                            "bytes");
  Bytes buffer(kCopyBytes);
  for (std::uint64_t at = 0; at < source.size(); at += kCopyBytes) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(kCopyBytes, source.size() - at));
    const auto part = std::span(buffer).first(count);
    source.read(at, part);
    out.write(at, part);
    progress.advance(static_cast<std::int64_t>(count));
  }
}

// The copy while it grows; gone with this object unless it took its name.
class GrowingCopy {
 public:
  GrowingCopy(Storage& storage, const std::string& output)
      : storage_(storage), output_(output), temporary_(create_temporary(storage, output)) {}
  GrowingCopy(const GrowingCopy&) = delete;
  GrowingCopy& operator=(const GrowingCopy&) = delete;
  ~GrowingCopy() {
    if (is_published_) return;
    temporary_.file.reset();
    remove_silently(temporary_.path);
  }

  void write(const ByteSource& source, Progress& progress) {
    copy(source, *temporary_.file, progress);
    temporary_.file->sync();
  }

  void prove(const MendOptions& options, Progress& progress) {
    const VerifyReport report =
        verified(open_byte_source(storage_, temporary_.path), options, progress);
    if (report.is_sound()) return;
    throw Error(ErrorKind::io,
                "reads back otherwise than it was written: " + report.damages.front().detail,
                output_);
  }

  void publish(bool overwrite) {
    temporary_.file->close();
    const bool replaces = overwrite && storage_.exists(output_);
    if (overwrite) {
      storage_.rename(temporary_.path, output_);
    } else {
      storage_.rename_new(temporary_.path, output_);
    }
    is_published_ = true;
    try {
      storage_.sync_folder(folder_of(output_));
    } catch (...) {
      if (!replaces) remove_silently(output_);
      throw;
    }
  }

 private:
  // The failure that led here is the one to be told.
  void remove_silently(const std::string& path) noexcept {
    try {
      storage_.remove(path);
    } catch (...) {
    }
  }

  Storage& storage_;
  const std::string& output_;
  TemporaryFile temporary_;
  bool is_published_ = false;
};

void write_mended(Storage& storage, const ByteSource& source, const std::string& output,
                  const MendOptions& options, Progress& progress) {
  try {
    GrowingCopy growing(storage, output);
    growing.write(source, progress);
    growing.prove(options, progress);
    growing.publish(options.overwrite);
  } catch (const Error& error) {
    if (!error.path().starts_with(temporary_prefix(output))) throw;
    throw Error(error.kind(), error.detail(), output, error.offset());
  }
}

}  // namespace

bool opens_mended(const std::shared_ptr<const ByteSource>& source) {
  try {
    const OpenFile proof(std::make_shared<FlippedSource>(source, envelope_flips(source)), {});
    return true;
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::io) throw;
    return false;
  }
}

MendResult mend_file(Storage& storage, const std::string& input, const std::string& output,
                     const MendOptions& options, Progress& progress) {
  check_target(storage, output, options.overwrite);
  if (!options.overwrite) refuse_interrupted(storage, output);
  const std::shared_ptr<const ByteSource> source = open_byte_source(storage, input);
  MendResult result;
  result.file_bytes = source->size();
  result.flips = all_flips(source, options, progress);
  if (result.flips.empty()) return result;
  write_mended(storage, FlippedSource(source, result.flips), output, options, progress);
  return result;
}

}  // namespace octavo
