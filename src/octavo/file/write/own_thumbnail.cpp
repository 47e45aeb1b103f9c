#include "octavo/file/write/own_thumbnail.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/thumbnail.h"
#include "octavo/file/write/index_builder.h"

namespace octavo {

namespace {

constexpr std::uint64_t kThumbnailCacheBytes = std::uint64_t{16} << 20;

void append(Bytes& to, ByteSpan bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

// A growing file as if it were sealed behind its index pages, without parts and metadata.
class SealedView final : public ByteSource {
 public:
  SealedView(const StorageFile& file, FileHeader header, const IndexRoot& root,
             const Levels& levels)
      : file_(file), grown_bytes_(header.pages.end()) {
    const auto section = [&](ByteSpan bytes) {
      const Section added{size(), bytes.size(), crc32c(bytes)};
      append(tail_, bytes);
      return added;
    };
    constexpr std::array<std::uint8_t, 2> kNoMetadata = {'{', '}'};
    header.is_sealed = true;
    header.directory = section({});
    header.metadata = section(kNoMetadata);
    header.root = section(encode_root(root, levels, header));
    header.file_bytes = size() + kTrailerBytes;
    header_ = encode_header(header);
    append(tail_, encode_trailer({.build_id = header.build_id,
                                  .file_bytes = header.file_bytes,
                                  .header_crc = load_header_crc(header_)}));
  }

  std::uint64_t size() const override { return grown_bytes_ + tail_.size(); }
  const std::string& name() const override { return file_.path(); }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset > size() || out.size() > size() - offset) {
      throw Error(ErrorKind::truncated, "a read beyond its end", name(), offset);
    }
    // Of each of the three runs of bytes, what is asked for
    const auto part = [&](std::uint64_t begin, std::uint64_t end, const auto& take) {
      const std::uint64_t from = std::max(begin, offset);
      const std::uint64_t to = std::min(end, offset + out.size());
      if (from < to) take(from, out.subspan(from - offset, to - from));
    };
    part(0, kHeaderBytes, [&](std::uint64_t from, std::span<std::uint8_t> to) {
      std::copy_n(header_.begin() + static_cast<std::ptrdiff_t>(from), to.size(), to.begin());
    });
    part(kHeaderBytes, grown_bytes_, [&](std::uint64_t from, std::span<std::uint8_t> to) {
      file_.read(from, to);
    });
    part(grown_bytes_, size(), [&](std::uint64_t from, std::span<std::uint8_t> to) {
      const auto first = tail_.begin() + static_cast<std::ptrdiff_t>(from - grown_bytes_);
      std::copy_n(first, to.size(), to.begin());
    });
  }

 private:
  const StorageFile& file_;
  std::uint64_t grown_bytes_;
  HeaderBlock header_{};
  Bytes tail_;
};

}  // namespace

Part own_thumbnail(const StorageFile& file, const FileHeader& header, const IndexRoot& root,
                   const Levels& levels) {
  ReaderOptions options;
  options.cache_bytes = kThumbnailCacheBytes;
  const auto view = std::make_shared<SealedView>(file, header, root, levels);
  Bytes png = thumbnail_of(*FileReader::open(view, options));
  return {kThumbnailTag, kThumbnailFlags,
          [png = std::move(png)](const std::function<void(ByteSpan)>& sink) { sink(png); }};
}

}  // namespace octavo
