#include "octavo/dist/proven_source.h"

#include <string>

#include "octavo/core/error.h"

namespace octavo {

void require_planned(const BuildPlan& plan, const VolumeDescription& source) {
  const VolumeDescription& planned = plan.source;
  const char* what = nullptr;
  if (source.size != planned.size) what = "size";
  else if (source.type != planned.type || source.kind != planned.kind) what = "voxel type";
  else if (source.geometry != planned.geometry) what = "geometry";
  else if (source.rescale != planned.rescale) what = "rescale";
  else if (source.metadata.text() != planned.metadata.text()) what = "metadata";
  if (what == nullptr) return;
  throw Error(ErrorKind::source_rejected,
              std::string("its ") + what +
                  " is not that of the source that was planned; plan again");
}

void require_first_voxels(const BuildPlan& plan, const VoxelBlock& group, const Model& model) {
  if (content_hash_of(group) != plan.content_hash) {
    throw Error(ErrorKind::source_rejected,
                "the first planes hold other voxels than when the build was planned; plan again");
  }
  if (model.serialized == plan.first_model) return;
  throw Error(ErrorKind::invalid_argument,
              "the build was planned by another version of the program; plan again with this one");
}

}  // namespace octavo
