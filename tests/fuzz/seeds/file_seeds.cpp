#include <span>

#include "fuzz/brick_input.h"
#include "fuzz/seeds/seed_folder.h"
#include "fuzz/seeds/seed_voxels.h"
#include "octavo/builder/builder.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"

namespace octavo::fuzz {

namespace {

Bytes file_of(const VolumeDescription& description, double max_error) {
  const Bytes voxels = make_voxels(description.size, description.type, description.kind,
                                   Content::shape);
  const auto source = make_memory_source(description, std::as_bytes(std::span(voxels)));
  testing::MemoryStorage storage;
  NoProgress progress;
  BuildOptions options;
  options.kind = description.kind;
  options.max_error = max_error;
  options.overwrite = true;
  options.threads = 1;
  build_file(*source, storage, "a", options, progress);
  return *storage.files.at("a");
}

void save_file(SeedFolder& seeds, VolumeKind kind, VoxelType type, const Size3& size,
               double max_error = 0) {
  VolumeDescription description;
  description.kind = kind;
  description.type = type;
  description.size = size;
  const Bytes file = file_of(description, max_error);
  seeds.save("open", file);
  seeds.save("reader", file);
  Bytes for_salvage = {0};
  put_bytes(for_salvage, file);
  seeds.save("salvage", for_salvage);
}

}  // namespace

void save_files(SeedFolder& seeds) {
  for (const VolumeKind kind : {VolumeKind::grey, VolumeKind::labels}) {
    for (const VoxelType type : kTypes) {
      for (const Size3& size :
           {Size3{1, 1, 1}, Size3{9, 5, 3}, Size3{16, 16, 16}, Size3{70, 3, 66}}) {
        save_file(seeds, kind, type, size);
      }
    }
  }
  // The voxels are read as floats by their bits: tiny multiples of the smallest one.
  for (const double max_error : {0.0, 1e-41}) {
    save_file(seeds, VolumeKind::grey, VoxelType::float32, {70, 3, 66}, max_error);
  }
  save_file(seeds, VolumeKind::grey, VoxelType::int16, {70, 3, 66}, 2);
}

}  // namespace octavo::fuzz
