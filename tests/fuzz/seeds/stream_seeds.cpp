// The small streams of bricks, and a journal.

#include <array>
#include <limits>
#include <random>

#include "fuzz/brick_input.h"
#include "fuzz/seeds/seed_folder.h"
#include "octavo/codec/exact/absent_samples.h"
#include "octavo/codec/exact/float_places.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_corrections.h"
#include "octavo/codec/label/label_stored.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/write/journal.h"
#include "support/memory_storage.h"

namespace octavo::fuzz {

namespace {

constexpr Size3 kSize{8, 7, 6};
constexpr std::uint8_t kSizeBytes[] = {7, 6, 5};  // as the targets take sizes: less 1

void save_stream(SeedFolder& seeds, const std::string& target, std::uint8_t stream, ByteSpan head,
                 ByteSpan bytes) {
  Bytes input = {stream};
  put_bytes(input, kSizeBytes);
  put_bytes(input, head);
  put_bytes(input, bytes);
  seeds.save(target, input);
}

void save_grey_streams(SeedFolder& seeds) {
  const auto count = static_cast<std::size_t>(kSize.voxel_count());
  for (const std::uint32_t rarity : {1u, 2u, 9u, 1000u}) {
    std::mt19937 random(rarity);
    grey::UniformCells cells{kSize, std::vector<std::uint8_t>(count)};
    grey::Corrections corrections(count);
    for (std::size_t i = 0; i < count; ++i) {
      cells.flags[i] = random() % rarity == 0;
      const auto value = static_cast<std::int8_t>(static_cast<int>(random() % 63) - 31);
      corrections[i] = random() % rarity == 0 ? value : std::int8_t{0};
    }
    save_stream(seeds, "grey_streams", 1, {}, grey::encode_cells(cells));
    save_stream(seeds, "grey_streams", 2, {}, grey::encode_corrections(corrections, kSize));
  }
}

/// Flags and bits of samples that are absent, below absent ones and without any above.
void save_absent(SeedFolder& seeds) {
  constexpr std::uint8_t kHasBits = 16;
  std::mt19937 random(5);
  exact::AbsentFlags flags(static_cast<std::size_t>(kSize.voxel_count()));
  std::vector<std::uint32_t> bits(flags.size());
  for (std::size_t i = 0; i < flags.size(); ++i) {
    flags[i] = random() % 3 == 0;
    bits[i] = random() % 4 == 0 ? static_cast<std::uint32_t>(random()) : exact::kUsualNan;
  }
  const std::uint8_t whole[] = {kHalveAll};
  save_stream(seeds, "exact_streams", 0, whole,
              exact::encode_absent(flags, kSize, {}, kHalveAll, {}));
  const std::uint8_t with_bits[] = {kHalveAll | kHasBits};
  save_stream(seeds, "exact_streams", 0, with_bits,
              exact::encode_absent(flags, kSize, {}, kHalveAll, bits));
}

/// Floats around zero and at one place, all of them different or few.
void save_places(SeedFolder& seeds, std::uint8_t coding_number, bool are_few) {
  const exact::FloatBins bins(kFuzzedCodings[coding_number]);
  std::mt19937 random(coding_number);
  std::vector<float> voxels;
  std::vector<std::int32_t> codes;
  Bytes code_bytes;
  for (std::int64_t i = 0; i < kSize.voxel_count(); ++i) {
    const auto byte = static_cast<std::uint8_t>(90 + random() % 12);
    const auto code = static_cast<std::int32_t>(byte) - 96;
    const exact::FloatBin bin = bins.bin_of(code, 0);
    const auto width = static_cast<std::uint64_t>(bin.end - bin.first);
    const std::uint64_t place = random() % (are_few ? 2u : 1u << 20);
    voxels.push_back(exact::float_of(
        static_cast<std::int32_t>(bin.first + static_cast<std::int64_t>(place % width))));
    codes.push_back(code);
    code_bytes.push_back(byte);
  }
  const Bytes places = exact::encode_places(bins, {kSize, codes, {}}, voxels);
  Bytes head = {coding_number};
  put(head, static_cast<std::uint16_t>(places.size()));
  put_bytes(head, places);
  save_stream(seeds, "exact_streams", 1, head, code_bytes);
}

void save_stored_labels(SeedFolder& seeds) {
  // A list of three labels, and distances from the smallest one; 10 voxels
  const Bytes listed = {1, 1, 2, 0, 0, 0, 200, 0, 0, 0, 9, 0, 3, 0, 4, 90, 0x24, 0x49, 0x02};
  const Bytes plain = {1, 1, 2, 0, 0, 0, 5, 0, 0, 0, 9, 0, 0, 0x98, 0x04, 0x20, 0x08};
  seeds.save("label_streams", listed);
  seeds.save("label_streams", plain);
}

void save_journal(SeedFolder& seeds) {
  testing::MemoryStorage storage;
  JournalHead head;
  head.settings = "preset: small\n";
  head.metadata = R"({"unit":"HU"})";
  Journal journal(storage.create_exclusive("a"), head);
  for (std::int64_t layer = 1; layer <= 2; ++layer) {
    journal.append_block(1, Bytes{1, 2, 3});
    JournalGroup group;
    group.end_layer = layer;
    group.file_bytes = 1000;
    group.models.push_back({512, 100, 7, 0});
    group.slab_trailer_bytes.push_back(50);
    group.pages.push_back({600, 20, 9, {-5, 300}, 2, 1, {10, 20, 30, 0}});
    group.parents = {3, -4};
    group.plane_digests.resize(2);
    journal.append_group(group);
  }
  // Frames of 20 bytes become those that fuzz_journal takes.
  const Bytes& bytes = *storage.files.at("a");
  Bytes input;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto length = load_little_endian<std::uint64_t>(bytes.data() + at + 8);
    input.push_back(bytes[at]);
    input.push_back(bytes[at + 4]);
    put(input, static_cast<std::uint16_t>(length));
    put_bytes(input, ByteSpan(bytes).subspan(at + 20, length));
    at += 20 + length;
  }
  seeds.save("journal", input);
}

/// For fuzz_round_trip: every type, both presets, labels and a maximum error.
void save_volumes(SeedFolder& seeds) {
  for (int type = 0; type < 7; ++type) {
    for (const int choice : {0x00, 0x10, 0x20, 0x40, 0x80, 0xc0}) {
      Bytes input = {static_cast<std::uint8_t>(type | choice), 7, 4, 2};
      put(input, std::uint16_t{3});
      for (std::uint8_t i = 0; i < 48; ++i) input.push_back(static_cast<std::uint8_t>(i * i));
      seeds.save("round_trip", input);
    }
  }
}

}  // namespace

void save_streams(SeedFolder& seeds) {
  save_grey_streams(seeds);
  save_absent(seeds);
  for (std::uint8_t coding = 0; coding < kFuzzedCodings.size(); ++coding) {
    for (const bool are_few : {false, true}) save_places(seeds, coding, are_few);
  }
  save_stored_labels(seeds);
  save_journal(seeds);
  save_volumes(seeds);
}

}  // namespace octavo::fuzz
