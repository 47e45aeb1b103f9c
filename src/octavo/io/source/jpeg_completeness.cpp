#include "octavo/io/source/jpeg_completeness.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "octavo/io/source/jpeg_codes.h"

namespace octavo {

namespace {

constexpr unsigned kSequentialMark = 0xc0;
constexpr unsigned kExtendedMark = 0xc1;
constexpr unsigned kLosslessMark = 0xc3;
constexpr unsigned kCodesMark = 0xc4;
constexpr unsigned kFirstRestart = 0xd0;
constexpr unsigned kStartMark = 0xd8;
constexpr unsigned kEndMark = 0xd9;
constexpr unsigned kScanMark = 0xda;
constexpr unsigned kIntervalMark = 0xdd;
constexpr std::size_t kMostComponents = 4;
constexpr std::size_t kMostTables = 4;  // of each kind
/// In place of the mark of the end, and to fill up to an even length.
constexpr std::size_t kMostBytesWithoutEnd = 3;

/// other  none whose values are stepped over
enum class JpegProcess { other, sequential, lossless };

/// A component of the frame.
struct JpegComponent {
  unsigned id = 0;
  unsigned across = 1;  // sampling factors
  unsigned down = 1;
  bool is_scanned = false;
};

/// A component of a scan.
struct ScannedComponent {
  std::size_t index = 0;        // in the frame
  JpegCodes dc;                 // of first coefficients, or of lossless differences
  std::optional<JpegCodes> ac;  // of the other coefficients
};

unsigned byte_in(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<unsigned>(bytes[at]);
}

unsigned short_in(std::span<const std::byte> bytes, std::size_t at) {
  return byte_in(bytes, at) << 8 | byte_in(bytes, at + 1);
}

std::uint64_t parts_of(std::uint64_t whole, std::uint64_t part) {
  return (whole + part - 1) / part;
}

/// True for marks without a length: of restarts and of the start, and the one for private use.
bool stands_alone(unsigned mark) { return (mark >= 0xd0 && mark <= 0xd8) || mark == 0x01; }

/// A mark of a frame header; those of codes and arithmetic conditioning, and one that is reserved,
/// stand among them.
bool starts_jpeg_frame(unsigned mark) {
  return (mark >= 0xc0 && mark <= 0xcf && mark != kCodesMark && mark != 0xc8 && mark != 0xcc) ||
         mark == 0xf7;
}

class JpegWalk {
 public:
  /// Goes through all segments. True behind the last value, or at the mark of the end.
  bool is_whole(std::span<const std::byte> bytes);

 private:
  void read_frame(unsigned mark, std::span<const std::byte> segment);
  void read_codes(std::span<const std::byte> segment);
  /// Nothing where the scan names components or codes that are not there.
  std::optional<std::vector<ScannedComponent>> scan_of(std::span<const std::byte> segment) const;
  bool has_all_values(const std::vector<ScannedComponent>& scan, JpegBits& bits) const;
  /// Units that belong together, of all components of the scan.
  std::uint64_t groups_in(const std::vector<ScannedComponent>& scan) const;
  bool skip_group(const std::vector<ScannedComponent>& scan, JpegBits& bits) const;
  static bool skip_difference(const ScannedComponent& of, JpegBits& bits);
  static bool skip_block(const ScannedComponent& of, JpegBits& bits);
  bool is_all_scanned() const {
    return std::ranges::all_of(components_, &JpegComponent::is_scanned);
  }

