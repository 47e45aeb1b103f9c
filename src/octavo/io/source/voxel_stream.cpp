#include "octavo/io/source/voxel_stream.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/source/header_bytes.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kInputBytes = std::size_t{1} << 16;
constexpr int kAutoHeader = 15 + 32;  // zlib: largest window, zlib or gzip header as found
constexpr int kGzipHeader = 15 + 16;
constexpr int kNoHeader = -15;

}  // namespace

class VoxelStream::Impl {
 public:
  Impl(const std::string& path, std::uint64_t start_offset, StreamCoding coding,
       std::function<bool()> is_cancelled)
      : file_(path),
        coding_(coding),
        file_offset_(start_offset),
        is_cancelled_(std::move(is_cancelled)) {
    if (coding_ == StreamCoding::plain) return;
    input_.resize(kInputBytes);
    const int header = coding_ == StreamCoding::bare_deflated ? kNoHeader : kAutoHeader;
    if (inflateInit2(&zlib_, header) != Z_OK) {
      throw Error(ErrorKind::out_of_memory, "no memory for decompression", path);
    }
  }
  ~Impl() {
    if (coding_ != StreamCoding::plain) inflateEnd(&zlib_);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const std::string& path() const { return file_.path(); }

  void read(std::span<std::byte> bytes) {
    const std::size_t count = read_some(bytes);
    if (count < bytes.size()) {
      throw Error(ErrorKind::source_rejected,
                  "the data end early: " + std::to_string(delivered_ + bytes.size() - count) +
                      " bytes expected, " + std::to_string(delivered_) +
                      " found; the file is cut or its header is wrong",
                  path(), file_offset_);
    }
  }

  /// Fills `bytes` as far as the stream goes; returns how far.
  std::size_t read_some(std::span<std::byte> bytes) {
    const std::size_t count =
        coding_ == StreamCoding::plain ? read_plain(bytes) : read_deflated(bytes);
    delivered_ += count;
    return count;
  }

  /// Passes over bytes of a plain file; false where it has fewer, or where the stream is deflated.
  bool jump(std::uint64_t count) {
    const bool is_there = coding_ == StreamCoding::plain && file_offset_ <= file_.size() &&
                          count <= file_.size() - file_offset_;
    if (!is_there) return false;
    file_offset_ += count;
    delivered_ += count;
    return true;
  }

 private:
  std::size_t read_plain(std::span<std::byte> bytes) {
    const std::size_t count = file_.read_some(file_offset_, bytes);
    file_offset_ += count;
    return count;
  }

  std::size_t read_deflated(std::span<std::byte> bytes) {
    std::size_t done = 0;
    while (done < bytes.size() && !at_end_) {
      if (zlib_.avail_in == 0) refill();
      const std::size_t chunk =
          std::min<std::size_t>(bytes.size() - done, std::numeric_limits<uInt>::max());
      zlib_.next_out = reinterpret_cast<Bytef*>(bytes.data() + done);
      zlib_.avail_out = static_cast<uInt>(chunk);
      const int status = inflate(&zlib_, Z_NO_FLUSH);
      done += chunk - zlib_.avail_out;
      if (status == Z_STREAM_END) {
        next_member();
      } else if (status != Z_OK && status != Z_BUF_ERROR) {
        reject(zlib_.msg != nullptr ? zlib_.msg : "not a deflated stream");
      }
    }
    return done;
  }

  void refill() {
    if (is_cancelled_ && is_cancelled_()) {
      throw Error(ErrorKind::cancelled, "stopped while a compressed file was read");
    }
    const std::size_t count = file_.read_some(file_offset_, input_);
    if (count == 0) {
      throw Error(ErrorKind::source_rejected,
                  "the compressed stream ends early: the file of " +
                      std::to_string(file_.size()) + " bytes is cut after " +
                      std::to_string(delivered_) +
                      " bytes of its content; copy it again from its origin",
                  path(), file_offset_);
    }
    file_offset_ += count;
    zlib_.next_in = reinterpret_cast<Bytef*>(input_.data());
    zlib_.avail_in = static_cast<uInt>(count);
  }

  /// Behind one gzip member: another one starts here, or the stream is at its end.
  void next_member() {
    at_end_ = true;
    if (coding_ == StreamCoding::bare_deflated) return;
    const std::uint64_t offset = file_offset_ - zlib_.avail_in;
    std::array<std::byte, 2> magic{};
    if (file_.read_some(offset, magic) < 2) return;
    if (magic[0] != std::byte{0x1f} || magic[1] != std::byte{0x8b}) return;
    at_end_ = false;
    if (inflateReset2(&zlib_, kGzipHeader) != Z_OK) reject("cannot continue the stream");
  }

  [[noreturn]] void reject(const std::string& why) {
    throw Error(ErrorKind::source_rejected,
                "damaged compressed data after " + std::to_string(delivered_) + " bytes: " + why +
                    "; copy it again from its origin",
                path(), file_offset_);
  }

  SourceFile file_;
  StreamCoding coding_;
  std::uint64_t file_offset_;
  std::function<bool()> is_cancelled_;
  std::uint64_t delivered_ = 0;
  bool at_end_ = false;
  z_stream zlib_{};
  std::vector<std::byte> input_;
};

VoxelStream::VoxelStream(const std::string& path, std::uint64_t start_offset, StreamCoding coding,
                         std::function<bool()> is_cancelled)
    : impl_(std::make_unique<Impl>(path, start_offset, coding, std::move(is_cancelled))) {}
VoxelStream::~VoxelStream() = default;
VoxelStream::VoxelStream(VoxelStream&&) noexcept = default;
VoxelStream& VoxelStream::operator=(VoxelStream&&) noexcept = default;

const std::string& VoxelStream::path() const { return impl_->path(); }

void VoxelStream::read(std::span<std::byte> bytes) { impl_->read(bytes); }

void VoxelStream::skip(std::uint64_t count) {
  if (impl_->jump(count)) return;
  std::vector<std::byte> buffer(std::min<std::uint64_t>(count, kInputBytes));
  while (count > 0) {
    const std::size_t chunk = std::min<std::uint64_t>(count, buffer.size());
    read(std::span(buffer).first(chunk));
    count -= chunk;
  }
}

std::uint64_t VoxelStream::finish() {
  std::vector<std::byte> buffer(kInputBytes);
  std::uint64_t left = 0;
  while (const std::size_t count = impl_->read_some(buffer)) left += count;
  return left;
}

bool is_gzip_file(const std::string& path) {
  const std::vector<std::byte> head = file_head(path, 2);
  return head.size() == 2 && head[0] == std::byte{0x1f} && head[1] == std::byte{0x8b};
}

void check_gzip_length(const std::string& path, std::uint64_t needed_bytes,
                       const std::function<bool()>& is_cancelled) {
  const SourceFile file(path);
  std::array<std::byte, 4> tail{};
  if (file.size() >= 18) file.read_exactly(file.size() - 4, tail);
  const auto length = HeaderBytes(tail, false).at<std::uint32_t>(0);
  if (length == static_cast<std::uint32_t>(needed_bytes)) return;
  // Several members, bytes behind the stream, or a cut file: only reading tells.
  VoxelStream stream(path, 0, StreamCoding::deflated, is_cancelled);
  stream.skip(needed_bytes);
  stream.finish();
}

}  // namespace octavo
