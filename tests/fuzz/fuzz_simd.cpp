// Bricks of arbitrary bytes through the portable and the vectorized decoders: the same voxels or
// the same error, on every level.
//
// Each is a build of the reading half with a name of its own for the namespace octavo
// (CMakeLists.txt), so that one program holds both.

#include <cstdio>
#include <cstdlib>

#include "fuzz/decoded_brick.h"

namespace {

[[noreturn]] void complain(std::size_t level, const std::string& portable,
                           const std::string& simd) {
  std::fprintf(stderr, "answer %zu differs; portable: %s; vectorized: %s\n", level,
               portable.c_str(), simd.c_str());
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto portable = octavo_portable::fuzz::decode_brick(data, size);
  const auto simd = octavo_simd::fuzz::decode_brick(data, size);
  if (portable.size() != simd.size()) complain(portable.size(), "all", "all");
  for (std::size_t i = 0; i < portable.size(); ++i) {
    if (portable[i].error != simd[i].error) complain(i, portable[i].error, simd[i].error);
    if (portable[i].voxels != simd[i].voxels) complain(i, "other voxels", "other voxels");
  }
  return 0;
}
