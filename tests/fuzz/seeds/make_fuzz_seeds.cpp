// Writes inputs for the fuzz targets to start from: small valid files, and bricks of every kind
// with their models in the form that brick_input.h takes apart; metadata of every sort.
//
// usage: make_fuzz_seeds FOLDER        fills FOLDER/files, FOLDER/bricks and FOLDER/metadata

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <random>

#include "fuzz/brick_input.h"
#include "octavo/builder/builder.h"
#include "octavo/codec/brick_codec.h"
#include "octavo/planes/memory_source.h"

namespace {

using namespace octavo;

using fuzz::kTypes;
using fuzz::side_of;

enum class Content {
  shape,      ///< a soft shape with some noise; half of it uniform; 32-bit types: a wide range
  multiples,  ///< the same, all values a step apart
  speckles    ///< few voxels on a ground of one value
};

std::int32_t value_at(Content content, std::int64_t width, bool is_inside, std::uint32_t random) {
  const auto noise = static_cast<std::int32_t>(random % 9);
  const std::int32_t value = !is_inside ? 3 : 40 + noise;
  if (content == Content::speckles) {
    return random % 50 != 0 ? 3 : width == 4 ? static_cast<std::int32_t>(random / 8) : 9 + noise;
  }
  if (content == Content::multiples) return 3 * value;
  return width == 4 ? value * 40000 + noise % 3 : value;
}

/// Voxels of a content, or two labels.
Bytes make_voxels(const Size3& size, VoxelType type, VolumeKind kind,
                  Content content = Content::shape) {
  std::mt19937 random(static_cast<std::uint32_t>(size.x * 7 + size.y));
  const std::int64_t width = bytes_per_voxel(type);
  Bytes bytes(static_cast<std::size_t>(size.voxel_count() * width));
  std::size_t at = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x, at += static_cast<std::size_t>(width)) {
        const bool is_inside = x + y > size.y / 2;
        const std::int32_t stored = kind == VolumeKind::labels
                                        ? (is_inside ? 5 : 3)
                                        : value_at(content, width, is_inside, random());
        std::memcpy(bytes.data() + at, &stored, static_cast<std::size_t>(width));
      }
    }
  }
  return bytes;
}

void save(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw Error(ErrorKind::io, "cannot be written", path.string());
}

template <class Int>
void put(Bytes& out, Int value) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

/// The mirror image of fuzz::take_brick.
Bytes input_of(const BrickCodec& codec, const TrainingBrick& voxels, std::uint8_t choice,
               std::uint8_t side, std::int64_t lowest) {
  const EncodedBrick brick = codec.encode(voxels.shape, voxels.view);
  const Bytes model = codec.serialized();
  Bytes out = {choice, side, side, side};
  put(out, static_cast<std::uint16_t>(model.size()));
  out.insert(out.end(), model.begin(), model.end());
  put(out, static_cast<std::uint32_t>(brick.range.min - lowest));
  put(out, static_cast<std::uint32_t>(brick.range.max - lowest));
  for (std::size_t i = 0; i < brick.segments.size(); ++i) {
    if (i + 1 < brick.segments.size())
      put(out, static_cast<std::uint16_t>(brick.segments[i].size()));
    out.insert(out.end(), brick.segments[i].begin(), brick.segments[i].end());
  }
  return out;
}

Bytes brick_input(std::uint8_t type, VolumeKind kind, std::uint8_t side,
                  const CodecSettings& settings = {}, Content content = Content::shape) {
  const Size3 size{side_of(side), side_of(side), side_of(side)};
  const Bytes voxels = make_voxels(size, kTypes[type], kind, content);
  const BrickView view{voxels.data(), kTypes[type], size, size.x, size.x * size.y};
  const Levels levels(size, choose_halvings(size, {1, 1, 1}));
  const BrickShape shape = brick_shape(levels, 0, {0, 0, 0});
  const TrainingBrick training{shape, view};
  const auto codec = train_model(kind, kTypes[type], std::span(&training, 1), settings);
  const auto type_choice =
      static_cast<int>(type) + settings.detail_level * static_cast<int>(kTypes.size());
  const auto choice =
      static_cast<std::uint8_t>(type_choice | (kind == VolumeKind::labels ? 0x80 : 0));
  return input_of(*codec, training, choice, side, value_range(kTypes[type]).min);
}

