#include "octavo/render/lettering.h"

#include <freetype/freetype.h>
#include <freetype/ftglyph.h>
#include <freetype/ftstroke.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {

// DejaVu Sans, from render/font.
extern const unsigned char kFontBytes[];
extern const unsigned long kFontBytes_size;

namespace {

constexpr double kMinimumSize = 4;
constexpr double kMaximumSize = 1000;
constexpr double kOutlineShare = 0.1;  // of the size
constexpr double kLineShare = 1.35;

// FreeType counts in 64ths of a pixel.
constexpr double kUnit = 64;

void require(FT_Error error) {
  if (error == FT_Err_Ok) return;
  if (error == FT_Err_Out_Of_Memory) throw Error(ErrorKind::out_of_memory, "no memory for letters");
  throw Error(ErrorKind::internal, "the font could not be read");
}

/// Unicode characters of UTF-8; 0xfffd for every byte that belongs to none.
std::vector<char32_t> characters(std::string_view text) {
  std::vector<char32_t> result;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) {
      return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0u;
    };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80       ? 1
                               : first >> 5 == 6  ? 2
                               : first >> 4 == 14 ? 3
                               : first >> 3 == 30 ? 4
                                                  : 0;
    char32_t character = length == 1 ? first : first & (0x7fu >> length);
    bool is_whole = length > 0;
    for (std::size_t k = 1; k < length; ++k) {
      is_whole = is_whole && byte(k) >> 6 == 2;
      character = character << 6 | (byte(k) & 0x3f);
    }
    result.push_back(is_whole ? character : char32_t{0xfffd});
    i += is_whole ? length : 1;
  }
  return result;
}

/// A glyph that FreeType hands out, given back at the end.
class OwnedGlyph {
 public:
  OwnedGlyph() = default;
  ~OwnedGlyph() { FT_Done_Glyph(glyph_); }
  OwnedGlyph(const OwnedGlyph&) = delete;
  OwnedGlyph& operator=(const OwnedGlyph&) = delete;
  FT_Glyph& get() { return glyph_; }

 private:
  FT_Glyph glyph_ = nullptr;
};

void blend_bitmap(Picture& picture, const FT_BitmapGlyph glyph, std::int64_t x, std::int64_t y,
                  const Color& color) {
  const FT_Bitmap& bitmap = glyph->bitmap;
  for (unsigned row = 0; row < bitmap.rows; ++row) {
    const unsigned char* const coverage =
        bitmap.buffer + static_cast<std::ptrdiff_t>(row) * bitmap.pitch;
    for (unsigned column = 0; column < bitmap.width; ++column) {
      picture.blend(x + glyph->left + column, y - glyph->top + row, color,
                    coverage[column] / 255.0);
    }
  }
}

}  // namespace

struct Lettering::Face {
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  FT_Stroker stroker = nullptr;
  double size_px = 0;

  explicit Face(double size) : size_px(size) {
    try {
      open();
    } catch (...) {
      close();
      throw;
    }
  }
  ~Face() { close(); }
  Face(const Face&) = delete;
  Face& operator=(const Face&) = delete;

  double outline_px() const { return std::max(1.0, size_px * kOutlineShare); }

  /// Loads a letter into the slot, and gives how far the next one is, pixels.
  double load(char32_t character) const {
    FT_UInt index = FT_Get_Char_Index(face, character);
    if (index == 0) index = FT_Get_Char_Index(face, U'?');
    require(FT_Load_Glyph(face, index, FT_LOAD_NO_BITMAP | FT_LOAD_TARGET_LIGHT));
    return static_cast<double>(face->glyph->linearHoriAdvance) / 65536;
  }

  double advance(const std::vector<char32_t>& text) const {
    double sum = 0;
    for (const char32_t character : text) sum += load(character);
    return sum;
  }

  enum class Layer { outline, letter };

  void draw(Picture& picture, std::int64_t x, std::int64_t baseline,
            const std::vector<char32_t>& text, Layer layer, const Color& color) const {
    double pen = 0;
    for (const char32_t character : text) {
      const double step = load(character);
      OwnedGlyph glyph;
      require(FT_Get_Glyph(face->glyph, &glyph.get()));
      if (layer == Layer::outline) {
        require(FT_Glyph_StrokeBorder(&glyph.get(), stroker, false, true));
      }
      const double whole = std::floor(pen);
      FT_Vector shift{std::lround((pen - whole) * kUnit), 0};
      require(FT_Glyph_To_Bitmap(&glyph.get(), FT_RENDER_MODE_NORMAL, &shift, true));
      blend_bitmap(picture, reinterpret_cast<FT_BitmapGlyph>(glyph.get()),
                   x + static_cast<std::int64_t>(whole), baseline, color);
      pen += step;
    }
  }

 private:
  void open() {
    require(FT_Init_FreeType(&library));
    require(
        FT_New_Memory_Face(library, kFontBytes, static_cast<FT_Long>(kFontBytes_size), 0, &face));
    require(FT_Set_Char_Size(face, 0, std::lround(size_px * kUnit), 72, 72));
    require(FT_Stroker_New(library, &stroker));
    FT_Stroker_Set(stroker, std::lround(outline_px() * kUnit), FT_STROKER_LINECAP_ROUND,
                   FT_STROKER_LINEJOIN_ROUND, 0);
  }

  void close() {
    FT_Stroker_Done(stroker);
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }
};

LetterColors letter_colors_on(const Color& ground) {
  const int brightness = 30 * ground[0] + 59 * ground[1] + 11 * ground[2];
  if (brightness < 100 * 128) return {};
  return {kBlack, {255, 255, 255}};
}

Lettering::Lettering(double size_px) {
  if (!(size_px >= kMinimumSize && size_px <= kMaximumSize)) {
    throw Error(ErrorKind::invalid_argument, "letters are 4 to 1000 pixels large");
  }
  face_ = std::make_unique<Face>(size_px);
}

Lettering::~Lettering() = default;

std::int64_t Lettering::cap_height() const {
  face_->load(U'H');
  return (face_->face->glyph->metrics.horiBearingY + 32) / 64;
}

std::int64_t Lettering::line_height() const { return std::llround(face_->size_px * kLineShare); }

std::int64_t Lettering::outline() const { return std::llround(std::ceil(face_->outline_px())); }

std::int64_t Lettering::width(std::string_view text) const {
  return std::llround(std::ceil(face_->advance(characters(text))));
}

std::string Lettering::fitted(std::string_view text, std::int64_t max_width) const {
  if (width(text) <= max_width) return std::string(text);
  const double ellipsis = face_->advance({U'\u2026'});
  double used = 0;
  std::size_t end = 0;
  while (end < text.size()) {
    std::size_t next = end + 1;
    while (next < text.size() && (static_cast<unsigned char>(text[next]) >> 6) == 2) ++next;
    used += face_->advance(characters(text.substr(end, next - end)));
    if (std::ceil(used + ellipsis) > static_cast<double>(max_width)) break;
    end = next;
  }
  return end == 0 ? std::string() : std::string(text.substr(0, end)) + "\u2026";
}

void Lettering::draw(Picture& picture, std::int64_t x, std::int64_t y, std::string_view text,
                     const LetterColors& colors) const {
  const std::vector<char32_t> letters = characters(text);
  const std::int64_t baseline = y + cap_height();
  face_->draw(picture, x, baseline, letters, Face::Layer::outline, colors.outline);
  face_->draw(picture, x, baseline, letters, Face::Layer::letter, colors.letter);
}

}  // namespace octavo
