// What FreeType starts with in wheels, in the place of its ftinit.c: the modules that draw letters
// of the one font inside, which is TrueType. The others are then not linked, nor is Brotli, which
// only fonts of the web need.
#include <brotli/decode.h>
#include <ft2build.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include FT_FREETYPE_H
#include FT_MODULE_H
#include FT_RENDER_H
#include FT_SYSTEM_H

extern "C" {

extern const FT_Module_Class autofit_module_class;
extern const FT_Module_Class sfnt_module_class;
extern const FT_Renderer_Class ft_smooth_renderer_class;
extern const FT_Module_Class tt_driver_class;  // what a driver's class begins with

}  // extern "C"

namespace {

void* font_block(FT_Memory, long bytes) { return std::malloc(static_cast<std::size_t>(bytes)); }

void* longer_font_block(FT_Memory, long, long bytes, void* block) {
  return std::realloc(block, static_cast<std::size_t>(bytes));
}

void free_font_block(FT_Memory, void* block) { std::free(block); }

FT_MemoryRec_ font_memory{nullptr, font_block, free_font_block, longer_font_block};

}  // namespace

extern "C" {

FT_Error FT_Init_FreeType(FT_Library* library) {
  if (const FT_Error error = FT_New_Library(&font_memory, library)) return error;
  for (const FT_Module_Class* module :
       std::array{&autofit_module_class, &tt_driver_class, &sfnt_module_class,
                  &ft_smooth_renderer_class.root}) {
    if (const FT_Error error = FT_Add_Module(*library, module)) {
      FT_Done_Library(*library);
      return error;
    }
  }
  return FT_Err_Ok;
}

FT_Error FT_Done_FreeType(FT_Library library) { return FT_Done_Library(library); }

BrotliDecoderResult BrotliDecoderDecompress(std::size_t, const std::uint8_t*, std::size_t*,
                                            std::uint8_t*) {
  return BROTLI_DECODER_RESULT_ERROR;
}

}  // extern "C"
