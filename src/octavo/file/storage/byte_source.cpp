#include "octavo/file/storage/byte_source.h"

#include <algorithm>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

class MemorySource final : public ByteSource {
 public:
  MemorySource(std::vector<std::uint8_t> bytes, std::string name)
      : bytes_(std::move(bytes)), name_(std::move(name)) {}

  std::uint64_t size() const override { return bytes_.size(); }
  const std::string& name() const override { return name_; }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset) {
      throw Error(ErrorKind::truncated, "ends before the bytes that are needed", name_, offset);
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
  }

 private:
  std::vector<std::uint8_t> bytes_;
  std::string name_;
};

constexpr std::uint64_t kFirstPartBytes = std::uint64_t{1} << 20;

}  // namespace

std::vector<ByteRange> ByteSource::missing(std::span<const ByteRange> /*ranges*/) const {
  return {};
}

std::vector<std::uint8_t> read_arriving(const ByteSource& source, std::uint64_t offset,
                                        std::uint64_t length) {
  std::vector<std::uint8_t> bytes;
  read_arriving(source, offset, length, bytes);
  return bytes;
}

void read_arriving(const ByteSource& source, std::uint64_t offset, std::uint64_t length,
                   std::vector<std::uint8_t>& bytes) {
  bytes.clear();
  while (bytes.size() < length) {
    const std::size_t have = bytes.size();
    const std::uint64_t part = std::max<std::uint64_t>(kFirstPartBytes, have);
    bytes.resize(have + static_cast<std::size_t>(std::min(part, length - have)));
    source.read(offset + have, std::span(bytes).subspan(have));
  }
}

std::shared_ptr<ByteSource> byte_source_of(std::vector<std::uint8_t> bytes, std::string name) {
  return std::make_shared<MemorySource>(std::move(bytes), std::move(name));
}

}  // namespace octavo
