#include "octavo/builder/coarse_tiers.h"

#include <utility>

namespace octavo {

void encode_coarse_tiers(const TierTarget& target, const Model& first_model,
                         const CodecSettings& settings, std::vector<std::byte> samples) {
  const Levels& levels = target.levels;
  const VoxelType type = target.description.codec_type();
  Model model = first_model;
  if (settings.max_error > 0 && levels.tier_count() > 1) {
    CodecSettings exact = settings;
    exact.max_error = 0;
    model = make_model(train_model(target.description.kind, type, {}, exact), type);
    target.sink.add_model(model.serialized);
  }
  for (int tier = 1; tier < levels.tier_count(); ++tier) {
    const Size3& size = levels.size(Levels::first_level(tier));
    TierEncoder encoder(levels, tier, type, target.workers, target.sink, target.progress);
    encoder.encode(model, {samples.data(), type, size, 0});
    samples = encoder.take_parents();
  }
}

}  // namespace octavo
