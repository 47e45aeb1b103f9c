// Parts of arbitrary bytes: a part opens or is rejected, its streams lie within it, and what it
// says of its groups is proven before it is used.
//
//     u16 planes of the volume | u16 first layer | a part, whose checksums are computed anew

#include <algorithm>
#include <memory>

#include "fuzz/fuzz_target.h"
#include "octavo/builder/build_setup.h"
#include "octavo/core/crc32c.h"
#include "octavo/dist/part_file.h"
#include "octavo/file/byte_codec.h"
#include "support/memory_storage.h"

namespace {

using namespace octavo;
using fuzz::require;

constexpr std::size_t kTailOffsetAt = 36;
constexpr std::size_t kTailLengthAt = 44;
constexpr std::size_t kTailCrcAt = 52;
constexpr std::size_t kHeadCrcAt = kHeaderBytes - 4;

/// Makes the tail reach to the end, and the checksums fit.
void settle(Bytes& part) {
  if (part.size() < kHeaderBytes) return;
  const auto at = load_little_endian<std::uint64_t>(part.data() + kTailOffsetAt);
  const std::uint64_t tail = std::clamp<std::uint64_t>(at, kHeaderBytes, part.size());
  store_little_endian(tail, part.data() + kTailOffsetAt);
  store_little_endian(part.size() - tail, part.data() + kTailLengthAt);
  store_little_endian(crc32c(ByteSpan(part).subspan(static_cast<std::size_t>(tail))),
                      part.data() + kTailCrcAt);
  store_little_endian(crc32c(ByteSpan(part).first(kHeadCrcAt)), part.data() + kHeadCrcAt);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  VolumeDescription description;
  description.size = {100, 70, 1 + input.take<std::uint16_t>()};
  const std::int64_t first_layer = input.take<std::uint16_t>();
  testing::MemoryStorage storage;
  const auto bytes = std::make_shared<Bytes>(input.take_bytes(input.left()));
  settle(*bytes);
  storage.files["part"] = bytes;
  fuzz::expect_error_or_success([&] {
    const auto part = PartFile::open(storage, "part");
    const PartPlace& place = part->place();
    require(place.end_group - place.first_group ==
                static_cast<std::int64_t>(part->groups().size()),
            "other groups than its head says");
    require(part->stream_bytes() <= bytes->size(), "streams beyond the end");
    for (std::size_t stream = 0; stream < part->stream_count(); ++stream) {
      std::uint64_t copied = 0;
      fuzz::expect_error_or_success([&] {
        part->copy(stream, [&](ByteSpan block) { copied += block.size(); });
      });
      require(copied == part->stream(stream).length, "a stream of another length");
    }
    part->require_groups(levels_of(description), first_layer);
    const double squared = part->add_errors(0);
    const bool is_sum = part->groups().empty() || squared != squared ||
                        part->groups().back().squared_error == squared;
    require(is_sum, "another sum of errors");
  });
  return 0;
}
