#include "octavo/file/write/hollow_file.h"

#include <algorithm>

namespace octavo {

void HollowFile::leave_out(std::uint64_t offset, const EncodedRun& run, std::size_t stream) {
  const std::uint64_t length = run.stored_bytes(stream);
  if (length > 0) left_out_.emplace(offset, LeftOut{&run, stream, length});
}

void HollowFile::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
  while (!out.empty()) {
    // The run that holds the next byte, or the next run behind it
    auto next = left_out_.upper_bound(offset);
    if (next != left_out_.begin()) {
      const auto& [begin, bytes] = *std::prev(next);
      if (offset < begin + bytes.length) {
        const std::uint64_t count = std::min<std::uint64_t>(out.size(),
                                                            begin + bytes.length - offset);
        bytes.run->read(bytes.stream, offset - begin, out.first(static_cast<std::size_t>(count)));
        offset += count;
        out = out.subspan(static_cast<std::size_t>(count));
        continue;
      }
    }
    std::uint64_t count = out.size();
    if (next != left_out_.end()) count = std::min(count, next->first - offset);
    file_->read(offset, out.first(static_cast<std::size_t>(count)));
    offset += count;
    out = out.subspan(static_cast<std::size_t>(count));
  }
}

}  // namespace octavo
