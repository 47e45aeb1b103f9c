#include "octavo/tasks/components/components_in_parts.h"

#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <random>
#include <string>

#include "octavo/builder/build_memory.h"
#include "octavo/tasks/components/component_lines.h"
#include "octavo/tasks/components/component_planes.h"
#include "octavo/tasks/files/part_result.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseMask;

class ComponentsInParts : public testing::TaskFiles {
 protected:
  /// Single voxels, so that components of many shapes cross the borders of parts.
  DenseMask noise(const Size3& size, unsigned percent) {
    DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
    for (auto& voxel : mask.voxels) voxel = static_cast<std::uint8_t>(random_() % 100 < percent);
    return mask;
  }

  std::vector<std::string> found_by(std::int64_t count) {
    std::vector<std::string> paths;
    for (std::int64_t number = 0; number < count; ++number) {
      paths.push_back(folder_.file("found-" + std::to_string(number)));
      components_of_part(
          {options_.input, options_.connectivity, {number, count}, {paths.back(), true}},
          context_);
    }
    return paths;
  }

  ComponentsResult joined(std::int64_t count) {
    JoinComponentsOptions join{options_, found_by(count)};
    join.components.output = {folder_.file("numbers"), true};
    return join_components(join, context_);
  }

  std::string bytes_of(const std::string& path) const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  /// Table and label map of so many parts are those of one run.
  void expect_same(std::initializer_list<std::int64_t> counts) {
    options_.output = {folder_.file("whole.8vo"), true};
    const ComponentsResult whole = components(options_, context_);
    options_.output.reset();
    for (const std::int64_t count : counts) {
      SCOPED_TRACE(::testing::Message()
                   << count << " parts, " << static_cast<int>(options_.connectivity));
      expect_same_table(joined(count), whole);
      const LabeledComponents labeled = label_components(
          {options_.input, folder_.file("numbers"), {folder_.file("labels.8vo"), true}},
          context_);
      EXPECT_EQ(labeled.found, whole.found);
      EXPECT_EQ(labeled.kept, whole.kept);
      EXPECT_EQ(labeled.file_bytes, whole.file_bytes);
      EXPECT_EQ(bytes_of(folder_.file("labels.8vo")), bytes_of(folder_.file("whole.8vo")));
    }
  }

  static void expect_same_table(const ComponentsResult& parts, const ComponentsResult& whole) {
    EXPECT_EQ(parts.found, whole.found);
    EXPECT_EQ(parts.kept, whole.kept);
    ASSERT_EQ(parts.rows.size(), whole.rows.size());
    for (std::size_t i = 0; i < whole.rows.size(); ++i) {
      EXPECT_EQ(parts.rows[i].voxels, whole.rows[i].voxels);
      EXPECT_EQ(parts.rows[i].centroid, whole.rows[i].centroid);
      EXPECT_EQ(parts.rows[i].centroid_mm, whole.rows[i].centroid_mm);
      EXPECT_EQ(parts.rows[i].box, whole.rows[i].box);
    }
  }

  std::mt19937 random_{23};
  ComponentsOptions options_;
};

TEST_F(ComponentsInParts, GiveTheTableAndTheLabelMapOfOneRun) {
  options_.input = write("noise.8vo", noise({41, 23, 300}, 31));
  expect_same({1, 2, 3, 4, 5, 6, 7});
  options_.input = write("thin.8vo", noise({41, 23, 300}, 10));
  options_.connectivity = Connectivity::edges;
  expect_same({2, 5});
  options_.connectivity = Connectivity::corners;
  expect_same({3});
}

TEST_F(ComponentsInParts, KeepWhatOneRunKeeps) {
  options_.input = write("noise.8vo", noise({30, 30, 200}, 12));
  options_.keep_largest = 40;
  expect_same({3});
  options_.keep_largest = 0;
  options_.min_mm3 = 1;
  expect_same({3});
  options_.min_mm3 = 1e9;
  expect_same({2});
}

/// Full cubes, empty planes, more parts than layers of bricks.
TEST_F(ComponentsInParts, AreThoseOfBoxesAndOfNothing) {
  for (int turn = 0; turn < 3; ++turn) {
    options_.input = write("boxes" + std::to_string(turn) + ".8vo",
                           testing::random_mask({90, 70, 200}, random_));
    expect_same({2, 7});
  }
  options_.input = write("empty.8vo", noise({20, 20, 130}, 0));
  expect_same({2});
}

