#include "octavo/dist/source_stamp.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <ctime>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::int64_t kNsPerSecond = 1000000000;

SourceStamp stamp_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    throw Error(ErrorKind::io, std::strerror(errno), path);
  }
  return {path, static_cast<std::int64_t>(status.st_size),
          static_cast<std::int64_t>(status.st_mtim.tv_sec) * kNsPerSecond +
              status.st_mtim.tv_nsec};
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

}  // namespace

std::vector<SourceStamp> stamps_of(const std::vector<std::string>& paths) {
  std::vector<SourceStamp> stamps;
  for (const std::string& path : paths) stamps.push_back(stamp_of(path));
  return stamps;
}

void require_unchanged(const std::vector<SourceStamp>& stamps) {
  for (const SourceStamp& planned : stamps) {
    const SourceStamp now = stamp_of(planned.path);
    if (now == planned) continue;
    throw Error(ErrorKind::source_rejected,
                "was changed after the build was planned (" + text_of(planned) + " then, " +
                    text_of(now) + " now); plan again",
                planned.path);
  }
}

}  // namespace octavo
