// A brick of labels that coding would enlarge: its voxels as packed numbers in one segment.
//
// A varint K; K labels, rising, each as a varint: its distance from the one before less 1, the
// first from the least label of the brick. Then the voxels, x fastest, as bit fields, lowest bit
// first: numbers of labels when K > 0, else distances from the least label of the brick.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/codec/label/label_pyramid.h"

namespace octavo {

/// The shorter of the two forms.
Bytes encode_stored_labels(const LabelPyramid& pyramid);

/// Bytes that encode_stored_labels would make.
std::uint64_t stored_label_bytes(const LabelPyramid& pyramid);

/// The labels of all `voxel_count` voxels. Throws Error{corrupt}.
std::vector<std::int64_t> decode_stored_labels(ByteSpan segment, const ValueRange& range,
                                               std::int64_t voxel_count);

}  // namespace octavo