TEST_F(ComponentsInParts, OfAnotherMaskOrConnectivityAreRejected) {
  options_.input = write("noise.8vo", noise({20, 20, 130}, 20));
  const std::vector<std::string> found = found_by(2);
  const auto expect_rejected = [&](const ComponentsOptions& asked, const std::string& word) {
    const Failure failure = failure_of([&] { join_components({asked, found}, context_); });
    EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
    EXPECT_NE(failure.detail.find(word), std::string::npos) << failure.detail;
  };
  ComponentsOptions other = options_;
  other.connectivity = Connectivity::corners;
  expect_rejected(other, "of another mask or connectivity");
  other = options_;
  other.input = write("other.8vo", noise({20, 20, 130}, 21));
  expect_rejected(other, "of another mask or connectivity");
  joined(2);
  const Failure failure = failure_of([&] {
    label_components({other.input, folder_.file("numbers"), {folder_.file("l.8vo")}}, context_);
  });
  EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
  EXPECT_NE(failure.detail.find("another mask"), std::string::npos) << failure.detail;
}

TEST_F(ComponentsInParts, AFileOfOtherNumbersIsNamed) {
  options_.input = write("noise.8vo", noise({20, 20, 130}, 20));
  joined(2);
  const std::string path = folder_.file("numbers");
  constexpr const char* kKind = "numbers of components";
  const FoundPart whole = read_part_result(path, kKind, context_);
  for (const char* const name : {"connectivity", "keep_largest", "min_mm3", "counts"}) {
    std::vector<JsonObject> lines = whole.lines;
    lines.front().set(name, std::vector<std::int64_t>{});
    write_part_result({path, true}, kKind, whole.part, lines);
    try {
      label_components({options_.input, path, {folder_.file("labels.8vo"), true}}, context_);
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
      EXPECT_EQ(error.path(), path) << error.what();
    }
  }
}

TEST_F(ComponentsInParts, ThatAreMissingOrThereTwiceAreRejected) {
  options_.input = write("noise.8vo", noise({20, 20, 130}, 20));
  const std::vector<std::string> found = found_by(2);
  for (const auto& paths : {std::vector{found[0]}, std::vector{found[1], found[1]}}) {
    EXPECT_EQ(failure_of([&] { join_components({options_, paths}, context_); }).kind,
              ErrorKind::invalid_argument);
  }
}

TEST_F(ComponentsInParts, FilesThatWereChangedAreRejected) {
  options_.input = write("noise.8vo", noise({20, 20, 130}, 20));
  joined(2);
  const std::string part = folder_.file("found-0");
  const std::string numbers = folder_.file("numbers");
  const auto expect_corrupt = [&](const std::string& path, auto task) {
    const std::string whole = bytes_of(path);
    for (std::size_t at = 0; at < whole.size(); at += whole.size() / 7) {
      std::string text = whole;
      text[at] = static_cast<char>(text[at] ^ 1);
      for (const std::string& changed : {text, whole.substr(0, at)}) {
        std::ofstream(path, std::ios::binary) << changed;
        EXPECT_EQ(failure_of(task).kind, ErrorKind::corrupt) << at;
      }
    }
  };
  expect_corrupt(numbers, [&] {
    label_components({options_.input, numbers, {folder_.file("l.8vo"), true}}, context_);
  });
  expect_corrupt(part, [&] {
    join_components({options_, {part, folder_.file("found-1")}}, context_);
  });
}

TEST_F(ComponentsInParts, StayWithinTheMemoryLimit) {
  options_.input = write("noise.8vo", noise({60, 60, 260}, 30));
  const std::vector<std::string> found = found_by(2);
  joined(2);
  context_.max_memory_bytes = std::uint64_t{1} << 20;
  EXPECT_EQ(failure_of([&] { join_components({options_, found}, context_); }).kind,
            ErrorKind::limit_exceeded);
  EXPECT_EQ(failure_of([&] {
              components_of_part({options_.input, {}, {0, 1}, {folder_.file("x")}}, context_);
            }).kind,
            ErrorKind::limit_exceeded);
}

