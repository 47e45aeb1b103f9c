// A zip archive that is written entry by entry, by minizip.
#pragma once

#include <exception>
#include <string>
#include <string_view>

#include "octavo/core/bytes.h"
#include "octavo/file/storage/pending_file.h"

namespace octavo {

/// The same entries are the same bytes: no time stands in them.
/// Throws  as PendingFile; Error{internal} where minizip fails for reasons of its own
class ZipArchive {
 public:
  explicit ZipArchive(PendingFile& file);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /// Begins an entry; the one before is complete.
  /// is_large  it may have 4 GiB or more
  void begin(const std::string& name, bool is_large = false);
  void append(ByteSpan bytes);
  /// Completes the archive.
  void finish();

 private:
  friend struct ZipCalls;

  void end_entry();
  void require(int status);

  PendingFile& file_;
  std::uint64_t position_ = 0;
  std::exception_ptr failure_;  // thrown when minizip has returned
  void* zip_ = nullptr;
  bool is_in_entry_ = false;
};

}  // namespace octavo
