#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/exact/float_codes.h"

namespace octavo {

std::unique_ptr<BrickCodec> train_exact_model(std::span<const TrainingBrick> bricks,
                                              const CodecSettings& settings,
                                              const SampleCoding& coding) {
  std::vector<exact::QuantizedBrick> quantized;
  for (const TrainingBrick& brick : bricks) {
    quantized.push_back(exact::quantized(coding, brick.shape, brick.view));
    quantized.back().voxels = {};
  }
  std::vector<TrainingBrick> codes;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    codes.push_back({bricks[i].shape, exact::code_view(quantized[i], bricks[i].view.size)});
  }
  // What tells floats apart runs through all of a brick: parts of its codes would be of no use.
  CodecSettings whole = settings;
  whole.access = Access::none;
  return make_exact_codec(train_model(VolumeKind::grey, VoxelType::int32, codes, whole), coding);
}

}  // namespace octavo
