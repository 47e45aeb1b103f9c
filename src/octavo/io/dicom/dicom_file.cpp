#include "octavo/io/dicom/dicom_file.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/io/dicom/dicom_tags.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::uint32_t kUndefinedLength = 0xffffffffU;
constexpr std::uint64_t kStoredValueLimit = 512;
constexpr std::uint64_t kStoredListLimit = std::uint64_t{1} << 16;
constexpr std::uint64_t kStoredTableLimit = std::uint64_t{1} << 17;
constexpr std::uint64_t kSiemensHeaderLimit = std::uint64_t{1} << 20;
constexpr std::size_t kWindowBytes = std::size_t{1} << 14;
constexpr int kMaxDepth = 16;

constexpr DicomTag kMediaClass = 0x00020002;
constexpr DicomTag kTransferSyntax = 0x00020010;
constexpr DicomTag kFloatPixelData = 0x7fe00008;
constexpr DicomTag kDoublePixelData = 0x7fe00009;
constexpr DicomTag kPixelData = 0x7fe00010;
constexpr DicomTag kSiemensGroup = 0x0029;
constexpr DicomTag kItem = 0xfffee000;
constexpr DicomTag kItemEnd = 0xfffee00d;
constexpr DicomTag kSequenceEnd = 0xfffee0dd;

/// Sequences worth keeping; in implicit VR a length alone does not tell a sequence from a value.
bool is_kept_sequence(DicomTag tag) {
  static const std::set<DicomTag> kKept = {0x52009229, 0x52009230, 0x00209113, 0x00209116,
                                           0x00289110, 0x00289145, 0x00209111, 0x00283010,
                                           0x00620002, 0x0062000a, 0x00283000, 0x00409096,
                                           0x00540022,
                                           kCardiacSynchronizationSequence,
                                           kTemporalPositionSequence,
                                           kSharedConvertedAttributesSequence,
                                           kFrameConvertedAttributesSequence};
  return kKept.contains(tag);
}

/// A list of numbers for every frame may be long, and a rescale that is too long to be one must not
/// pass for absent.
std::uint64_t stored_value_limit(DicomTag tag) {
  if (tag >= 0x00281201 && tag <= 0x00281203) return kStoredTableLimit;  // of colors
  const bool may_be_long = tag == kGridFrameOffsets || tag == kRescaleSlope ||
                           tag == kRescaleIntercept || tag == kDoseScaling;
  return may_be_long ? kStoredListLimit : kStoredValueLimit;
}

/// Bytes of a file read through a small window.
class Window {
 public:
  explicit Window(const std::string& path) : file_(path) {}

  std::uint64_t size() const { return inflated_ ? inflated_->size() : file_.size(); }
  const std::string& path() const { return file_.path(); }

  /// What follows `start` is deflated.
  std::shared_ptr<InflatedFile> inflate_from(std::uint64_t start) {
    inflated_ = std::make_shared<InflatedFile>(path(), start);
    held_.clear();
    return inflated_;
  }

  /// Requires offset + count <= size().
  std::string bytes(std::uint64_t offset, std::uint64_t count) {
    if (offset < start_ || offset + count > start_ + held_.size()) {
      held_.resize(static_cast<std::size_t>(
          std::min<std::uint64_t>(std::max<std::uint64_t>(count, kWindowBytes), size() - offset)));
      if (inflated_) inflated_->read_exactly(offset, held_);
      else file_.read_exactly(offset, held_);
      start_ = offset;
    }
    const auto* from = reinterpret_cast<const char*>(held_.data()) + (offset - start_);
    return {from, static_cast<std::size_t>(count)};
  }

 private:
  SourceFile file_;
  std::shared_ptr<InflatedFile> inflated_;
  std::vector<std::byte> held_;
  std::uint64_t start_ = 0;
};

struct ElementHead {
  DicomTag tag = 0;
  std::string vr;              ///< empty in implicit VR and for items
  std::uint32_t length = 0;
  std::uint64_t value_offset = 0;
};

struct Syntax {
  bool is_explicit = true;
  bool big_endian = false;
};

