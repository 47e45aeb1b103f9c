#include "octavo/codec/label/label_stored.h"

#include <string>

#include "octavo/codec/entropy/byte_io.h"

namespace octavo {

namespace {

std::uint64_t packed_bytes(std::uint64_t count, int width) {
  return (count * static_cast<std::uint64_t>(width) + 7) / 8;
}

/// Bits of a number up to `most`.
int width_of(std::int64_t most) { return bit_length(static_cast<std::uint64_t>(most)); }

std::int64_t maximum_number(const LabelPyramid& pyramid, bool is_listed) {
  return is_listed ? static_cast<std::int64_t>(pyramid.labels.size()) - 1
                   : pyramid.labels.back() - pyramid.labels.front();
}

Bytes listed(const LabelPyramid& pyramid, bool is_listed) {
  Bytes bytes;
  put_varint(bytes, is_listed ? pyramid.labels.size() : 0);
  if (!is_listed) return bytes;
  std::int64_t next = pyramid.labels.front();
  for (const std::int64_t label : pyramid.labels) {
    put_varint(bytes, static_cast<std::uint64_t>(label - next));
    next = label + 1;
  }
  return bytes;
}

std::uint64_t byte_count(const LabelPyramid& pyramid, bool is_listed) {
  const auto voxels = static_cast<std::uint64_t>(pyramid.levels[0].size.voxel_count());
  return listed(pyramid, is_listed).size() +
         packed_bytes(voxels, width_of(maximum_number(pyramid, is_listed)));
}

bool is_list_shorter(const LabelPyramid& pyramid) {
  return byte_count(pyramid, true) < byte_count(pyramid, false);
}

std::vector<std::int64_t> take_list(ByteSpan& segment, const ValueRange& range) {
  const std::uint64_t count = take_varint(segment);
  if (count > segment.size()) throw Error(ErrorKind::corrupt, "a list of labels ends early");
  std::vector<std::int64_t> labels;
  std::int64_t next = range.min;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t gap = take_varint(segment);
    if (next > range.max || gap > static_cast<std::uint64_t>(range.max - next)) {
      throw Error(ErrorKind::corrupt, "a stored label is outside the range of its brick");
    }
    labels.push_back(next + static_cast<std::int64_t>(gap));
    next = labels.back() + 1;
  }
  return labels;
}

}  // namespace

std::uint64_t stored_label_bytes(const LabelPyramid& pyramid) {
  return byte_count(pyramid, is_list_shorter(pyramid));
}

Bytes encode_stored_labels(const LabelPyramid& pyramid) {
  const bool is_listed = is_list_shorter(pyramid);
  Bytes bytes = listed(pyramid, is_listed);
  BitWriter bits(bytes);
  const int width = width_of(maximum_number(pyramid, is_listed));
  for (const std::uint32_t rank : pyramid.levels[0].rank) {
    const std::int64_t above = pyramid.labels[rank] - pyramid.labels.front();
    bits.put(is_listed ? rank : static_cast<std::uint64_t>(above), width);
  }
  bits.finish();
  return bytes;
}

std::vector<std::int64_t> decode_stored_labels(ByteSpan segment, const ValueRange& range,
                                               std::int64_t voxel_count) {
  const std::vector<std::int64_t> list = take_list(segment, range);
  const auto listed_count = static_cast<std::int64_t>(list.size());
  const std::int64_t most = list.empty() ? range.max - range.min : listed_count - 1;
  const int width = width_of(most);
  const std::uint64_t expected = packed_bytes(static_cast<std::uint64_t>(voxel_count), width);
  if (segment.size() != expected) {
    throw Error(ErrorKind::corrupt, "stored labels: " + std::to_string(segment.size()) +
                                        " bytes, " + std::to_string(expected) + " expected");
  }
  std::vector<std::int64_t> labels(static_cast<std::size_t>(voxel_count));
  BitReader bits(segment);
  for (std::int64_t& label : labels) {
    const auto number = static_cast<std::int64_t>(bits.get(width));
    if (number > most) {
      throw Error(ErrorKind::corrupt, "a stored label is outside the range of its brick");
    }
    label = list.empty() ? range.min + number : list[static_cast<std::size_t>(number)];
  }
  return labels;
}

}  // namespace octavo
