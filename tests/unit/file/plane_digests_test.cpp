#include "octavo/file/plane_digests.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>

#include "octavo/core/sha256.h"

namespace octavo {
namespace {

void one_by_one(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  for (std::int64_t i = 0; i < count; ++i) task(i);
}

std::unique_ptr<Hasher> make_sha256() { return std::make_unique<Sha256>(); }

// Counts the bytes that it gets.
class CountingHasher final : public Hasher {
 public:
  explicit CountingHasher(std::size_t& bytes) : bytes_(bytes) {}
  void add(ByteSpan bytes) override {
    bytes_ += bytes.size();
    hasher_.add(bytes);
  }
  Sha256Digest digest() override { return hasher_.digest(); }

 private:
  std::size_t& bytes_;
  Sha256 hasher_;
};

// Codes of a volume, [z][y][x]; those of the first brick are all alike.
struct CodedVolume {
  VolumeDescription description;
  Levels levels;
  std::vector<std::int64_t> codes;

  CodedVolume(const Size3& size, VoxelType type, std::optional<SampleCoding> coding) {
    description.size = size;
    description.type = type;
    description.coding = coding;
    levels = Levels(size, choose_halvings(size, {1, 1, 1}));
    const ValueRange range = value_range(description.coded_type());
    std::mt19937_64 random(5);
    std::uniform_int_distribution<std::int64_t> any(range.min, range.max);
    const Box first = levels.brick_box(0, {0, 0, 0});
    for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
      const Index3 at{i % size.x, i / size.x % size.y, i / (size.x * size.y)};
      codes.push_back(first.contains(at) ? range.max : any(random));
    }
  }

  std::int64_t code_at(const Index3& p) const {
    const Size3& size = description.size;
    return codes[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
  }

  // The numbers of a box, dense, in the type that `as` names.
  Bytes dense(const Box& box, VoxelType as) const {
    Bytes bytes;
    with_voxel_type(as, [&](auto tag) {
      using T = typename decltype(tag)::type;
      for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
        for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
          for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
            const std::int64_t code = code_at({x, y, z});
            const auto number = std::is_floating_point_v<T>
                                    ? static_cast<T>(description.voxel_of(code))
                                    : static_cast<T>(code);
            const auto* const first = reinterpret_cast<const std::uint8_t*>(&number);
            bytes.insert(bytes.end(), first, first + sizeof number);
          }
        }
      }
    });
    return bytes;
  }

  std::vector<Sha256Digest> expected() const {
    std::vector<Sha256Digest> digests;
    const Size3& size = description.size;
    for (std::int64_t z = 0; z < size.z; ++z) {
      Sha256 hasher;
      hasher.add(dense({{0, 0, z}, {size.x, size.y, z + 1}}, description.type));
      digests.push_back(hasher.digest());
    }
    return digests;
  }

  // shares  how often bricks were asked for
  std::vector<Sha256Digest> found(std::int64_t rows_bytes, int& shares,
                                  const MakeHasher& make_hasher = make_sha256) const {
    PlaneDigests planes(description, levels, make_hasher, rows_bytes);
    std::vector<Sha256Digest> digests;
    for (std::int64_t layer = 0; layer < levels.brick_grid(0).z; ++layer) {
      planes.begin_layer(layer);
      for (Box rows = planes.next_bricks(); !rows.is_empty(); rows = planes.next_bricks()) {
        ++shares;
        for (Index3 brick = rows.lo; brick.y < rows.hi.y; ++brick.y) {
          for (brick.x = rows.lo.x; brick.x < rows.hi.x; ++brick.x) put(brick, planes);
        }
        planes.add_rows(one_by_one);
      }
      for (const Sha256Digest& digest : planes.digests()) digests.push_back(digest);
    }
    return digests;
  }

  void put(const Index3& brick, PlaneDigests& planes) const {
    const Box box = levels.brick_box(0, brick);
    if (is_uniform(box)) planes.put_uniform(brick, code_at(box.lo));
    else planes.put(brick, dense(box, description.codec_type()).data());
  }

  bool is_uniform(const Box& box) const {
    for (Index3 at = box.lo; at.z < box.hi.z; ++at.z) {
      for (at.y = box.lo.y; at.y < box.hi.y; ++at.y) {
        for (at.x = box.lo.x; at.x < box.hi.x; ++at.x) {
          if (code_at(at) != code_at(box.lo)) return false;
        }
      }
    }
    return true;
  }
};

TEST(PlaneDigests, AreThoseOfThePlanesHoweverSmallTheBuffer) {
  const SampleCoding lossy{VoxelType::int16, 0.5, -3, false};
  const SampleCoding exact{VoxelType::int32, 0.25, 1, true};
  const struct {
    VoxelType type;
    std::optional<SampleCoding> coding;
  } types[] = {{VoxelType::int8, {}},  {VoxelType::uint8, {}},  {VoxelType::int16, {}},
               {VoxelType::uint16, {}}, {VoxelType::int32, {}}, {VoxelType::uint32, {}},
               {VoxelType::float32, lossy}, {VoxelType::float32, exact}};
  for (const Size3& size : {Size3{67, 131, 2}, Size3{7, 70, 65}, Size3{1, 1, 3}}) {
    for (const auto& [type, coding] : types) {
      const CodedVolume volume(size, type, coding);
      const auto expected = volume.expected();
      const std::int64_t row = size.x * bytes_per_voxel(type);
      int most_shares = 0;
      // Less than a row; some rows, which straddle bricks or not; rows of bricks; all
      for (const std::int64_t rows : {std::int64_t{0}, std::int64_t{1}, std::int64_t{3},
                                      std::int64_t{64}, std::int64_t{70}, std::int64_t{64 * 2},
                                      std::int64_t{128 * 2}, std::int64_t{1} << 20}) {
        int shares = 0;
        EXPECT_EQ(volume.found(rows * row + 1, shares), expected)
            << voxel_type_name(type) << " " << size.y << ", rows " << rows;
        most_shares = std::max(most_shares, shares);
      }
      EXPECT_GE(most_shares, size.y * size.z);
    }
  }
}

// How many bytes are hashed of a volume whose bricks have one value each, but for `other`.
std::size_t hashed_bytes(const Size3& size, const Index3& other) {
  CodedVolume volume(size, VoxelType::int16, {});
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    const Index3 brick{i % size.x / 64, i / size.x % size.y / 64, i / (size.x * size.y) / 64};
    const std::int64_t code = brick == other ? i % 1000 : 7 * brick.y + brick.x;
    volume.codes[static_cast<std::size_t>(i)] = code;
  }
  std::size_t bytes = 0;
  int shares = 0;
  const auto make = [&] { return std::make_unique<CountingHasher>(bytes); };
  EXPECT_EQ(volume.found(2 * size.x * 64 * 64, shares, make), volume.expected());
  EXPECT_EQ(shares, 2 * 4);
  return bytes;
}

TEST(PlaneDigests, OnePlaneIsHashedOfALayerOfUniformBricks) {
  const Size3 size{130, 200, 70};
  const std::size_t plane = 2 * 130 * 200;
  EXPECT_EQ(hashed_bytes(size, {-1, -1, -1}), 2 * plane);
  EXPECT_EQ(hashed_bytes(size, {1, 2, 0}), (64 + 1) * plane);
  EXPECT_EQ(hashed_bytes(size, {0, 0, 1}), (1 + 6) * plane);
}

}  // namespace
}  // namespace octavo