bool has_long_length(const std::string& vr) {
  static const std::set<std::string> kLong = {"OB", "OW", "OF", "OD", "OL", "OV", "SQ",
                                              "UC", "UN", "UR", "UT", "SV", "UV"};
  return kLong.contains(vr);
}

/// How messages call an element.
std::string element_name(DicomTag tag) {
  const bool is_pixels = tag == kPixelData || tag == kFloatPixelData || tag == kDoublePixelData;
  const char* name = is_pixels ? "the picture" : tag == kItem ? "a part of the picture or of a list"
                                                              : "element";
  return std::string(name) + " " + dicom_tag_text(tag);
}

bool is_vr(const std::string& text) {
  return text.size() == 2 && text[0] >= 'A' && text[0] <= 'Z' && text[1] >= 'A' && text[1] <= 'Z';
}

/// Visits one file; see the header for what it proves.
class Walker {
 public:
  explicit Walker(const std::string& path) : window_(path) {}

  DicomFile walk() {
    DicomFile file;
    file.path = window_.path();
    const bool has_preamble = window_.size() >= 132 && window_.bytes(128, 4) == "DICM";
    std::uint64_t at = has_preamble ? 132 : 0;
    at = walk_meta(at, file);
    const Syntax syntax = syntax_of(file, at);
    file.big_endian = syntax.big_endian;
    file.data.set_big_endian(syntax.big_endian);
    walk_set(at, window_.size(), syntax, 0, &file.data, &file.pixels);
    file.element_counts = std::move(element_counts_);
    file.private_count = private_count_;
    file.siemens_header = std::move(siemens_header_);
    if (file.pixels.inflated) {
      file.pixels.inflated->close_behind(file.pixels.native.offset + file.pixels.native.length);
    }
    return file;
  }

 private:
  /// The group 0002, always explicit little-endian.
  std::uint64_t walk_meta(std::uint64_t at, DicomFile& file) {
    const Syntax syntax{};
    while (at + 8 <= window_.size()) {
      if (window_.bytes(at, 2) != std::string("\2\0", 2)) break;
      const ElementHead head = read_head(at, window_.size(), syntax);
      const std::uint64_t end = value_end(head, window_.size());
      count(head.tag);
      const bool is_class = head.tag == kMediaClass;
      if ((is_class || head.tag == kTransferSyntax) && head.length <= kStoredValueLimit) {
        DicomSet meta;
        meta.add_value(head.tag, window_.bytes(head.value_offset, head.length));
        (is_class ? file.media_class : file.transfer_syntax) = meta.text(head.tag);
      }
      at = end;
    }
    return at;
  }

  Syntax syntax_of(DicomFile& file, std::uint64_t at) {
    const std::string& uid = file.transfer_syntax;
    if (uid == "1.2.840.10008.1.2") return {false, false};
    if (uid == "1.2.840.10008.1.2.2") return {true, true};
    if (uid == "1.2.840.10008.1.2.1.99") {
      file.pixels.inflated = window_.inflate_from(at);
      return {true, false};
    }
    if (uid == "1.2.840.10008.1.2.8.1") {
      reject("transfer syntax " + uid + " (deflated frames) is not read; convert it to another one "
             "with gdcmconv or dcmconv", at);
    }
    if (uid == "1.2.840.113619.5.2") {
      reject("transfer syntax " + uid + " (GE private) is not read; convert it first", at);
    }
    if (!uid.empty()) return {true, false};
    // Without file meta information the first element tells: two capital letters are a VR.
    const bool is_explicit = at + 6 <= window_.size() && is_vr(window_.bytes(at + 4, 2));
    file.transfer_syntax = is_explicit ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2";
    return {is_explicit, false};
  }