  JpegProcess process_ = JpegProcess::other;
  bool has_scan_ = false;
  std::uint64_t rows_ = 0;
  std::uint64_t columns_ = 0;
  std::uint64_t interval_ = 0;  // groups between restarts; 0: there are none
  std::vector<JpegComponent> components_;
  std::array<std::array<std::optional<JpegTable>, kMostTables>, 2> tables_;  // DC, AC
};

void JpegWalk::read_frame(unsigned mark, std::span<const std::byte> segment) {
  process_ = JpegProcess::other;
  components_.clear();
  if (segment.size() < 6) return;
  rows_ = short_in(segment, 1);
  columns_ = short_in(segment, 3);
  const std::size_t count = byte_in(segment, 5);
  const bool has_size = rows_ > 0 && columns_ > 0;
  if (!has_size || count < 1 || count > kMostComponents || segment.size() < 6 + 3 * count) return;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = 6 + 3 * i;
    const unsigned factors = byte_in(segment, at + 1);
    components_.push_back({byte_in(segment, at), factors >> 4, factors & 15U});
    const JpegComponent& last = components_.back();
    if (last.across < 1 || last.across > 4 || last.down < 1 || last.down > 4) return;
  }
  if (mark == kLosslessMark) process_ = JpegProcess::lossless;
  if (mark == kSequentialMark || mark == kExtendedMark) process_ = JpegProcess::sequential;
}

void JpegWalk::read_codes(std::span<const std::byte> segment) {
  constexpr std::size_t kLengths = 16;
  while (segment.size() > kLengths) {
    const unsigned place = byte_in(segment, 0);
    const std::span<const std::byte> counts = segment.subspan(1, kLengths);
    std::size_t symbols = 0;
    for (const std::byte count : counts) symbols += std::to_integer<std::size_t>(count);
    if (segment.size() < 1 + kLengths + symbols || place >> 4 > 1 ||
        (place & 15U) >= kMostTables) {
      return;
    }
    tables_[place >> 4][place & 15U] = {counts, segment.subspan(1 + kLengths, symbols)};
    segment = segment.subspan(1 + kLengths + symbols);
  }
}

std::optional<std::vector<ScannedComponent>> JpegWalk::scan_of(
    std::span<const std::byte> segment) const {
  const std::size_t count = segment.empty() ? 0 : byte_in(segment, 0);
  if (count < 1 || count > components_.size() || segment.size() < 4 + 2 * count) {
    return std::nullopt;
  }
  std::vector<ScannedComponent> scan;
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned id = byte_in(segment, 1 + 2 * i);
    const unsigned choice = byte_in(segment, 2 + 2 * i);
    const auto found = std::ranges::find(components_, id, &JpegComponent::id);
    if (found == components_.end() || found->is_scanned || choice >> 4 >= kMostTables ||
        (choice & 15U) >= kMostTables) {
      return std::nullopt;
    }
    const auto codes_of = [](const std::optional<JpegTable>& table) {
      return table ? JpegCodes::of(*table) : std::nullopt;
    };
    const bool has_ac = process_ == JpegProcess::sequential;
    const auto dc = codes_of(tables_[0][choice >> 4]);
    const auto ac = has_ac ? codes_of(tables_[1][choice & 15U]) : std::nullopt;
    if (!dc || (has_ac && !ac)) return std::nullopt;
    scan.push_back({static_cast<std::size_t>(found - components_.begin()), *dc, ac});
  }
  return scan;
}

std::uint64_t JpegWalk::groups_in(const std::vector<ScannedComponent>& scan) const {
  const std::uint64_t side = process_ == JpegProcess::lossless ? 1 : 8;
  unsigned most_across = 1;
  unsigned most_down = 1;
  for (const JpegComponent& component : components_) {
    most_across = std::max(most_across, component.across);
    most_down = std::max(most_down, component.down);
  }
  if (scan.size() > 1) {
    return parts_of(columns_, side * most_across) * parts_of(rows_, side * most_down);
  }
  // A component alone has no units behind its own edges.
  const JpegComponent& only = components_[scan[0].index];
  return parts_of(parts_of(columns_ * only.across, most_across), side) *
         parts_of(parts_of(rows_ * only.down, most_down), side);
}