/// A build reckons with what the planes say before their first one is read.
TEST_F(ComponentsInParts, TheirPlanesTakeNoMoreMemoryThanTheySay) {
  options_.input = write("noise.8vo", noise({600, 60, 130}, 1));
  joined(2);
  LabelComponentsOptions options = {options_.input, folder_.file("numbers"), {}};
  const VolumeDescription volume = labeled_planes(options, context_).planes->description();
  const int threads = context_.thread_count();
  const std::uint64_t build = build_memory_bytes(volume, threads);
  const std::uint64_t bands = band_memory_bytes(volume, threads, std::uint64_t{16} << 20);
  for (const std::uint64_t limit : {build + build / 4, 2 * build, 5 * build}) {
    context_.max_memory_bytes = limit;
    const ComputedVolume labeled = labeled_planes(options, context_);
    PlaneSource& planes = *labeled.planes;
    const std::uint64_t said = planes.resident_bytes();
    EXPECT_LE(std::min(build, bands) + said, limit);
    std::vector<std::byte> plane(plane_bytes(volume));
    for (std::int64_t z = 0; z < volume.size.z; ++z) planes.read_plane(plane);
    EXPECT_EQ(planes.resident_bytes(), said);
  }
  context_.max_memory_bytes = 2 * build;
  options.output = {folder_.file("labels.8vo")};
  EXPECT_GT(label_components(options, context_).kept, 255u);
}

/// A build in bands reads planes of two parts in turn.
TEST_F(ComponentsInParts, PlanesThatAreReadAgainFindNoComponentsAgainWhereBothPartsFit) {
  options_.input = write("noise.8vo", noise({41, 23, 300}, 31));
  joined(2);
  const LabelComponentsOptions options = {options_.input, folder_.file("numbers"), {}};
  const auto opened_parts = [&](std::uint64_t limit, std::vector<std::byte>& last) {
    context_.max_memory_bytes = limit;
    const ComputedVolume labeled = labeled_planes(options, context_);
    auto& planes = static_cast<ComponentPlanes&>(*labeled.planes);
    std::vector<std::byte> plane(plane_bytes(planes.description()));
    last.clear();
    for (int pass = 0; pass < 3; ++pass) {
      planes.seek(100, 200);
      for (int i = 0; i < 100; ++i) {
        planes.read_plane(plane);
        if (pass == 2) last.insert(last.end(), plane.begin(), plane.end());
      }
    }
    EXPECT_LE(planes.resident_bytes(), limit == 0 ? ~std::uint64_t{0} : limit);
    return planes.opened_parts();
  };
  std::vector<std::byte> with_room;
  std::vector<std::byte> without_limit;
  EXPECT_EQ(opened_parts(std::uint64_t{2} << 30, with_room), 2);
  EXPECT_EQ(opened_parts(0, without_limit), 6);
  EXPECT_TRUE(with_room == without_limit);
}

TEST_F(ComponentsInParts, NumbersOfMoreComponentsThanLabelsAreRejected) {
  options_.input = write("noise.8vo", noise({20, 20, 130}, 20));
  joined(1);
  FoundPart file = read_part_result(folder_.file("numbers"), "numbers of components", context_);
  const std::int64_t many = std::int64_t{1} << 32;
  file.lines.front().set("counts", std::vector<std::int64_t>{many, many, 1});
  write_part_result({folder_.file("numbers"), true}, "numbers of components", {}, file.lines);
  const Failure failure = failure_of([&] {
    label_components({options_.input, folder_.file("numbers"), {folder_.file("l.8vo")}}, context_);
  });
  EXPECT_EQ(failure.kind, ErrorKind::corrupt);
  EXPECT_NE(failure.detail.find("counts"), std::string::npos) << failure.detail;
}

TEST_F(ComponentsInParts, AJoinWritesNumbersAndNoVolume) {
  options_.input = write("noise.8vo", noise({20, 20, 130}, 20));
  JoinComponentsOptions join{options_, found_by(1)};
  join.components.output = {folder_.file("numbers.8vo")};
  const Failure failure = failure_of([&] { join_components(join, context_); });
  EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
  EXPECT_NE(failure.detail.find("name of a volume"), std::string::npos) << failure.detail;
}

// --- Lines with a right checksum and wrong numbers

constexpr Size3 kLineSize = {9, 5, 130};

PartOfComponents two_components() {
  PartOfComponents found;
  found.part = {0, 2};
  found.plane_count = 64;
  found.components = {{7, {{1, 2, 3}, {4, 3, 64}}, {}}, {1, {{8, 4, 0}, {9, 5, 1}}, {}}};
  found.sums.resize(2);
  found.sums[0].first_code = 900;
  found.sums[0].doubled = {static_cast<__int128>(5) << 40, 28, 600};
  found.sums[1].first_code = 12;
  found.sums[1].doubled = {16, 8, 0};
  found.first_plane = {{4, 8, 9, 2}};
  found.last_plane = {{2, 1, 2, 1}, {2, 3, 4, 1}};
  return found;
}

