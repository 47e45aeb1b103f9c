#include <gtest/gtest.h>

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <new>

#include "octavo/file/layout.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using namespace octavo::testing;

class WriterOnDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "octavo-writer-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::size_t file_count() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  void write_text(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
  }

  std::string text_of(const std::string& name) const {
    std::ifstream in(path(name));
    return {std::istreambuf_iterator<char>(in), {}};
  }

  SampleVolume volume_ = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  fs::path folder_;
};

ErrorKind kind_of_failure(const std::function<void()>& work, std::string* message = nullptr) {
  try {
    work();
  } catch (const Error& error) {
    if (message) *message = error.what();
    return error.kind();
  }
  ADD_FAILURE() << "nothing was thrown";
  return ErrorKind::internal;
}

TEST_F(WriterOnDisk, LeavesExactlyTheFile) {
  write_sample(local_storage(), path("a.8vo"), volume_);
  EXPECT_EQ(file_count(), 1u);
  const auto reader = FileReader::open(open_byte_source(local_storage(), path("a.8vo")));
  const Box all = box_of(volume_.levels.size(0));
  EXPECT_EQ(read_samples(*reader, all, 0), volume_.samples[0]);
}

TEST_F(WriterOnDisk, SameInputGivesTheSameBytes) {
  write_sample(local_storage(), path("a.8vo"), volume_);
  write_sample(local_storage(), path("b.8vo"), volume_);
  EXPECT_EQ(text_of("a.8vo"), text_of("b.8vo"));
}

