// Small volumes of every type made of arbitrary bytes: what is built reads back as it was, or
// within the max error, and building it again gives the same bytes.
#include <algorithm>
#include <cmath>

#include "fuzz/fuzz_target.h"
#include "octavo/builder/builder.h"
#include "octavo/file/reader.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"

namespace {

using namespace octavo;
using fuzz::fail;

constexpr std::uint8_t kMostVoxelsOfAnAxis = 8;

struct Volume {
  VolumeDescription description;
  BuildOptions options;
  std::vector<std::byte> voxels;
};

Volume take_volume(fuzz::Input& input) {
  Volume volume;
  VolumeDescription& description = volume.description;
  const auto choice = input.take<std::uint8_t>();
  constexpr VoxelType kTypes[] = {VoxelType::uint8,  VoxelType::int8,   VoxelType::uint16,
                                  VoxelType::int16,  VoxelType::uint32, VoxelType::int32,
                                  VoxelType::float32};
  description.type = kTypes[(choice & 0x0f) % std::size(kTypes)];
  const bool is_float = description.type == VoxelType::float32;
  const bool is_signed = value_range(is_float ? VoxelType::int8 : description.type).min < 0;
  if (choice & 0x10 && !is_signed) description.kind = VolumeKind::labels;
  for (int axis = 0; axis < 3; ++axis) {
    description.size[axis] = 1 + input.take<std::uint8_t>() % kMostVoxelsOfAnAxis;
  }
  if (choice & 0x20) description.geometry.spacing_mm = {1, 1, 4};
  volume.options.kind = description.kind;
  volume.options.preset = choice & 0x40 ? Preset::fast : Preset::small;
  const auto error = input.take<std::uint16_t>();
  if (choice & 0x80 && description.kind == VolumeKind::grey) {
    volume.options.max_error = is_float ? std::ldexp(1.0 + error, -8) : error;
  }
  volume.options.overwrite = true;
  volume.options.threads = 1;
  // The bytes that there are, again and again.
  const auto width = static_cast<std::size_t>(bytes_per_voxel(description.type));
  volume.voxels.resize(static_cast<std::size_t>(description.size.voxel_count()) * width);
  const auto bytes = input.take_bytes(volume.voxels.size());
  for (std::size_t i = 0; i < volume.voxels.size() && !bytes.empty(); ++i) {
    volume.voxels[i] = static_cast<std::byte>(bytes[i % bytes.size()]);
  }
  return volume;
}

std::vector<std::uint8_t> build(const Volume& volume) {
  testing::MemoryStorage storage;
  NoProgress progress;
  build_file(*make_memory_source(volume.description, volume.voxels), storage, "a", volume.options,
             progress);
  return *storage.files.at("a");
}

template <class T>
void check_bound(const Volume& volume, const std::vector<std::byte>& found, double bound) {
  for (std::size_t at = 0; at < found.size(); at += sizeof(T)) {
    T was;
    T is;
    std::memcpy(&was, volume.voxels.data() + at, sizeof was);
    std::memcpy(&is, found.data() + at, sizeof is);
    const double difference = static_cast<double>(was) - static_cast<double>(is);
    if (!(std::abs(difference) <= bound)) fail("a voxel beyond the max error");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const Volume volume = take_volume(input);
  std::vector<std::uint8_t> bytes;
  try {
    bytes = build(volume);
  } catch (const Error& error) {
    // Floats that no coding holds; nothing else may be rejected.
    const bool is_float = volume.description.type == VoxelType::float32;
    if (!is_float || error.kind() != ErrorKind::source_rejected) fail(error.what());
    return 0;
  }
  if (build(volume) != bytes) fail("other bytes at the second time");

  const auto reader = FileReader::open(byte_source_of(bytes, "a"));
  std::vector<std::byte> found(volume.voxels.size());
  reader->read(box_of(volume.description.size), 0, found.data());
  if (volume.options.max_error == 0) {
    if (found != volume.voxels) fail("other voxels");
    return 0;
  }
  with_voxel_type(volume.description.type, [&](auto id) {
    check_bound<typename decltype(id)::type>(volume, found, reader->max_error());
  });
  if (reader->max_error() > volume.options.max_error) fail("a larger bound than asked for");
  return 0;
}
