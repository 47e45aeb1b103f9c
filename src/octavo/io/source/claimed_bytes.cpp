#include "octavo/io/source/claimed_bytes.h"

#include "octavo/core/error.h"

namespace octavo {

void require_holdable(const std::string& path, std::uint64_t bytes_there,
                      std::uint64_t claimed_bytes, std::uint64_t ratio) {
  constexpr std::uint64_t kCheapBytes = std::uint64_t{1} << 20;
  if (claimed_bytes <= kCheapBytes || (claimed_bytes - kCheapBytes) / ratio <= bytes_there) return;
  throw Error(ErrorKind::source_rejected,
              std::to_string(bytes_there) + " bytes cannot hold the " +
                  std::to_string(claimed_bytes) +
                  " bytes of voxels that its header claims; it is cut or its header is wrong",
              path);
}

}  // namespace octavo