TEST_F(WriterOnDisk, RejectsAnExistingFileUnlessAskedTo) {
  write_text("a.8vo", "old");
  EXPECT_EQ(kind_of_failure([&] { write_sample(local_storage(), path("a.8vo"), volume_); }),
            ErrorKind::io);
  EXPECT_EQ(text_of("a.8vo"), "old");
  write_sample(local_storage(), path("a.8vo"), volume_, true);
  EXPECT_NE(text_of("a.8vo"), "old");
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(WriterOnDisk, AFileThatAppearsMeanwhileIsKept) {
  auto writer = FileWriter::create(local_storage(), path("a.8vo"), volume_.description,
                                   volume_.levels, 1, {});
  write_text("a.8vo", "new neighbor");
  writer->add_model({'r', 'a', 'w'});
  EncodedBrick brick;
  brick.segments.resize(6);
  writer->add_brick(0, brick);
  writer->add_plane_digests(sample_plane_digests(volume_, 0));
  writer->add_brick(0, brick);
  brick.segments.resize(static_cast<std::size_t>(volume_.levels.tier_level_count(1)));
  writer->add_brick(1, brick);
  EXPECT_EQ(kind_of_failure([&] { writer->finish(); }), ErrorKind::io);
  EXPECT_EQ(text_of("a.8vo"), "new neighbor");
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(WriterOnDisk, AWriterThatIsStoppedWhileSealingLeavesWhatWasThere) {
  write_text("a.8vo", "old");
  // The first question comes before anything is sealed, the last one with all of it on disk.
  int questions = 0;
  const auto finish = [&](int answered) {
    questions = 0;
    WriterOptions options;
    options.overwrite = true;
    options.is_cancelled = [&questions, answered] { return questions++ >= answered; };
    const auto writer = FileWriter::create(local_storage(), path("a.8vo"), volume_.description,
                                           volume_.levels, 1, options);
    encode_sample(*writer, volume_);
    writer->finish();
  };
  const int asked = volume_.levels.count() + 1;
  for (const int answered : {0, 1, asked - 1}) {
    EXPECT_EQ(kind_of_failure([&] { finish(answered); }), ErrorKind::cancelled) << answered;
    EXPECT_EQ(text_of("a.8vo"), "old");
    EXPECT_EQ(file_count(), 1u);
  }
  finish(asked);
  EXPECT_EQ(questions, asked);
  EXPECT_NE(text_of("a.8vo"), "old");
}

TEST_F(WriterOnDisk, ADestroyedWriterLeavesNothing) {
  {
    const auto writer = FileWriter::create(local_storage(), path("a.8vo"), volume_.description,
                                           volume_.levels, 1, {});
    EXPECT_EQ(file_count(), 1u);
    EXPECT_FALSE(fs::exists(path("a.8vo")));
  }
  EXPECT_EQ(file_count(), 0u);
}

TEST_F(WriterOnDisk, RejectsTargetsThatAreNoFiles) {
  fs::create_directory(path("folder"));
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  fs::create_symlink("nowhere", path("dangling"));
  const std::string targets[] = {path("folder"), path("pipe"), path("dangling"),
                                 path("missing/a.8vo"), path("folder/"), "/dev/null",
                                 path(std::string(256, 'x'))};
  for (const std::string& target : targets) {
    EXPECT_EQ(kind_of_failure([&] { write_sample(local_storage(), target, volume_, true); }),
              ErrorKind::io)
        << target;
  }
  EXPECT_EQ(file_count(), 3u);
}

TEST_F(WriterOnDisk, TakesTheLongestName) {
  const std::string name(255, 'n');
  write_sample(local_storage(), path(name), volume_);
  EXPECT_TRUE(fs::exists(path(name)));
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(WriterOnDisk, MessagesEscapeThePath) {
  write_text("two\nlines", "old");
  std::string message;
  kind_of_failure([&] { write_sample(local_storage(), path("two\nlines"), volume_); }, &message);
  EXPECT_NE(message.find("two\\x0alines: exists already"), std::string::npos) << message;
}

TEST_F(WriterOnDisk, TwoWritersOfOneNameDoNotMeet) {
  const WriterOptions options{true};
  const auto one = FileWriter::create(local_storage(), path("a.8vo"), volume_.description,
                                      volume_.levels, 1, options);
  const auto two = FileWriter::create(local_storage(), path("a.8vo"), volume_.description,
                                      volume_.levels, 2, options);
  EXPECT_EQ(file_count(), 2u);
}

TEST_F(WriterOnDisk, AKilledWriterLeavesOldOrNewAndTheNextCleansUp) {
  write_sample(local_storage(), path("a.8vo"), volume_);
  const std::string bytes = text_of("a.8vo");
  for (int i = 0; i < 60; ++i) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (;;) write_sample(local_storage(), path("a.8vo"), volume_, true);
    }
    ::usleep(static_cast<useconds_t>(500 + 137 * i));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ASSERT_EQ(text_of("a.8vo"), bytes);
    ASSERT_LE(file_count(), 2u);
  }
  write_sample(local_storage(), path("a.8vo"), volume_, true);
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(WriterOnDisk, ReadingAPipeOrFolderIsAnErrorAtOnce) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  for (const std::string& name : {path("pipe"), folder_.string(), path("missing")}) {
    EXPECT_EQ(kind_of_failure([&] { local_storage().open_read(name); }), ErrorKind::io);
  }
}

TEST(Writer, RejectsBricksOutOfOrder) {
  MemoryStorage storage;
  const SampleVolume volume = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  EncodedBrick uniform;
  uniform.segments.resize(6);
  const auto start = [&] {
    return FileWriter::create(storage, "a.8vo", volume.description, volume.levels, 1, {});
  };
  EXPECT_EQ(kind_of_failure([&] { start()->add_brick(0, uniform); }), ErrorKind::internal);
  EXPECT_EQ(kind_of_failure([&] {
              const auto writer = start();
              writer->add_model({1});
              writer->add_brick(1, uniform);
            }),
            ErrorKind::internal);
  EXPECT_EQ(kind_of_failure([&] {
              const auto writer = start();
              writer->add_model({1});
              writer->add_brick(0, uniform);
              writer->finish();
            }),
            ErrorKind::internal);
  // The last brick of a layer, without the digests of its planes, and with those of others
  EXPECT_EQ(kind_of_failure([&] {
              const auto writer = start();
              writer->add_model({1});
              writer->add_brick(0, uniform);
              writer->add_brick(0, uniform);
            }),
            ErrorKind::internal);
  EXPECT_EQ(kind_of_failure([&] { start()->add_plane_digests(std::vector<Sha256Digest>(19)); }),
            ErrorKind::internal);
  EXPECT_TRUE(storage.files.empty());
}

TEST(Writer, RejectsWhatNoFileCanHave) {
  const SampleVolume volume = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  const struct {
    const char* what;
    ErrorKind kind;
    std::function<void(VolumeDescription&, WriterOptions&)> change;
  } cases[] = {
      {"size", ErrorKind::internal, [](auto& d, auto&) { ++d.size.x; }},
      {"no size", ErrorKind::limit_exceeded, [](auto& d, auto&) { d.size.x = 0; }},
      {"type", ErrorKind::internal, [](auto& d, auto&) { d.type = VoxelType{8}; }},
      {"floats without a coding", ErrorKind::internal,
       [](auto& d, auto&) { d.type = VoxelType::float32; }},
      {"integers with a coding", ErrorKind::internal,
       [](auto& d, auto&) { d.coding = SampleCoding{}; }},
      {"a coding without a scale", ErrorKind::internal,
       [](auto& d, auto&) {
         d.type = VoxelType::float32;
         d.coding = SampleCoding{VoxelType::int16, 0, 0};
       }},
      {"labels of floats", ErrorKind::internal,
       [](auto& d, auto&) {
         d.type = VoxelType::float32;
         d.coding = SampleCoding{};
         d.kind = VolumeKind::labels;
       }},
      {"a lossy label map", ErrorKind::internal,
       [](auto& d, auto& o) {
         d.kind = VolumeKind::labels;
         o.max_error = 1;
       }},
      {"half an integer", ErrorKind::internal, [](auto&, auto& o) { o.max_error = 0.5; }},
      {"a negative error", ErrorKind::internal, [](auto&, auto& o) { o.max_error = -1; }},
      {"an endless error", ErrorKind::internal, [](auto&, auto& o) { o.max_error = HUGE_VAL; }},
      {"no spacing", ErrorKind::invalid_argument,
       [](auto& d, auto&) { d.geometry.spacing_mm[1] = 0; }},
      {"axes that are longer than 1", ErrorKind::invalid_argument,
       [](auto& d, auto&) { d.geometry.direction = {2, 0, 0, 0, 2, 0, 0, 0, 2}; }},
      {"an origin beyond the stars", ErrorKind::invalid_argument,
       [](auto& d, auto&) { d.geometry.origin_mm[2] = 1e13; }},
      {"no slope", ErrorKind::invalid_argument, [](auto& d, auto&) { d.rescale.slope = 0; }},
      {"endless real values", ErrorKind::invalid_argument,
       [](auto& d, auto&) { d.rescale.slope = 1e305; }},
      {"metadata", ErrorKind::limit_exceeded,
       [](auto& d, auto&) {
         d.metadata = Metadata::read(std::string(std::size_t{16} << 20, ' '));
       }},
  };
  for (const auto& c : cases) {
    MemoryStorage storage;
    VolumeDescription description = volume.description;
    WriterOptions options;
    c.change(description, options);
    EXPECT_EQ(kind_of_failure([&] {
                FileWriter::create(storage, "a.8vo", description, volume.levels, 1, options);
              }),
              c.kind)
        << c.what;
    EXPECT_TRUE(storage.files.empty()) << c.what;
  }
  MemoryStorage storage;
  EXPECT_EQ(kind_of_failure([&] {
              FileWriter::create(storage, "a.8vo", volume.description, Levels(), 1, {});
            }),
            ErrorKind::internal);
}

TEST(Writer, RejectsBricksThatNoFileCanHave) {
  const SampleVolume volume = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  const std::function<void(EncodedBrick&)> changes[] = {
      [](EncodedBrick& b) { b.segments.resize(5); },
      [](EncodedBrick& b) { b.range = {-32769, 0}; },
      [](EncodedBrick& b) { b.range = {0, 32768}; },
      [](EncodedBrick& b) { b.range = {1, 0}; },
      [](EncodedBrick& b) { b.max_error = -1; },
      [](EncodedBrick& b) { b.max_error = 3; },
      [](EncodedBrick& b) { b.segments[2] = {1}; },
      [](EncodedBrick& b) {
        b.range = {0, 1};
        b.segments[4] = {1};  // a level that the coarsest samples below it do not reach
      },
  };
  for (const auto& change : changes) {
    MemoryStorage storage;
    const auto writer =
        FileWriter::create(storage, "a.8vo", volume.description, volume.levels, 1,
                           {.max_error = 2});
    writer->add_model({'r', 'a', 'w'});
    EncodedBrick brick;
    brick.segments.resize(6);
    change(brick);
    EXPECT_EQ(kind_of_failure([&] { writer->add_brick(0, brick); }), ErrorKind::internal);
    EXPECT_TRUE(storage.files.empty());
    // It is over for good.
    EXPECT_EQ(kind_of_failure([&] { writer->finish(); }), ErrorKind::internal);
  }
}

TEST(Writer, ADiskThatReadsBackOtherBytesIsNotTrusted) {
  SampleVolume volume = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  for (const bool is_trailer : {false, true}) {
    MemoryStorage storage;
    int syncs = 0;
    storage.meanwhile = [&](const std::string& what) {
      if (what != "sync" || ++syncs != 2) return;
      auto& bytes = *storage.files.begin()->second;
      (is_trailer ? bytes.back() : bytes.front()) ^= 1;
    };
    std::string message;
    EXPECT_EQ(kind_of_failure([&] { write_sample(storage, "a.8vo", volume); }, &message),
              ErrorKind::io);
    EXPECT_NE(message.find("a failing disk?"), std::string::npos) << message;
    EXPECT_TRUE(storage.files.empty());
  }
}

TEST(Writer, WhatIsNoErrorOfOursLeavesNothingEither) {
  SampleVolume volume = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  MemoryStorage storage;
  storage.meanwhile = [](const std::string& what) {
    if (what == "sync") throw std::bad_alloc();
  };
  EXPECT_THROW(write_sample(storage, "a.8vo", volume), std::bad_alloc);
  EXPECT_TRUE(storage.files.empty());
}

TEST(Writer, SealsInOneWriteAfterEverythingIsOnDisk) {
  MemoryStorage storage;
  SampleVolume volume = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  write_sample(storage, "a.8vo", volume);
  const std::vector<std::string> order = {"create", "write", "write", "sync",   "write",
                                          "sync",   "read",  "read",  "close",  "rename",
                                          "sync_folder"};
  EXPECT_EQ(storage.calls, order);
}

TEST(Writer, TheIndexOfASmallFileIsSmall) {
  SampleVolume volume = make_sample({192, 192, 256}, VoxelType::uint8, Pattern::gradient);
  const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const FileHeader header = parse_header(ByteSpan(bytes).first(kHeaderBytes), bytes.size());
  // 36 bricks of 6 segments, each with a checksum: 864 bytes of 1600 are checksums.
  EXPECT_LT(header.pages.length + header.root.length, 1600u);
}

}  // namespace
}  // namespace octavo
