#include "octavo/io/images/png_source.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <set>
#include <utility>

#include "octavo/core/text.h"
#include "octavo/io/source/alternating_values.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/claimed_bytes.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

/// What libpng's hooks need: where in the file it reads, and what it complained of.
struct PngInput {
  explicit PngInput(const std::string& path) : file(path) {}
  SourceFile file;
  std::uint64_t offset = 0;
  std::string message;
  bool is_io_failure = false;
};

void read_bytes(png_structp png, png_bytep target, png_size_t count) {
  auto* input = static_cast<PngInput*>(png_get_io_ptr(png));
  std::size_t found = 0;
  try {
    found = input->file.read_some(input->offset, {reinterpret_cast<std::byte*>(target), count});
  } catch (const Error& failure) {
    // libpng is C: the failure crosses it as a message.
    input->is_io_failure = true;
    input->message = failure.detail();
  }
  input->offset += found;
  if (found < count) png_error(png, "the file ends early");
}

[[noreturn]] void keep_error(png_structp png, png_const_charp text) {
  auto* input = static_cast<PngInput*>(png_get_error_ptr(png));
  if (input->message.empty()) input->message = text;
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

/// A PNG file read up to its voxels. Every call that can fail is fenced by setjmp; no object with a
/// destructor lives between a setjmp and the calls it fences.
class PngFile {
 public:
  explicit PngFile(const std::string& path) : input_(path) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &input_, keep_error, ignore_warning);
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    if (info_ == nullptr) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw Error(ErrorKind::out_of_memory, "no memory for libpng", path);
    }
    if (!read_header()) {
      const Error failure = rejection();
      png_destroy_read_struct(&png_, &info_, nullptr);
      throw failure;
    }
  }
  ~PngFile() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  std::uint64_t bytes() const { return input_.file.size(); }
  std::int64_t width() const { return png_get_image_width(png_, info_); }
  std::int64_t height() const { return png_get_image_height(png_, info_); }
  int bit_depth() const { return png_get_bit_depth(png_, info_); }
  bool has_palette() const { return png_get_color_type(png_, info_) == PNG_COLOR_TYPE_PALETTE; }
  /// 1 grey, 2 with alpha, 3 RGB, 4 with alpha.
  std::int64_t channels() const { return png_get_channels(png_, info_); }

  /// Values of fewer than 8 bits are to be scaled to the range of 8; call it before read_voxels.
  void expand() { is_expanded_ = true; }

  /// The values of one channel. Requires a picture without palette and a plane of width x height
  /// values. Throws Error{source_rejected}.
  void read_voxels(std::int64_t channel, std::span<std::byte> plane) {
    if (channels() == 1) {
      read_all(plane);
      return;
    }
    const std::size_t value_bytes = bit_depth() == 16 ? 2 : 1;
    std::vector<std::byte> all(plane.size() * static_cast<std::size_t>(channels()));
    read_all(all);
    take_alternating({value_bytes, channels(), channel}, all, plane);
  }

 private:
  void read_all(std::span<std::byte> values) {
    const std::size_t row_bytes = values.size() / static_cast<std::size_t>(height());
    std::vector<png_bytep> rows(static_cast<std::size_t>(height()));
    for (std::size_t y = 0; y < rows.size(); ++y) {
      rows[y] = reinterpret_cast<png_bytep>(values.data() + y * row_bytes);
    }
    if (!read_rows(rows.data())) throw rejection();
  }

  bool read_header() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, &input_, read_bytes);
    png_read_info(png_, info_);
    return true;
  }

  bool read_rows(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    if (bit_depth() < 8 && is_expanded_) png_set_expand_gray_1_2_4_to_8(png_);
    if (bit_depth() < 8 && !is_expanded_) png_set_packing(png_);
    if (bit_depth() == 16 && needs_swap(true)) png_set_swap(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  Error rejection() const {
    return Error(input_.is_io_failure ? ErrorKind::io : ErrorKind::source_rejected,
                 "not a whole PNG file: " + escaped(input_.message), input_.file.path());
  }

  PngInput input_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  bool is_expanded_ = false;
};

struct PngShape {
  std::int64_t width = 0;
  std::int64_t height = 0;
  VoxelType type = VoxelType::uint8;
  std::int64_t channels = 1;
  bool operator==(const PngShape&) const = default;
};

PngShape shape_of(const PngFile& file, const std::string& path) {
  if (file.has_palette()) {
    throw Error(ErrorKind::source_rejected,
                "a color picture with a palette is not read; convert it to grey or RGB first",
                path);
  }
  const auto values = static_cast<std::uint64_t>(file.width() * file.height() * file.channels());
  require_holdable(path, file.bytes(), values * static_cast<std::uint64_t>(file.bit_depth()) / 8,
                   kDeflateRatio);
  return {file.width(), file.height(),
          file.bit_depth() == 16 ? VoxelType::uint16 : VoxelType::uint8, file.channels()};
}

std::string shape_text(const PngShape& shape) {
  const std::string channels =
      shape.channels == 1 ? "" : std::to_string(shape.channels) + " channels of ";
  return size_text(shape.width, shape.height) + " " + channels +
         std::string(voxel_type_name(shape.type));
}

/// Counts the chunks of a file that say more than the picture: its texts, its time, what cameras
/// and others put there. libpng passes over them.
void note_chunks(const std::string& path, SourceIdentity& identity) {
  constexpr std::uint64_t kSignatureBytes = 8;
  constexpr std::uint64_t kHeadBytes = 8;
  constexpr std::uint64_t kChecksumBytes = 4;
  constexpr char kPrivateBit = 0x20;
  static const std::set<std::string> kTelling = {"tEXt", "zTXt", "iTXt", "eXIf", "tIME", "iCCP"};
  const SourceFile file(path);
  std::array<std::byte, kHeadBytes> head{};
  for (std::uint64_t at = kSignatureBytes; file.read_some(at, head) == head.size();) {
    std::uint64_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::to_integer<unsigned>(head[i]);
    const std::string name(reinterpret_cast<const char*>(head.data()) + 4, 4);
    if (name == "IEND") return;
    if (kTelling.contains(name)) identity.note_lost(name);
    if ((name[1] & kPrivateBit) != 0) identity.note_lost("private");
    at += kHeadBytes + length + kChecksumBytes;
  }
}

/// The pictures of a stack, all of one shape.
struct PngStack {
  std::vector<std::string> files;
  PngShape shape;
  std::set<int> bit_depths;

  /// Programs that shrink PNG files store a plane of few grey levels with fewer bits. A white of 1
  /// is then the white of 255 in the plane beside it: the planes have one scale only at 8 bits.
  bool is_expanded() const { return bit_depths.size() > 1; }
};

/// Throws Error{source_rejected} naming the odd file with both shapes.
PngStack examine(const std::vector<std::string>& files) {
  PngStack stack;
  stack.files = files;
  for (const std::string& path : files) {
    const PngFile file(path);
    const PngShape shape = shape_of(file, path);
    if (stack.bit_depths.empty()) stack.shape = shape;
    stack.bit_depths.insert(file.bit_depth());
    if (shape == stack.shape) continue;
    throw Error(ErrorKind::source_rejected,
                "it is " + shape_text(shape) + ", " + escaped(base_name(files.front())) + " is " +
                    shape_text(stack.shape) + "; all planes of a stack must have one size and type",
                path);
  }
  return stack;
}

/// What becomes of pictures of fewer than 8 bits.
void add_depth_warning(const PngStack& stack, SourceFacts& facts) {
  const int fewest_bits = *stack.bit_depths.begin();
  if (fewest_bits >= 8) return;
  if (!stack.is_expanded()) {
    facts.warnings.push_back("pictures of " + std::to_string(fewest_bits) +
                             (fewest_bits == 1 ? " bit" : " bits") +
                             ": voxels are the stored numbers, 0 to " +
                             std::to_string((1 << fewest_bits) - 1));
    return;
  }
  std::string depths;
  for (const int bits : stack.bit_depths) {
    depths += (depths.empty() ? "" : bits == *stack.bit_depths.rbegin() ? " and " : ", ") +
              std::to_string(bits);
  }
  facts.warnings.push_back("pictures of " + depths +
                           " bits in one stack: all are scaled to 8 bits, white is 255");
}

class PngSource final : public IndexedPlaneSource {
 public:
  PngSource(SourceFacts facts, PngStack stack)
      : IndexedPlaneSource(std::move(facts)), stack_(std::move(stack)) {}

  void read_plane_at(std::int64_t z, std::span<std::byte> plane) const override {
    const std::string& path = stack_.files[static_cast<std::size_t>(z)];
    PngFile file(path);
    if (shape_of(file, path) != stack_.shape || !stack_.bit_depths.contains(file.bit_depth())) {
      throw Error(ErrorKind::source_rejected, "the file changed while it was read", path);
    }
    if (stack_.is_expanded()) file.expand();
    file.read_voxels(choice().channel, plane);
  }

 private:
  PngStack stack_;
};

}  // namespace

std::unique_ptr<PlaneSource> open_png_source(const std::vector<std::string>& files,
                                             const SourceOptions& options) {
  PngStack stack = examine(files);
  const PngShape& first = stack.shape;
  SourceFacts facts;
  facts.format = "PNG";
  facts.file_count = static_cast<std::int64_t>(files.size());
  facts.description.type = first.type;
  facts.description.size = {first.width, first.height, facts.file_count};
  facts.files = files_of_slices(files);
  if (!stack.is_expanded()) facts.files.outline = outline_of_slices(facts.files);
  add_depth_warning(stack, facts);
  settle_number_gaps(files, options, facts);
  facts.components.channels = first.channels;
  facts.components.channel_names = first.channels == 2 ? std::vector<std::string>{"grey", "alpha"}
                                                       : color_names(first.channels);
  for (const std::string& path : files) note_chunks(path, facts.identity);
  settle(facts, options, files.front());
  return std::make_unique<PngSource>(std::move(facts), std::move(stack));
}

}  // namespace octavo
