// What benchmarks of surfaces are given: "[--rounds N] [--threads N] VOLUME ISOVALUE".
//
// VOLUME    "NAME PATH nx,ny,nz,type [grey sx,sy,sz]", a headerless file
// ISOVALUE  stored values at or above it lie inside
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <tbb/global_control.h>

#include "bench/common/raw_volume.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/mesh/memory_surface.h"

namespace octavo::bench {

/// Keeps to the threads that are asked for as long as it lives.
class SurfaceInput {
 public:
  /// name  of the benchmark
  /// Throws Error{invalid_argument} on other words, and as load_raw_volume
  SurfaceInput(const std::string& name, int count, char** words)
      : rest_(take_settings(count, words, settings_)),
        raw_(load_raw_volume(volume_word(name))),
        field_(SurfaceField::of_grey(std::stod(rest_[1]), false, raw_.type)),
        threads_(tbb::global_control::max_allowed_parallelism,
                 static_cast<std::size_t>(settings_.threads)) {}

  int rounds() const { return settings_.rounds; }
  Geometry geometry() const { return {.spacing_mm = raw_.spacing_mm}; }

  TriangleMesh surface() const {
    NoProgress silent;
    return surface_of({raw_.voxels.data(), raw_.type, raw_.size, geometry()}, field_, silent);
  }

 private:
  const std::string& volume_word(const std::string& name) const {
    if (rest_.size() == 2) return rest_[0];
    throw Error(ErrorKind::invalid_argument,
                "usage: " + name + " [--rounds N] [--threads N] VOLUME ISOVALUE");
  }

  Settings settings_;
  std::vector<std::string> rest_;
  RawVolume raw_;
  SurfaceField field_;
  tbb::global_control threads_;
};

}  // namespace octavo::bench