  /// Elements from `at` to `end`, or to an item delimiter; returns where it stopped.
  std::uint64_t walk_set(std::uint64_t at, std::uint64_t end, Syntax syntax, int depth,
                         DicomSet* kept, DicomPixels* pixels) {
    if (depth > kMaxDepth) reject("sequences nested deeper than 16", at);
    while (at < end) {
      const bool behind_pixels = pixels != nullptr && pixels->is_present;
      if (behind_pixels && (end - at < 8 || window_.bytes(at, 4) == std::string(4, '\0'))) break;
      const ElementHead head = read_head(at, end, syntax);
      if (head.tag == kItemEnd) return head.value_offset;
      const bool is_pixels = head.tag == kPixelData || head.tag == kFloatPixelData ||
                             head.tag == kDoublePixelData;
      if (pixels != nullptr && is_pixels) {
        at = walk_pixels(head, end, *pixels);
      } else if (is_sequence(head, syntax)) {
        // The content of an undefined-length UN element is implicit VR (PS3.5, 6.2.2).
        const Syntax inner = head.vr == "UN" ? Syntax{false, false} : syntax;
        at = walk_sequence(head, end, inner, depth, is_kept_sequence(head.tag) ? kept : nullptr);
      } else {
        const std::uint64_t next = value_end(head, end);
        count(head.tag);
        const bool is_short = head.length <= stored_value_limit(head.tag);
        if (kept != nullptr && !is_private(head.tag) && is_short) {
          kept->add_value(head.tag, window_.bytes(head.value_offset, head.length));
        }
        if (depth == 0 && head.tag >> 16 == kSiemensGroup) take_siemens(head);
        at = next;
      }
    }
    return at;
  }

  /// Element (0029,00nn) names whose the elements (0029,nn00) to (0029,nnff) are.
  void take_siemens(const ElementHead& head) {
    const DicomTag element = head.tag & 0xffffU;
    if (element >= 0x10 && element <= 0xff && head.length <= kStoredValueLimit) {
      DicomSet owner;
      owner.add_value(head.tag, window_.bytes(head.value_offset, head.length));
      if (owner.text(head.tag) == "SIEMENS CSA HEADER") siemens_block_ = element;
    }
    const bool is_header = siemens_block_ != 0 && element == (siemens_block_ << 8 | 0x10U);
    if (!is_header || head.length > kSiemensHeaderLimit) return;
    siemens_header_ = window_.bytes(head.value_offset, head.length);
  }

  static bool is_private(DicomTag tag) { return (tag >> 16 & 1) != 0; }

  void count(DicomTag tag) {
    if (is_private(tag)) ++private_count_;
    else ++element_counts_[tag];
  }

  static bool is_sequence(const ElementHead& head, Syntax syntax) {
    if (head.vr == "SQ" || head.length == kUndefinedLength) return true;
    return !syntax.is_explicit && is_kept_sequence(head.tag);
  }

  std::uint64_t walk_sequence(const ElementHead& sequence, std::uint64_t limit, Syntax syntax,
                              int depth, DicomSet* kept) {
    const bool is_open = sequence.length == kUndefinedLength;
    const std::uint64_t end = is_open ? limit : value_end(sequence, limit);
    std::uint64_t at = sequence.value_offset;
    while (is_open || at < end) {
      const ElementHead item = read_head(at, end, syntax);
      if (item.tag == kSequenceEnd) return item.value_offset;
      if (item.tag != kItem) {
        reject("an item expected in " + dicom_tag_text(sequence.tag) + ", " +
                   dicom_tag_text(item.tag) + " found", at);
      }
      DicomSet set;
      set.set_big_endian(syntax.big_endian);
      const bool open_item = item.length == kUndefinedLength;
      const std::uint64_t item_end = open_item ? end : value_end(item, end);
      at = walk_set(item.value_offset, item_end, syntax, depth + 1,
                    kept != nullptr ? &set : nullptr, nullptr);
      if (!open_item) at = item_end;
      if (kept != nullptr) kept->add_item(sequence.tag, std::move(set));
    }
    return at;
  }

  std::uint64_t walk_pixels(const ElementHead& head, std::uint64_t end, DicomPixels& pixels) {
    pixels.is_present = true;
    pixels.is_float = head.tag != kPixelData;
    pixels.is_words = head.vr == "OW";
    if (head.length != kUndefinedLength) {
      const std::uint64_t next = value_end(head, end);
      pixels.native = {head.value_offset, head.length};
      return next;
    }
    pixels.is_encapsulated = true;
    std::uint64_t at = head.value_offset;
    for (bool is_table = true;; is_table = false) {
      const ElementHead item = read_head(at, end, {true, false});
      if (item.tag == kSequenceEnd) return item.value_offset;
      if (item.tag != kItem) {
        reject("a fragment of pixel data expected, " + dicom_tag_text(item.tag) + " found", at);
      }
      at = value_end(item, end);
      if (is_table) {
        read_offset_table(item, pixels);
      } else {
        pixels.fragments.push_back({item.value_offset, item.length});
      }
    }
  }

