// Samples of a brick as plain bits above the smallest one (docs/format-grey.md, section 3).
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "octavo/codec/grey/grey_brick.h"

namespace octavo::grey {

/// What all samples of a level take.
inline std::uint64_t stored_bytes(const SampleScale& scale, const Size3& size) {
  return (static_cast<std::uint64_t>(size.voxel_count()) *
              static_cast<std::uint64_t>(scale.plain_width()) + 7) / 8;
}

template <class Sample>
Bytes encode_plain(const SampleScale& scale, const std::vector<Sample>& samples) {
  Bytes out;
  BitWriter bits(out);
  for (const Sample s : samples) {
    bits.put(static_cast<std::uint64_t>(s - scale.min_sample()), scale.plain_width());
  }
  bits.finish();
  return out;
}

/// Throws Error{corrupt} on bytes of another number.
template <class Sample>
std::vector<Sample> decode_plain(const SampleScale& scale, ByteSpan bytes, const Size3& size) {
  if (bytes.size() != stored_bytes(scale, size)) {
    throw Error(ErrorKind::corrupt, "plain samples: " + std::to_string(bytes.size()) + " bytes, " +
                                        std::to_string(stored_bytes(scale, size)) + " expected");
  }
  std::vector<Sample> samples(static_cast<std::size_t>(size.voxel_count()));
  BitReader bits(bytes);
  for (Sample& s : samples) {
    const auto above = static_cast<std::int64_t>(bits.get(scale.plain_width()));
    s = static_cast<Sample>(std::min(scale.min_sample() + above, scale.max_sample()));
  }
  return samples;
}

}  // namespace octavo::grey
