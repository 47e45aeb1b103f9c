// Directories of arbitrary bytes: one that is read fills what it shall, and is written as it was.
//
//     u8 choice | u64 end of the index pages | u64 start of the directory | entries

#include "fuzz/fuzz_target.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/directory.h"

namespace {

using namespace octavo;

constexpr std::uint8_t kIsTiled = 1;
constexpr std::size_t kOffsetAt = 8;
constexpr std::size_t kLengthAt = 16;

/// Moves the parts so that they follow each other; returns where they end.
std::uint64_t tile(Bytes& bytes, std::uint64_t at) {
  for (std::size_t entry = 0; entry + kPartEntryBytes <= bytes.size(); entry += kPartEntryBytes) {
    store_little_endian(at, bytes.data() + entry + kOffsetAt);
    at += load_little_endian<std::uint64_t>(bytes.data() + entry + kLengthAt);
  }
  return at;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const auto choice = input.take<std::uint8_t>();
  FileHeader header;
  header.pages.offset = input.take<std::uint64_t>();
  header.directory.offset = input.take<std::uint64_t>();
  Bytes bytes = input.take_bytes(input.left());
  if (choice & kIsTiled) header.directory.offset = tile(bytes, header.pages.end());
  // As parse_header proves it
  if (header.directory.offset < header.pages.end()) return 0;
  fuzz::expect_error_or_success([&] {
    const std::vector<PartEntry> entries = parse_directory(bytes, header);
    std::uint64_t at = header.pages.end();
    for (const PartEntry& entry : entries) {
      fuzz::require(entry.bytes.offset == at, "a gap between parts");
      at = entry.bytes.end();
      fuzz::require(name_of(entry.tag).size() == 11, "a tag of another length");
    }
    fuzz::require(at == header.directory.offset, "parts that end elsewhere");
    fuzz::require(encode_directory(entries) == bytes, "another directory");
  });
  return 0;
}
