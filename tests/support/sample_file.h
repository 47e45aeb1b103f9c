// Small .8vo files with known voxels at every level, written through the real writer.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/file/write/writer.h"
#include "support/memory_storage.h"

namespace octavo::testing {

/// A volume and what its file must give back.
struct SampleVolume {
  VolumeDescription description;
  Levels levels;
  std::vector<Bytes>
      samples;  ///< of every level, dense [z][y][x]; filled by write_sample for levels > 0
  std::int64_t model_layers = 1;  ///< a new model every so many layers
  double max_error = 0;           ///< of the file, voxel units
  std::int64_t codec_error = 0;   ///< what its bricks are coded with; samples are codes then
  /// What takes the place of the codec of each group; none: that one itself.
  std::function<std::unique_ptr<BrickCodec>(const BrickCodec&)> changed_codec = {};
  /// How far the samples of the next tier lie from what the bricks determine.
  std::int64_t parent_error = 0;
};

/// How the voxels of a sample vary.
enum class Pattern { constant, gradient, noisy_half };

/// `noisy_half`: uniform below the middle plane in z, noise above.
SampleVolume make_sample(const Size3& size, VoxelType type, Pattern pattern,
                         VolumeKind kind = VolumeKind::grey);

/// Encodes all bricks of `volume` and writes them to `path`. Fills the samples of the coarser
/// levels with what the codec gives back in memory, without any file.
void write_sample(Storage& storage, const std::string& path, SampleVolume& volume,
                  bool overwrite = false);

/// Encodes all bricks of `volume` and gives them to `writer`, which is not finished.
void encode_sample(FileWriter& writer, SampleVolume& volume);

/// The digests of `plane_count` planes of equal size.
std::vector<Sha256Digest> digests_of_planes(ByteSpan planes, std::size_t plane_count);

/// The digests of the planes of a layer of bricks, from volume.samples[0].
std::vector<Sha256Digest> sample_plane_digests(const SampleVolume& volume, std::int64_t layer);

/// A float32 file of small codes with a max error of 3 codes, of two slabs.
SampleVolume make_lossy_float_sample();

/// The bytes of the file of `volume`.
std::vector<std::uint8_t> sample_file_bytes(SampleVolume& volume);

/// A reader over bytes in memory.
std::shared_ptr<FileReader> open_bytes(std::vector<std::uint8_t> bytes);

/// The part of a level of `volume` that `box` covers.
Bytes expected_samples(const SampleVolume& volume, const Box& box, int level);

/// What `reader` gives for a box.
Bytes read_samples(const FileReader& reader, const Box& box, int level);

}  // namespace octavo::testing
