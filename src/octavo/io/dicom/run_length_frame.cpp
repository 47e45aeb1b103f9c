#include "octavo/io/dicom/run_length_frame.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "octavo/io/source/header_bytes.h"
#include "octavo/io/source/packbits.h"

namespace octavo {

namespace {

/// The number of segments and 15 offsets, from the start of the frame.
constexpr std::size_t kFrameHeaderBytes = 64;
constexpr std::size_t kMostSegments = 15;
constexpr std::byte kNoByte{0x80};

/// What may stand behind the run that makes the last byte.
bool is_filling(std::span<const std::byte> rest) {
  return rest.size() <= 1 || std::ranges::all_of(rest, [](std::byte code) {
           return code == std::byte{0} || code == kNoByte;
         });
}

/// What is wrong with the codes of a segment; empty where they make as many bytes as wanted.
std::string segment_damage(std::span<const std::byte> codes, std::size_t wanted) {
  const auto expected = [wanted] { return std::to_string(wanted) + " bytes"; };
  std::size_t made = 0;
  while (made < wanted && !codes.empty()) {
    const PackBitsCode code = packbits_code(codes.front());
    if (code.taken > codes.size()) {
      return "makes " + std::to_string(made) + " of " + expected() + " before its last run is cut";
    }
    made += code.made;
    codes = codes.subspan(code.taken);
  }
  if (made < wanted) return "makes " + std::to_string(made) + " of " + expected();
  if (made > wanted || !is_filling(codes)) return "makes more than " + expected();
  return {};
}

}  // namespace

std::string run_length_damage(std::span<const std::byte> frame, std::size_t segments,
                              std::size_t pixels) {
  if (frame.size() < kFrameHeaderBytes) {
    return "it has " + std::to_string(frame.size()) + " bytes, and its header alone " +
           std::to_string(kFrameHeaderBytes);
  }
  const HeaderBytes header(frame.first(kFrameHeaderBytes), false);
  const std::size_t count = header.at<std::uint32_t>(0);
  if (count > kMostSegments) {
    return "it names " + std::to_string(count) + " segments, and " +
           std::to_string(kMostSegments) + " is the most";
  }
  if (count != segments) {
    return "it has " + std::to_string(count) + " segments, and the bytes of its values are " +
           std::to_string(segments);
  }
  std::array<std::size_t, kMostSegments + 1> starts{};
  for (std::size_t i = 0; i < count; ++i) starts[i] = header.at<std::uint32_t>(4 + 4 * i);
  starts[count] = frame.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::string named = "segment " + std::to_string(i + 1) + " of " + std::to_string(count);
    const std::size_t end = std::min(starts[i + 1], frame.size());
    if (starts[i] < kFrameHeaderBytes || starts[i] > end) {
      return named + " starts at byte " + std::to_string(starts[i]) + " of " +
             std::to_string(frame.size()) + ", out of its place";
    }
    const std::string damage = segment_damage(frame.subspan(starts[i], end - starts[i]), pixels);
    if (!damage.empty()) return named + " " + damage;
  }
  return {};
}

}  // namespace octavo