bool JpegWalk::skip_difference(const ScannedComponent& of, JpegBits& bits) {
  const std::optional<unsigned> width = of.dc.take(bits);
  // Of 16 bits there is one difference, without bits of its own.
  return width && *width <= 16 && (*width == 16 || bits.skip(*width));
}

bool JpegWalk::skip_block(const ScannedComponent& of, JpegBits& bits) {
  constexpr unsigned kCoefficients = 64;
  constexpr unsigned kLongRun = 15;
  const std::optional<unsigned> width = of.dc.take(bits);
  if (!width || *width > 16 || !bits.skip(*width)) return false;
  for (unsigned i = 1; i < kCoefficients; ++i) {
    const std::optional<unsigned> symbol = of.ac->take(bits);
    if (!symbol) return false;
    const unsigned run = *symbol >> 4;
    const unsigned bit_count = *symbol & 15U;
    if (bit_count == 0 && run != kLongRun) break;  // zeros alone follow
    if (!bits.skip(bit_count)) return false;
    i += run;
  }
  return true;
}

bool JpegWalk::skip_group(const std::vector<ScannedComponent>& scan, JpegBits& bits) const {
  for (const ScannedComponent& scanned : scan) {
    const JpegComponent& component = components_[scanned.index];
    const unsigned units = scan.size() == 1 ? 1 : component.across * component.down;
    for (unsigned i = 0; i < units; ++i) {
      const bool is_there = process_ == JpegProcess::lossless ? skip_difference(scanned, bits)
                                                              : skip_block(scanned, bits);
      if (!is_there) return false;
    }
  }
  return true;
}

bool JpegWalk::has_all_values(const std::vector<ScannedComponent>& scan, JpegBits& bits) const {
  const std::uint64_t groups = groups_in(scan);
  std::uint64_t left = interval_ == 0 ? groups : interval_;
  unsigned restarts = 0;
  for (std::uint64_t i = 0; i < groups; ++i, --left) {
    if (left == 0) {
      if (bits.next_mark() != kFirstRestart + restarts++ % 8) return false;
      left = interval_;
    }
    if (!skip_group(scan, bits)) return false;
  }
  return true;
}

bool JpegWalk::is_whole(std::span<const std::byte> bytes) {
  std::size_t at = 0;
  for (;;) {
    JpegBits marks(bytes, at);
    const unsigned mark = marks.next_mark();
    at = marks.position();
    if (mark == kEndMark) return has_scan_ && process_ == JpegProcess::other;
    if (mark == 0) return false;
    if (mark == kStartMark) interval_ = 0;
    if (stands_alone(mark)) continue;
    const std::size_t length = bytes.size() - at < 2 ? 0 : short_in(bytes, at);
    if (length < 2 || bytes.size() - at < length) return false;
    const std::span<const std::byte> segment = bytes.subspan(at + 2, length - 2);
    at += length;
    if (mark == kCodesMark) read_codes(segment);
    if (mark == kIntervalMark && segment.size() >= 2) interval_ = short_in(segment, 0);
    if (starts_jpeg_frame(mark)) read_frame(mark, segment);
    has_scan_ = has_scan_ || mark == kScanMark;
    if (mark != kScanMark || process_ == JpegProcess::other) continue;
    const auto scan = scan_of(segment);
    if (!scan) {
      process_ = JpegProcess::other;
      continue;
    }
    JpegBits bits(bytes, at);
    if (!has_all_values(*scan, bits)) return false;
    for (const ScannedComponent& scanned : *scan) components_[scanned.index].is_scanned = true;
    if (is_all_scanned()) return bits.bytes_left() <= kMostBytesWithoutEnd || bits.next_mark() > 0;
    at = bits.position();
  }
}

}  // namespace

bool is_whole_jpeg(std::span<const std::byte> tables, std::span<const std::byte> picture) {
  JpegWalk walk;
  walk.is_whole(tables);
  return walk.is_whole(picture);
}

}  // namespace octavo
