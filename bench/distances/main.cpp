// Signed distances beside ITK's SignedMaurerDistanceMapImageFilter, in turns, one thread.
//
// usage: bench_distances [--commit ID] [--rounds N] VOLUME...
//
// VOLUME  NAME=PATH,nx,ny,nz,LOWEST: a headerless file of uint8 or int16 (told by its size), the
//         mask is what is not below LOWEST. Voxels are cubes of 1 mm.
//
// Both write float32 to memory that is new each time. Octavo begins with the tree of the mask, ITK
// with an image of bytes. Both must give the same distances, to the centers of voxels: inside, ITK
// measures to the mask's own border voxels, so those outside are compared. Times are CPU seconds,
// which other programs of the machine disturb least.

#include <itkImage.h>
#include <itkMultiThreaderBase.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/ops/distance/distance_passes.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo::bench {
namespace {

using MaskImage = itk::Image<unsigned char, 3>;
using DistanceImage = itk::Image<float, 3>;

struct MeasuredMask {
  std::string name;
  Size3 size;
  std::vector<std::uint8_t> inside;
};

MeasuredMask load_mask(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) throw Error(ErrorKind::invalid_argument, "no volume: " + text);
  MeasuredMask mask{text.substr(0, equals), {}, {}};
  std::stringstream rest(text.substr(equals + 1));
  std::string words[5];
  for (std::string& word : words) std::getline(rest, word, ',');
  mask.size = {std::stoll(words[1]), std::stoll(words[2]), std::stoll(words[3])};
  const auto count = static_cast<std::size_t>(mask.size.voxel_count());
  const bool is_wide = std::filesystem::file_size(words[0]) == 2 * count;
  std::vector<char> bytes(count * (is_wide ? 2 : 1));
  std::ifstream file(words[0], std::ios::binary);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    throw Error(ErrorKind::io, "cannot be read", words[0]);
  }
  const int lowest = std::stoi(words[4]);
  for (std::size_t i = 0; i < count; ++i) {
    std::int16_t value = static_cast<std::uint8_t>(bytes[i]);
    if (is_wide) std::memcpy(&value, bytes.data() + 2 * i, sizeof value);
    mask.inside.push_back(value >= lowest ? 1 : 0);
  }
  return mask;
}

DistanceImage::Pointer itk_distances(MaskImage* image) {
  auto filter = itk::SignedMaurerDistanceMapImageFilter<MaskImage, DistanceImage>::New();
  filter->SetInput(image);
  filter->SquaredDistanceOff();
  filter->UseImageSpacingOn();
  filter->SetNumberOfWorkUnits(1);
  filter->Update();
  return filter->GetOutput();
}

void run_mask(const MeasuredMask& mask, const Settings& settings) {
  const BrickView view = {mask.inside.data(), VoxelType::uint8, mask.size, mask.size.x,
                          mask.size.x * mask.size.y};
  const MaskTree tree = make_mask(view, {1, 1});
  auto image = MaskImage::New();
  image->SetRegions(MaskImage::SizeType{{static_cast<itk::SizeValueType>(mask.size.x),
                                         static_cast<itk::SizeValueType>(mask.size.y),
                                         static_cast<itk::SizeValueType>(mask.size.z)}});
  image->Allocate();
  std::copy(mask.inside.begin(), mask.inside.end(), image->GetBufferPointer());

  const auto voxels = static_cast<std::uint64_t>(mask.inside.size());
  Row octavo{1, mask.name, "octavo distance to centers", {}, 4 * voxels, voxels, voxels, 0};
  Row faces = octavo;
  faces.operation = "octavo distance to faces";
  Row itk = octavo;
  itk.operation = "itk SignedMaurerDistanceMap";
  NoProgress progress;
  const auto timed = [](Row& row, const auto& work) {
    const double began = cpu_seconds();
    work();
    row.seconds.push_back(cpu_seconds() - began);
  };
  for (int round = 0; round < settings.rounds; ++round) {
    std::vector<float> ours;
    const auto measured = [&](DistanceTo to) {
      return signed_distances(tree, {to, {1, 1, 1}}, progress);
    };
    timed(octavo, [&] { ours = measured(DistanceTo::centers); });
    timed(faces, [&] { measured(DistanceTo::faces); });
    DistanceImage::Pointer theirs;
    timed(itk, [&] { theirs = itk_distances(image); });
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const float other = theirs->GetBufferPointer()[i];
      if (mask.inside[i] == 0 && std::abs(ours[i] - other) > 1e-4F * std::abs(other)) {
        throw Error(ErrorKind::internal, "distances differ at voxel " + std::to_string(i));
      }
    }
  }
  for (const Row* row : {&octavo, &faces, &itk}) {
    std::cout << csv_line(*row, settings.commit) << std::endl;
  }
}

}  // namespace
}  // namespace octavo::bench

int main(int argc, char** argv) {
  using namespace octavo;
  return bench::run_named("bench_distances", [&] {
    bench::Settings settings;
    const std::vector<std::string> volumes = bench::take_settings(argc, argv, settings);
    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(1);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    std::cout << bench::csv_header() << "\n";
    for (const std::string& text : volumes) bench::run_mask(bench::load_mask(text), settings);
  });
}
