// Reads a run of bytes from front to back out of a plain or deflated file, and proves that it is
// whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace octavo {

/// How the bytes stand in the file. `deflated` is zlib or gzip (one member or several); which is
/// seen. `bare_deflated` has neither header nor checksum.
enum class StreamCoding { plain, deflated, bare_deflated };

/// A byte stream that starts somewhere in a file. One thread at a time.
/// Memory  64 KiB and zlib's window, whatever the length
class VoxelStream {
 public:
  /// is_cancelled  asked while a deflated stream is read, passed over or finished; may be empty
  /// Throws        Error{io}; the members below Error{cancelled} as well
  VoxelStream(const std::string& path, std::uint64_t start_offset, StreamCoding coding,
              std::function<bool()> is_cancelled = {});
  ~VoxelStream();
  VoxelStream(VoxelStream&&) noexcept;
  VoxelStream& operator=(VoxelStream&&) noexcept;

  const std::string& path() const;

  /// Fills `bytes` with the next bytes.
  /// Throws Error{source_rejected} when the stream is damaged or ends early, Error{io}.
  void read(std::span<std::byte> bytes);

  /// Passes over `count` bytes; those of a plain file are not read. Throws as read does.
  void skip(std::uint64_t count);

  /// Reads to the end of a deflated stream so that its checksums and lengths are proven; returns
  /// the number of bytes that were left. Throws as read does.
  std::uint64_t finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// True when a file starts as gzip does. Throws Error{io}.
bool is_gzip_file(const std::string& path);

/// Rejects a gzip file that cannot hold `needed_bytes` before anything is read from it: where the
/// length in its last four bytes differs, the whole stream is read once to find out.
/// is_cancelled  asked meanwhile; may be empty
/// Throws        Error{source_rejected}, Error{io}, Error{cancelled}
void check_gzip_length(const std::string& path, std::uint64_t needed_bytes,
                       const std::function<bool()>& is_cancelled);

}  // namespace octavo