bool are_taken(const std::vector<JsonObject>& lines) {
  try {
    components_of_lines(lines, {0, 2}, kLineSize);
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
    return false;
  }
}

TEST(ComponentLines, ComponentsAreThoseThatWereWritten) {
  const PartOfComponents found = two_components();
  const PartOfComponents again =
      components_of_lines(lines_of_components(found), {0, 2}, kLineSize);
  EXPECT_EQ(again.plane_count, found.plane_count);
  ASSERT_EQ(again.components.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.components[i].voxel_count, found.components[i].voxel_count);
    EXPECT_EQ(again.components[i].box, found.components[i].box);
    EXPECT_EQ(again.sums[i].first_code, found.sums[i].first_code);
    EXPECT_EQ(again.sums[i].doubled, found.sums[i].doubled);
  }
  EXPECT_EQ(again.first_plane, found.first_plane);
  EXPECT_EQ(again.last_plane, found.last_plane);
}

TEST(ComponentLines, AListOfSomethingElseIsRejected) {
  std::vector<JsonObject> lines = lines_of_components(two_components());
  ASSERT_EQ(lines.back().json_of("of"), "\"last plane\"");
  lines.back().set("of", "middle plane");
  EXPECT_FALSE(are_taken(lines));
}

TEST(ComponentLines, NumbersThatNoMaskHasAreRejected) {
  constexpr std::int64_t kHighest = std::numeric_limits<std::int64_t>::max();
  const std::vector<JsonObject> good = lines_of_components(two_components());
  ASSERT_EQ(good.size(), 4u);
  ASSERT_TRUE(are_taken(good));
  const auto expect_rejected = [&](std::size_t line, const char* name, std::size_t size,
                                   std::size_t at, std::initializer_list<std::int64_t> values) {
    for (const std::int64_t value : values) {
      std::vector<JsonObject> lines = good;
      std::vector<std::int64_t> numbers = integers_in(good[line], name, size);
      numbers[at] = value;
      lines[line].set(name, numbers);
      EXPECT_FALSE(are_taken(lines)) << line << " " << name << " " << at << " " << value;
    }
  };
  expect_rejected(0, "planes", 1, 0, {0, 65, -1});
  expect_rejected(0, "counts", 3, 0, {1, 3, -1, kHighest});
  expect_rejected(0, "counts", 3, 2, {1, 3, -1});
  expect_rejected(1, "numbers", 1, 0, {14, 27, -1, kHighest});
  expect_rejected(1, "all", 28, 0, {0, -7, 184, kHighest});
  expect_rejected(1, "all", 28, 1, {-1, 4, kHighest});
  expect_rejected(1, "all", 28, 6, {65, 3, kHighest});
  expect_rejected(1, "all", 28, 7, {-1});
  expect_rejected(1, "all", 28, 8, {-1, std::int64_t{1} << 40});
  expect_rejected(1, "all", 28, 9, {-1, std::int64_t{1} << 32});
  expect_rejected(2, "all", 4, 0, {-1, 5, kHighest});
  expect_rejected(2, "all", 4, 1, {-1, 9});
  expect_rejected(2, "all", 4, 2, {8, 10, kHighest});
  expect_rejected(2, "all", 4, 3, {0, 3, -1, kHighest});
  expect_rejected(3, "all", 8, 4, {1});
  expect_rejected(3, "all", 8, 5, {1});
}

TEST(ComponentLines, LabelsAreThoseThatWereWritten) {
  LabelsOfParts labels = {{3, 0, 1}, {}, std::vector<std::uint32_t>(70000, 2)};
  const std::vector<JsonObject> lines = lines_of_labels(labels);
  EXPECT_EQ(labels_of_lines(lines, 3, 3), labels);
  for (const auto& [parts, most] : {std::pair(2, 3u), std::pair(4, 3u), std::pair(3, 2u)}) {
    EXPECT_THROW(labels_of_lines(lines, parts, most), Error);
  }
  EXPECT_THROW(labels_of_lines(std::span(lines).subspan(1), 3, 3), Error);
  EXPECT_THROW(labels_of_lines(std::span(lines).first(lines.size() - 1), 3, 3), Error);
}

}  // namespace
}  // namespace octavo
