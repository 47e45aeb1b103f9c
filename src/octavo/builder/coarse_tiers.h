// The tiers above tier 0, made of the samples that the bricks below them left.
#pragma once

#include <cstddef>
#include <vector>

#include "octavo/builder/tier_encoder.h"

namespace octavo {

/// What the bricks of a file are encoded with and given to.
struct TierTarget {
  const VolumeDescription& description;
  const Levels& levels;
  Workers& workers;
  BrickSink& sink;
  Progress& progress;
};

/// Encodes the tiers above tier 0 exactly, all with the first group's model or, where that one
/// changes voxels, with an untrained one: they are too small to learn from.
/// settings  of the first model; max_error says whether it changes voxels
/// samples   of the first level of tier 1, [z][y][x], of the coded type
/// Throws    what TierEncoder::finish throws
void encode_coarse_tiers(const TierTarget& target, const Model& first_model,
                         const CodecSettings& settings, std::vector<std::byte> samples);

}  // namespace octavo