/// Floats of one of the codings that brick_input.h knows: noise, zeros, NaN and infinities.
Bytes exact_brick_input(std::uint8_t coding_number, std::uint8_t side) {
  const SampleCoding& coding = fuzz::kFuzzedCodings[coding_number];
  const Size3 size{side_of(side), side_of(side), side_of(side)};
  std::mt19937 random(side);
  std::normal_distribution<double> noise(0, 20 * coding.scale);
  std::vector<float> voxels;
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    const std::uint32_t sort = random() % 16;
    const double value = sort < 4 ? 0 : coding.offset + noise(random);
    voxels.push_back(sort > 14   ? std::numeric_limits<float>::quiet_NaN()
                     : sort > 13 ? std::numeric_limits<float>::infinity()
                                 : static_cast<float>(value));
  }
  const Levels levels(size, choose_halvings(size, {1, 1, 1}));
  const TrainingBrick training{
      brick_shape(levels, 0, {0, 0, 0}),
      {voxels.data(), VoxelType::float32, size, size.x, size.x * size.y}};
  const auto codec = train_exact_model({&training, 1}, {}, coding);
  return input_of(*codec, training, static_cast<std::uint8_t>(fuzz::kExactChoice + coding_number),
                  side, value_range(coding.type).min);
}

void write_file_seed(const std::filesystem::path& path, VolumeKind kind, VoxelType type,
                     const Size3& size, double max_error = 0) {
  const Bytes voxels = make_voxels(size, type, kind);
  VolumeDescription description;
  description.kind = kind;
  description.type = type;
  description.size = size;
  const auto source = make_memory_source(description, std::as_bytes(std::span(voxels)));
  NoProgress progress;
  BuildOptions options;
  options.kind = kind;
  options.max_error = max_error;
  options.overwrite = true;
  options.threads = 1;
  build_file(*source, local_storage(), path.string(), options, progress);
}

/// All members there are, and one that no program knows.
constexpr const char* kMetadata[] = {
    R"({"source":{"files":["a","b"],"format":"DICOM","size":9},"unit":"HU","lossy_source":true})",
    R"({"spacing_known":false,"spacing_source":"assumed","place_known":true,)"
    R"("later":[1,{"y":1.50}]})",
    R"({"chosen":{"channel":{"count":3,"index":1,"name":"green"},"time":{"count":2,"index":0}}})",
    R"({"dicom":{"KVP":120.0,"Modality":"CT"},"segment":{"number":2},"segments":[{"number":1}]})",
    R"({"identity":{"attributes":{"PatientName":"A"},"dropped":{"private":7},"kept":true}})",
    R"({"prepared":{"dropped_duplicates":2,"gaps":{"left_out_mm":0.5,"made_plane_count":3,)"
    R"("made_planes":[[1,2],[5,5]],"method":"linear","on_gap":"fill","slices":9,"step_mm":1.5}}})",
    R"({"prepared":{"ignored_number_gaps":1,"isotropic":{"left_out_mm":0,"made_plane_count":4,)"
    R"("method":"cubic","slice_mm":5,"slices":3,"step_mm":1},"tilt":{"angle_degrees":18.5,)"
    R"("method":"linear","outside":-1024,"slice_size":[512,600]}}})",
    R"({"labels":{"1":{"name":"left","color":"#ff8000"},"-2":{"name":"\u00b5"},"7":{}}})",
    R"({"made_by":{"operation":"condense","flat":20.0},"source_max_error":2.5e0})",
    R"({"coding":{"preset":"fast","max_error":2,"nan":-1000,"inf":3.5},)"
    R"("repaired":{"missing_planes":[4,7],"fill":-1024}})"};

