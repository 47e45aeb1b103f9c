// What wheels leave out of zstd, in the place of objects of its archive that are then not linked.
// Chunks are packed at level 5 and, behind blosc, at 9, each whole and without a dictionary:
// strategies of lower and higher levels are never called. Frames that zstd wrote before 0.8 are
// rejected, as by one that is built without them.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace {

constexpr std::size_t kVersionUnsupported = ~std::size_t{0} - 11;  // what ZSTD_isError() knows: -12
constexpr std::uint64_t kUnknownLength = ~std::uint64_t{0} - 1;    // ZSTD_CONTENTSIZE_ERROR

}  // namespace

extern "C" {

#define OCTAVO_NEVER_CALLED(name) \
  void name() { std::abort(); }
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_fast)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_fast_dictMatchState)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_fast_extDict)
OCTAVO_NEVER_CALLED(ZSTD_fillHashTable)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_doubleFast)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_doubleFast_dictMatchState)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_doubleFast_extDict)
OCTAVO_NEVER_CALLED(ZSTD_fillDoubleHashTable)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_btopt)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_btopt_dictMatchState)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_btopt_extDict)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_btultra)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_btultra2)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_btultra_dictMatchState)
OCTAVO_NEVER_CALLED(ZSTD_compressBlock_btultra_extDict)
OCTAVO_NEVER_CALLED(ZSTD_updateTree)
#undef OCTAVO_NEVER_CALLED

#define OCTAVO_NO_LEGACY(version)                                                            \
  std::size_t ZSTD##version##_decompress_usingDict() { return kVersionUnsupported; }         \
  void ZSTD##version##_findFrameSizeInfoLegacy(const void*, std::size_t, std::size_t* bytes, \
                                               std::uint64_t* length) {                      \
    *bytes = kVersionUnsupported;                                                            \
    *length = kUnknownLength;                                                                \
  }                                                                                          \
  std::size_t ZSTD##version##_getFrameParams() { return kVersionUnsupported; }               \
  void* ZSTD##version##_createDCtx() { return nullptr; }                                     \
  std::size_t ZSTD##version##_freeDCtx() { return 0; }                                       \
  void* ZBUFF##version##_createDCtx() { return nullptr; }                                    \
  std::size_t ZBUFF##version##_freeDCtx() { return 0; }                                      \
  std::size_t ZBUFF##version##_decompressInitDictionary() { return kVersionUnsupported; }    \
  std::size_t ZBUFF##version##_decompressContinue() { return kVersionUnsupported; }
OCTAVO_NO_LEGACY(v05)
OCTAVO_NO_LEGACY(v06)
OCTAVO_NO_LEGACY(v07)
#undef OCTAVO_NO_LEGACY

}  // extern "C"
