// Trains the start weights of the label codec.
//
//   label_weights MAPS_TXT OUTPUT.inc [EPOCHS]
//
// MAPS_TXT is what make_maps.py writes. Every map gives the same number of questions at most, so
// that large maps do not drown small ones. Each map is asked whole, and again with its axes turned,
// because weights have no other way to learn that directions are alike.

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "octavo/codec/label/label_start_weights.h"
#include "octavo/codec/label/label_trainer.h"
#include "octavo/codec/label/label_walk.h"
#include "octavo/core/levels.h"

namespace {

using namespace octavo;

constexpr std::size_t kQuestionsPerMap = std::size_t{1} << 16;

struct LabelMap {
  std::string name;
  Size3 size;
  VoxelType type = VoxelType::uint8;
  std::vector<char> bytes;
};

std::vector<LabelMap> read_maps(const std::string& list) {
  const std::string folder = list.substr(0, list.find_last_of('/') + 1);
  std::ifstream in(list);
  std::vector<LabelMap> maps;
  std::string name, dimensions;
  while (in >> name >> dimensions) {
    LabelMap map{name, {}, VoxelType::uint8, {}};
    char type[16] = {};
    long long x = 0, y = 0, z = 0;
    if (std::sscanf(dimensions.c_str(), "%lld,%lld,%lld,%15s", &x, &y, &z, type) != 4) {
      throw Error(ErrorKind::invalid_argument, list + ": not a size and a type: " + dimensions);
    }
    map.size = {x, y, z};
    map.type = parse_voxel_type(type).value();
    map.bytes.resize(static_cast<std::size_t>(map.size.voxel_count() * bytes_per_voxel(map.type)));
    std::ifstream raw(folder + name + ".raw", std::ios::binary);
    if (!raw.read(map.bytes.data(), static_cast<std::streamsize>(map.bytes.size()))) {
      throw Error(ErrorKind::io, folder + name + ".raw: missing or too short");
    }
    maps.push_back(std::move(map));
  }
  if (maps.empty()) throw Error(ErrorKind::io, list + ": no maps");
  return maps;
}

/// x, y, z of the result are y, z, x of `map`.
LabelMap turned(const LabelMap& map) {
  LabelMap result{map.name, {map.size.y, map.size.z, map.size.x}, map.type, map.bytes};
  const auto width = static_cast<std::size_t>(bytes_per_voxel(map.type));
  const char* from = map.bytes.data();
  for (std::int64_t z = 0; z < map.size.z; ++z) {
    for (std::int64_t y = 0; y < map.size.y; ++y) {
      for (std::int64_t x = 0; x < map.size.x; ++x, from += width) {
        const std::int64_t at = (x * result.size.y + z) * result.size.x + y;
        std::copy_n(from, width, result.bytes.data() + static_cast<std::size_t>(at) * width);
      }
    }
  }
  return result;
}

void ask(const LabelMap& map, LabelObserver& observer) {
  const LabelModel model({}, label_start_weights());
  const Levels levels(map.size, choose_halvings(map.size, {1, 1, 1}));
  const Size3 grid = levels.brick_grid(0);
  for (std::int64_t z = 0; z < grid.z; ++z) {
    for (std::int64_t y = 0; y < grid.y; ++y) {
      for (std::int64_t x = 0; x < grid.x; ++x) {
        const Box box = levels.brick_box(0, {x, y, z});
        const BrickShape shape = brick_shape(levels, 0, {x, y, z});
        const std::int64_t first =
            (box.lo.z * map.size.y + box.lo.y) * map.size.x + box.lo.x;
        const LabelPyramid pyramid = build_label_pyramid(
            shape, {map.bytes.data() + first * bytes_per_voxel(map.type), map.type, box.size(),
                    map.size.x, map.size.x * map.size.y});
        if (pyramid.is_uniform() || pyramid.labels.size() > kMaxLabelSlots) continue;
        label_walk_functions().observe(model, shape, pyramid, observer, thread_label_work());
      }
    }
  }
}

LabelWeights random_weights(std::mt19937& random) {
  // Sums of 32 rows stay small; output weights are larger. Drawn by hand, because the standard
  // does not fix what its distributions give.
  const auto draw = [&](int most) {
    int sum = 0;
    for (int i = 0; i < 4; ++i) sum += static_cast<int>(random() >> 8) % (2 * most + 1) - most;
    return static_cast<std::int8_t>(sum / 2);
  };
  LabelWeights weights{};
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weights[i] = draw(i < weights.size() - kLabelHidden ? 4 : 12);
  }
  return weights;
}

void write(const std::string& path, const LabelWeightSet& set) {
  std::ofstream out(path);
  std::string line;
  for (const LabelWeights& weights : set) {
    for (const std::int8_t weight : weights) {
      const std::string number = std::to_string(weight) + ",";
      if (line.size() + number.size() > 99) {
        out << line << '\n';
        line.clear();
      }
      line += number;
    }
  }
  out << line << '\n';
  if (!out.flush()) throw Error(ErrorKind::io, path + ": cannot be written");
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::cerr << "usage: label_weights MAPS_TXT OUTPUT.inc [EPOCHS]\n";
    return 2;
  }
  const int epochs = argc > 3 ? std::stoi(argv[3]) : 16;
  std::array<std::vector<LabelSamples::Sample>, kLabelNets> samples;
  for (const LabelMap& map : read_maps(argv[1])) {
    for (const bool is_turned : {false, true}) {
      LabelSampleCollector collector(kQuestionsPerMap);
      ask(is_turned ? turned(map) : map, collector);
      for (std::size_t net = 0; net < kLabelNets; ++net) {
        const auto& list = collector.of(net).list();
        samples[net].insert(samples[net].end(), list.begin(), list.end());
      }
    }
  }
  std::mt19937 random(1);
  LabelWeightSet set{};
  for (std::size_t net = 0; net < kLabelNets; ++net) {
    std::cout << "network " << net << ": " << samples[net].size() << " questions" << std::endl;
    set[net] = trained(random_weights(random), samples[net], samples[net].size(),
                       {.epochs = epochs, .rate = 0.004f, .move_cost = 0, .step = 1});
  }
  write(argv[2], set);
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
