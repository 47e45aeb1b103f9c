#include "octavo/dist/source_stamp.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>
#include <span>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

namespace {

constexpr std::int64_t kNsPerSecond = 1000000000;

SourceStamp stamp_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    throw Error(ErrorKind::io, std::strerror(errno), path);
  }
  return {path, static_cast<std::int64_t>(status.st_size),
          static_cast<std::int64_t>(status.st_mtim.tv_sec) * kNsPerSecond + status.st_mtim.tv_nsec,
          std::nullopt};
}

/// "5 bytes of 2024-05-17 10:02:11.500000000 UTC".
std::string text_of(const SourceStamp& stamp) {
  std::int64_t ns = stamp.written_ns % kNsPerSecond;
  if (ns < 0) ns += kNsPerSecond;
  const auto seconds = static_cast<std::time_t>((stamp.written_ns - ns) / kNsPerSecond);
  std::tm date{};
  ::gmtime_r(&seconds, &date);
  char text[32] = "";
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &date);
  const std::string fraction = std::to_string(kNsPerSecond + ns).substr(1);
  return std::to_string(stamp.bytes) + " bytes of " + text + "." + fraction + " UTC";
}

std::uint32_t crc_of(const std::string& path, Progress& progress) {
  constexpr std::uint64_t kPieceBytes = std::uint64_t{1} << 20;
  const std::unique_ptr<StorageFile> file = local_storage().open_read(path);
  const std::uint64_t size = file->size();
  std::vector<std::uint8_t> piece(static_cast<std::size_t>(std::min(size, kPieceBytes)));
  std::uint32_t crc = 0;
  for (std::uint64_t at = 0; at < size; at += kPieceBytes) {
    if (progress.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while a file was compared with the plan", path);
    }
    const auto bytes =
        std::span(piece).first(static_cast<std::size_t>(std::min(size - at, kPieceBytes)));
    file->read(at, bytes);
    crc = crc32c(bytes, crc);
  }
  return crc;
}

Error about_change(const SourceStamp& planned, const SourceStamp& now) {
  std::string what = "was changed after the build was planned (";
  if (!planned.crc) {
    what += text_of(planned) + " then, " + text_of(now) + " now)";
  } else if (planned.bytes != now.bytes) {
    what += std::to_string(planned.bytes) + " bytes then, " + std::to_string(now.bytes) + " now)";
  } else {
    what += std::to_string(planned.bytes) + " bytes as then, of another checksum)";
  }
  const Error error(ErrorKind::source_rejected, what + "; plan again", planned.path);
  const bool may_be_copy = !planned.crc && planned.bytes == now.bytes;
  return may_be_copy ? error.with_field("source.times") : error;
}

}  // namespace

std::vector<SourceStamp> stamps_of(const std::vector<std::string>& paths) {
  std::vector<SourceStamp> stamps;
  for (const std::string& path : paths) stamps.push_back(stamp_of(path));
  return stamps;
}

std::vector<SourceStamp> stamps_of(const std::vector<std::string>& paths, FileCheck check,
                                   Progress& progress) {
  std::vector<SourceStamp> stamps = stamps_of(paths);
  if (check == FileCheck::times) return stamps;
  std::int64_t bytes = 0;
  for (const SourceStamp& stamp : stamps) bytes += stamp.bytes;
  const ProgressScope scope(progress, "check files", bytes, "bytes");
  for (SourceStamp& stamp : stamps) {
    stamp.written_ns = 0;
    stamp.crc = crc_of(stamp.path, progress);
    progress.advance(stamp.bytes);
  }
  return stamps;
}

UnchangedFiles::UnchangedFiles(const std::vector<SourceStamp>& planned, Progress& progress) {
  for (const SourceStamp& then : planned) {
    SourceStamp now = stamp_of(then.path);
    const bool is_same = then.crc ? now.bytes == then.bytes &&
                                        crc_of(then.path, progress) == *then.crc
                                  : now == then;
    if (!is_same) throw about_change(then, now);
    seen_.push_back(std::move(now));
  }
}

void UnchangedFiles::require_still() const {
  for (const SourceStamp& then : seen_) {
    const SourceStamp now = stamp_of(then.path);
    if (now != then) throw about_change(then, now);
  }
}

}  // namespace octavo