  void read_offset_table(const ElementHead& item, DicomPixels& pixels) {
    for (std::uint64_t i = 0; i + 4 <= item.length; i += 4) {
      pixels.frame_offsets.push_back(read_u32(item.value_offset + i, false));
    }
  }

  ElementHead read_head(std::uint64_t at, std::uint64_t end, Syntax syntax) {
    need(at, 8, end, "the next element");
    ElementHead head;
    head.tag = read_u16(at, syntax.big_endian) << 16 | read_u16(at + 2, syntax.big_endian);
    const bool is_delimiter = head.tag >> 16 == 0xfffe;
    head.value_offset = at + 8;
    if (!syntax.is_explicit || is_delimiter) {
      head.length = read_u32(at + 4, syntax.big_endian);
      return head;
    }
    head.vr = window_.bytes(at + 4, 2);
    if (!is_vr(head.vr)) {
      reject("element " + dicom_tag_text(head.tag) + " has no value representation: the file is "
             "damaged", at);
    }
    if (!has_long_length(head.vr)) {
      head.length = read_u16(at + 6, syntax.big_endian);
      return head;
    }
    need(at, 12, end, element_name(head.tag));
    head.length = read_u32(at + 8, syntax.big_endian);
    head.value_offset = at + 12;
    return head;
  }

  /// Where a value of known length ends, proven to lie in the file.
  std::uint64_t value_end(const ElementHead& head, std::uint64_t end) {
    if (head.length == kUndefinedLength) {
      reject("element " + dicom_tag_text(head.tag) + " has no length", head.value_offset);
    }
    need(head.value_offset, head.length, end, element_name(head.tag));
    return head.value_offset + head.length;
  }

  void need(std::uint64_t at, std::uint64_t count, std::uint64_t end, const std::string& what) {
    if (at <= end && count <= end - at) return;
    if (end == window_.size()) {
      reject("the file ends early: " + what + " reaches to byte " + std::to_string(at + count) +
                 ", the file has " + std::to_string(end) +
                 " bytes; copy it again from its origin", at);
    }
    reject(what + " reaches to byte " + std::to_string(at + count) + ", its sequence ends at " +
               std::to_string(end) + ": the file is damaged; copy it again from its origin", at);
  }

  std::uint32_t read_u16(std::uint64_t at, bool big_endian) {
    const std::string b = window_.bytes(at, 2);
    const auto low = static_cast<unsigned char>(b[big_endian ? 1 : 0]);
    const auto high = static_cast<unsigned char>(b[big_endian ? 0 : 1]);
    return static_cast<std::uint32_t>(high) << 8 | low;
  }

  std::uint32_t read_u32(std::uint64_t at, bool big_endian) {
    const std::uint32_t first = read_u16(at, big_endian);
    const std::uint32_t second = read_u16(at + 2, big_endian);
    return big_endian ? first << 16 | second : second << 16 | first;
  }

  [[noreturn]] void reject(const std::string& why, std::uint64_t offset) {
    throw Error(ErrorKind::source_rejected, why, window_.path(), offset);
  }

  Window window_;
  std::map<DicomTag, std::int64_t> element_counts_;
  std::int64_t private_count_ = 0;
  DicomTag siemens_block_ = 0;
  std::string siemens_header_;
};

}  // namespace

bool looks_like_dicom(const std::string& path) {
  const std::vector<std::byte> head = file_head(path, 132);
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (text.size() == 132 && text.substr(128) == "DICM") return true;
  if (text.size() < 16 || (text[0] != 2 && text[0] != 8) || text[1] != 0 || text[3] != 0)
    return false;
  const bool short_length = text[6] == 0 && text[7] == 0;
  return is_vr(std::string(text.substr(4, 2))) || (short_length && text[2] <= 0x16);
}

DicomFile read_dicom_file(const std::string& path) { return Walker(path).walk(); }

}  // namespace octavo