void save_metadata(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  const auto save_text = [&](const std::string& text) {
    save(folder / std::to_string(number++), Bytes(text.begin(), text.end()));
  };
  for (const char* text : kMetadata) save_text(text);
  // 2^n times a part less a few, between a beginning and an end: see fuzz_metadata.cpp.
  const auto save_repeated = [&](std::array<std::size_t, 2> times, const std::string& begin,
                                 const std::string& part, const std::string& end) {
    const auto& [power, fewer] = times;
    const std::string head = {static_cast<char>(power), static_cast<char>(fewer),
                              static_cast<char>(begin.size())};
    save_text(head + begin + static_cast<char>(part.size()) + part + end);
  };
  for (const auto fewer : std::to_array<std::size_t>({0, 1, 2, 3})) {
    save_repeated({16, fewer}, "{\"x\":[", "1,", "1]}");
    save_repeated({16, fewer}, "{\"x\":\"", "a", "a\"}");
    save_repeated({4, fewer}, "{\"x\":", "[", std::string(16 - fewer, ']') + "}");
  }
  save_repeated({17, 0}, "{\"x\":", "[", "");
  save_repeated({14, 0}, "{\"labels\":{", "\"1\":{\"name\":\"a\"},", "\"2\":{}}}");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_fuzz_seeds FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder / "files");
  std::filesystem::create_directories(folder / "bricks");
  save_metadata(folder / "metadata");
  int number = 0;
  for (const VolumeKind kind : {VolumeKind::grey, VolumeKind::labels}) {
    for (std::uint8_t type = 0; type < kTypes.size(); ++type) {
      for (const std::uint8_t side : std::to_array<std::uint8_t>({0, 2, 4, 5})) {
        save(folder / "bricks" / std::to_string(number++), brick_input(type, kind, side));
      }
      if (kind == VolumeKind::grey) {
        for (const Content content : {Content::multiples, Content::speckles}) {
          for (const Preset preset : {Preset::small, Preset::fast}) {
            save(folder / "bricks" / std::to_string(number++),
                 brick_input(type, kind, 5, {preset, 0}, content));
          }
        }
        // Prediction from means; rounded voxels; quantized details with corrections.
        for (const CodecSettings& settings :
             {CodecSettings{Preset::fast, 0}, {Preset::small, 1}, {Preset::fast, 25}}) {
          save(folder / "bricks" / std::to_string(number++), brick_input(type, kind, 4, settings));
        }
        // Details left out.
        for (const CodecSettings& settings : {CodecSettings{.detail_level = 1},
                                              {.preset = Preset::fast, .detail_level = 2}}) {
          save(folder / "bricks" / std::to_string(number++), brick_input(type, kind, 5, settings));
        }
        // Parts that decode alone: of both predictors, with edges, with corrections.
        constexpr std::uint8_t kCutSide = 6;
        for (const Content content : {Content::shape, Content::speckles}) {
          for (const CodecSettings& settings :
               {CodecSettings{.preset = Preset::small, .access = Access::slices},
                {.preset = Preset::fast, .access = Access::boxes},
                {.preset = Preset::fast, .max_error = 25, .access = Access::boxes}}) {
            save(folder / "bricks" / std::to_string(number++),
                 brick_input(type, kind, kCutSide, settings, content));
          }
        }
      }
      for (const Size3& size :
           {Size3{1, 1, 1}, Size3{9, 5, 3}, Size3{16, 16, 16}, Size3{70, 3, 66}}) {
        const std::string name = std::to_string(number++) + ".8vo";
        write_file_seed(folder / "files" / name, kind, kTypes[type], size);
      }
    }
  }
  for (std::uint8_t coding = 0; coding < fuzz::kFuzzedCodings.size(); ++coding) {
    for (const std::uint8_t side : std::to_array<std::uint8_t>({0, 2, 4, 5})) {
      save(folder / "bricks" / std::to_string(number++), exact_brick_input(coding, side));
    }
  }
  // The voxels are read as floats by their bits: tiny multiples of the smallest one.
  for (const double max_error : {0.0, 1e-41}) {
    const std::string name = std::to_string(number++) + ".8vo";
    write_file_seed(folder / "files" / name, VolumeKind::grey, VoxelType::float32, {70, 3, 66},
                    max_error);
  }
  write_file_seed(folder / "files" / (std::to_string(number) + ".8vo"), VolumeKind::grey,
                  VoxelType::int16, {70, 3, 66}, 2);
}
