#include "octavo/tasks/structure/self_similarity.h"

#include <span>

#include "support/task_files.h"

namespace octavo {
namespace {

class SelfSimilarity : public testing::TaskFiles {
 protected:
  std::string write_grey(const std::string& name, const Size3& size, std::int64_t period) {
    testing::Volume volume;
    volume.description.type = VoxelType::int16;
    volume.description.size = size;
    volume.description.geometry = geometry_;
    std::vector<std::int16_t> voxels;
    testing::for_each_voxel(size, [&](const Index3& p) {
      const auto i = static_cast<std::uint64_t>(
          (p.z % period * period + p.y % period) * period + p.x % period);
      voxels.push_back(static_cast<std::int16_t>((i * 2654435761u >> 7 & 1023) - 300));
    });
    const auto bytes = std::as_bytes(std::span(voxels));
    volume.voxels.assign(bytes.begin(), bytes.end());
    testing::build_volume(volume, folder_.file(name), 1);
    return folder_.file(name);
  }
};

TEST_F(SelfSimilarity, ARepeatedPatternIsMostlyReferences) {
  const SelfSimilarityResult result =
      self_similarity({write_grey("tiles.8vo", {64, 64, 32}, 16), 0, false, ""}, context_);
  ASSERT_EQ(result.levels.size(), 3u);
  EXPECT_EQ(result.levels[0].side, 16);
  EXPECT_EQ(result.levels[0].cubes, 32u);
  EXPECT_EQ(result.levels[0].same_level, 31u);
  EXPECT_GT(result.levels[0].saved_bytes(), 0.9 * static_cast<double>(result.file_bytes));
  EXPECT_LT(result.saved_bytes(), static_cast<double>(result.file_bytes));
}

TEST_F(SelfSimilarity, NoiseSavesNothing) {
  const SelfSimilarityResult result =
      self_similarity({write_grey("noise.8vo", {48, 40, 32}, 64), 0, false, ""}, context_);
  EXPECT_EQ(result.saved_bytes(), 0);
}

TEST_F(SelfSimilarity, NeedsTwoGreyFilesOfOneScan) {
  const std::string grey = write_grey("grey.8vo", {32, 32, 32}, 8);
  const std::string other = write_grey("other.8vo", {32, 32, 31}, 8);
  const std::string labels = write("labels.8vo", computed({32, 32, 32}, [](const Index3& p) {
    return p.x;
  }));
  const auto kind_of = [&](const SelfSimilarityOptions& options) {
    return failure_of([&] { self_similarity(options, context_); }).kind;
  };
  EXPECT_EQ(kind_of({labels, 0, false, ""}), ErrorKind::invalid_argument);
  EXPECT_EQ(kind_of({grey, 0, false, other}), ErrorKind::invalid_argument);
  EXPECT_EQ(kind_of({grey, -1, false, ""}), ErrorKind::invalid_argument);
  EXPECT_EQ(failure_of([&] { self_similarity({grey, -1, false, ""}, context_); }).field,
            "self_similarity.max_difference");
  context_.max_memory_bytes = 1000;
  EXPECT_EQ(kind_of({grey, 0, false, ""}), ErrorKind::limit_exceeded);
}

}  // namespace
}  // namespace octavo
