// Journals of arbitrary records: whatever is read of one is written again and read as before.
//
//     a record after the other: u8 type | u8 stream | u16 length | payload

#include <algorithm>
#include <cstring>

#include "fuzz/fuzz_target.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/write/journal.h"

namespace {

using namespace octavo;

constexpr std::size_t kFrameBytes = 20;
constexpr std::size_t kCrcAt = 16;
/// Types from here on have the length that the payload has less 1, and a checksum all the same.
constexpr std::uint8_t kIsCut = 0x80;

class BytesFile final : public StorageFile {
 public:
  explicit BytesFile(Bytes& bytes) : bytes_(bytes) {}
  const std::string& path() const override { return path_; }
  std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset) {
      throw Error(ErrorKind::truncated, "the file ends before", path_, offset);
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
  }
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes) override {
    bytes_.resize(std::max<std::size_t>(bytes_.size(), offset + bytes.size()));
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  void truncate(std::uint64_t size) override {
    bytes_.resize(std::min<std::size_t>(bytes_.size(), size));
  }
  void sync() override {}
  void close() override {}

 private:
  Bytes& bytes_;
  std::string path_ = "journal";
};

/// Appends a record whose checksum fits.
void append_record(Bytes& journal, std::uint8_t type, std::uint8_t stream, const Bytes& payload) {
  const std::size_t at = journal.size();
  Bytes frame(kFrameBytes);
  store_little_endian(std::uint32_t{type} & ~std::uint32_t{kIsCut}, frame.data());
  store_little_endian(std::uint32_t{stream}, frame.data() + 4);
  const std::uint64_t cut = type & kIsCut && !payload.empty() ? 1 : 0;
  store_little_endian(payload.size() - cut, frame.data() + 8);
  Bytes place(8);
  store_little_endian(std::uint64_t{at}, place.data());
  const std::uint32_t head = crc32c(ByteSpan(frame).first(kCrcAt), crc32c(place));
  store_little_endian(crc32c(ByteSpan(payload).first(payload.size() - cut), head),
                      frame.data() + kCrcAt);
  journal.insert(journal.end(), frame.begin(), frame.end());
  journal.insert(journal.end(), payload.begin(), payload.end());
}

Bytes take_journal(fuzz::Input& input) {
  Bytes journal;
  while (input.left() > 0) {
    const auto type = input.take<std::uint8_t>();
    const auto stream = input.take<std::uint8_t>();
    append_record(journal, type, stream, input.take_bytes(input.take<std::uint16_t>()));
  }
  return journal;
}

Bytes written_again(const Bytes& journal, const JournalHead& head,
                    const std::vector<WholeGroup>& groups) {
  Bytes bytes;
  Journal again(std::make_unique<BytesFile>(bytes), head);
  for (const WholeGroup& whole : groups) {
    for (const JournalBlock& block : whole.blocks) {
      again.append_block(block.stream, ByteSpan(journal).subspan(block.offset, block.length));
    }
    again.append_group(whole.group);
  }
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  Bytes journal = take_journal(input);
  fuzz::expect_error_or_success([&] {
    const BytesFile file(journal);
    const auto head = read_journal_head(file);
    const std::vector<WholeGroup> groups = read_journal_groups(file);
    if (!head) return;
    for (const WholeGroup& whole : groups) {
      fuzz::require(whole.journal_end <= journal.size(), "a group beyond the end");
    }
    Bytes again = written_again(journal, *head, groups);
    const BytesFile reread(again);
    const auto same_head = read_journal_head(reread);
    fuzz::require(same_head && same_head->settings == head->settings &&
                      same_head->header == head->header && same_head->metadata == head->metadata,
                  "another head");
    const std::vector<WholeGroup> same = read_journal_groups(reread);
    fuzz::require(same.size() == groups.size(), "another number of groups");
    fuzz::require(written_again(again, *same_head, same) == again, "a journal that changes");
  });
  return 0;
}
