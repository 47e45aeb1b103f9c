#include "octavo/file/repair/repair_bits.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/layout.h"
#include "octavo/file/open_file.h"
#include "octavo/file/plane_digests.h"
#include "octavo/file/repair/repaired_source.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/file/write/writer.h"

namespace octavo {

namespace {

constexpr std::size_t kScanBytes = std::size_t{1} << 20;

// Damages that one round describes; the next round finds the others.
constexpr std::size_t kListedInARound = std::size_t{1} << 16;

void throw_if_cancelled(const Progress& progress) {
  if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
}

// Why a damage is not turned back.
const char* reason_against(const Damage& damage) {
  if (!damage.flipped_byte) return "more than one flipped bit, which nothing can turn back";
  if (damage.proof == OtherProof::none) {
    return "one flipped bit would explain it, but so would other damage, and nothing else proves "
           "these bytes";
  }
  return "one flipped bit would explain it, but so would other damage of a part this long";
}

[[noreturn]] void reject(const Damage& damage, const std::string& input) {
  throw Error(ErrorKind::corrupt, damage.detail + ": " + reason_against(damage), input,
              damage.offset)
      .with_field("repair.salvage");
}

VerifyReport verified(std::shared_ptr<const ByteSource> source, const BitRepairOptions& options,
                      Progress& progress) {
  VerifyOptions verifying;
  verifying.for_each = options.for_each;
  verifying.max_listed = kListedInARound;
  verifying.make_hasher = options.make_hasher;
  return verify_file(std::move(source), verifying, progress);
}

// The voxel digest that the slab trailers give; zeros where one is damaged, as a later round finds.
Sha256Digest digest_in_slabs(const std::shared_ptr<const ByteSource>& source,
                             const Repairs& repairs) {
  try {
    return voxel_digest_of(OpenFile(std::make_shared<RepairedSource>(source, repairs), {})
                               .plane_digests());
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::corrupt) return {};
    throw;
  }
}

// Gives a trailer that is made anew what follows from the rest of the file: the checksum of all
// bytes between header and trailer, and the digest of the voxels.
void complete_trailer(const std::shared_ptr<const ByteSource>& source, Repairs& repairs,
                      Progress& progress) {
  const RepairedSource repaired(source, repairs);
  HeaderBlock block{};
  repaired.read(0, block);
  const FileHeader header = parse_header(block, repaired.size());
  const std::uint64_t end = repaired.size() - kTrailerBytes;
  const ProgressScope scope(progress, "reading", static_cast<std::int64_t>(end - kHeaderBytes),
                            "bytes");
  std::uint32_t crc = 0;
  Bytes buffer;
  for (std::uint64_t at = kHeaderBytes; at < end; at += kScanBytes) {
    throw_if_cancelled(progress);
    buffer.resize(std::min<std::uint64_t>(kScanBytes, end - at));
    repaired.read(at, buffer);
    crc = crc32c(buffer, crc);
    progress.advance(static_cast<std::int64_t>(buffer.size()));
  }
  repairs.trailer = encode_trailer({header.build_id, header.file_bytes, load_header_crc(block), crc,
                                    digest_in_slabs(source, repairs)});
}

// What makes the file sound. A damaged index page hides damaged bricks, a damaged model those that
// do not decode: each round finds what the flips of those before brought to light.
Repairs all_repairs(const std::shared_ptr<const ByteSource>& source,
                    const BitRepairOptions& options, Progress& progress) {
  Repairs repairs = repair_envelope(*source);
  for (;;) {
    if (repairs.trailer) complete_trailer(source, repairs, progress);
    const VerifyReport report =
        verified(std::make_shared<RepairedSource>(source, repairs), options, progress);
    if (report.is_sound()) return repairs;
    std::vector<BitFlip> flips;
    for (const Damage& damage : report.damages) {
      if (!damage.is_repairable()) reject(damage, source->name());
      flips.push_back({*damage.flipped_byte, damage.flipped_bit});
    }
    const std::size_t count = repairs.flips.size();
    add_flips(repairs, flips);
    if (repairs.flips.size() == count) reject(report.damages.front(), source->name());
  }
}

void copy(const ByteSource& source, StorageFile& out, Progress& progress) {
  const ProgressScope scope(progress, "writing", static_cast<std::int64_t>(source.size()), "bytes");
  Bytes buffer(kScanBytes);
  for (std::uint64_t at = 0; at < source.size(); at += kScanBytes) {
    throw_if_cancelled(progress);
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(kScanBytes, source.size() - at));
    const auto part = std::span(buffer).first(count);
    source.read(at, part);
    out.write(at, part);
    progress.advance(static_cast<std::int64_t>(count));
  }
}

void prove(Storage& storage, const PendingFile& file, const BitRepairOptions& options,
           Progress& progress) {
  const VerifyReport report =
      verified(open_byte_source(storage, file.temporary_path()), options, progress);
  if (report.is_sound()) return;
  throw Error(ErrorKind::io,
              "reads back otherwise than it was written: " + report.damages.front().detail,
              file.path());
}

void write_repaired(Storage& storage, const ByteSource& source, const std::string& output,
                    const BitRepairOptions& options, Progress& progress) {
  try {
    PendingFile file(storage, output);
    copy(source, file.file(), progress);
    file.seal();
    prove(storage, file, options, progress);
    file.publish(options.overwrite);
  } catch (const Error& error) {
    throw with_final_name(error, output);
  }
}

}  // namespace

bool opens_repaired(const std::shared_ptr<const ByteSource>& source) {
  try {
    const OpenFile proof(std::make_shared<RepairedSource>(source, repair_envelope(*source)), {});
    return true;
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::io) throw;
    return false;
  }
}

BitRepairResult repair_bits(Storage& storage, const std::string& input, const std::string& output,
                            const BitRepairOptions& options, Progress& progress) {
  check_target(storage, output, options.overwrite);
  if (!options.overwrite) reject_interrupted(storage, output);
  const std::shared_ptr<const ByteSource> source = open_byte_source(storage, input);
  const Repairs repairs = all_repairs(source, options, progress);
  BitRepairResult result;
  result.flips = repairs.flips;
  result.has_new_trailer = repairs.trailer.has_value();
  result.dropped_bytes = source->size() - repairs.size;
  result.file_bytes = repairs.size;
  if (result.is_sound()) return result;
  write_repaired(storage, RepairedSource(source, repairs), output, options, progress);
  return result;
}

}  // namespace octavo
