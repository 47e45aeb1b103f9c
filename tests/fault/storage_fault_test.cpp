#include <gtest/gtest.h>

#include <csignal>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>

#include "octavo/file/storage/temporary.h"
#include "octavo/file/verify.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using namespace octavo::testing;

bool is_sound(const std::vector<std::uint8_t>& bytes) {
  NoProgress progress;
  return verify_file(byte_source_of(bytes, "a.8vo"), {}, progress).is_sound();
}

// Fails call after call; what stands under the name is always whole.
void fail_every_call(bool has_old_file, SampleVolume volume) {
  const std::vector<std::uint8_t> old_bytes = {'o', 'l', 'd'};
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    storage.fail_at = k;
    if (has_old_file) {
      storage.files["a.8vo"] = std::make_shared<std::vector<std::uint8_t>>(old_bytes);
    }
    std::string message;
    try {
      write_sample(storage, "a.8vo", volume, true);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io) << error.what();
      EXPECT_EQ(error.path(), "a.8vo");
      message = error.what();
    }
    if (!storage.has_failed) {
      EXPECT_TRUE(message.empty());
      EXPECT_GT(k, 10u);
      return;
    }
    ASSERT_FALSE(message.empty()) << "call " << k << " failed unnoticed";
    const bool was_named = storage.calls.back() == "sync_folder";
    ASSERT_EQ(storage.files.size(), has_old_file || was_named ? 1u : 0u) << message;
    if (was_named) {
      EXPECT_TRUE(is_sound(*storage.files.at("a.8vo")));
    } else if (has_old_file) {
      EXPECT_EQ(*storage.files.at("a.8vo"), old_bytes);
      EXPECT_NE(message.find("existing a.8vo unchanged"), std::string::npos) << message;
    }
  }
}

TEST(StorageFaults, EveryFailingCallLeavesTheOldFile) {
  fail_every_call(true, make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient));
}

TEST(StorageFaults, EveryFailingCallLeavesNothingBehind) {
  fail_every_call(false, make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient));
}

TEST(StorageFaults, TheScratchFileMayFailToo) {
  SampleVolume volume = make_sample({256, 256, 70}, VoxelType::int16, Pattern::gradient);
  MemoryStorage storage;
  write_sample(storage, "a.8vo", volume);
  EXPECT_EQ(std::count(storage.calls.begin(), storage.calls.end(), "create_scratch"), 1);
  fail_every_call(true, volume);
}

TEST(StorageFaults, ANameThatAnotherProgramTakesMeanwhileIsLeftToIt) {
  SampleVolume volume = make_sample({70, 20, 20}, VoxelType::int16, Pattern::gradient);
  MemoryStorage storage;
  const std::string name = temporary_prefix("a.8vo") + std::to_string(::getpid());
  storage.meanwhile = [&](const std::string& what) {
    if (what == "create" && !storage.exists("a.8vo")) {
      storage.files.try_emplace(name, std::make_shared<std::vector<std::uint8_t>>(3));
    }
  };
  write_sample(storage, "a.8vo", volume);
  EXPECT_EQ(storage.files.size(), 2u);
  EXPECT_EQ(storage.files.at(name)->size(), 3u);
  EXPECT_TRUE(is_sound(*storage.files.at("a.8vo")));
}

TEST(StorageFaults, AFullDiskLeavesNothing) {
  std::string name = (fs::temp_directory_path() / "octavo-full-XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  SampleVolume volume = make_sample({64, 64, 64}, VoxelType::int16, Pattern::gradient);
  const std::size_t needed = sample_file_bytes(volume).size();
  for (std::size_t kib = 4; kib <= needed / 1024; kib += 64) {
    const std::string options = "size=" + std::to_string(kib) + "k";
    if (::mount("none", name.c_str(), "tmpfs", 0, options.c_str()) != 0) {
      fs::remove(name);
      GTEST_SKIP() << "needs the right to mount a tmpfs";
    }
    try {
      write_sample(local_storage(), name + "/a.8vo", volume);
      ADD_FAILURE() << needed << " bytes fitted into " << kib << " KiB";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io);
      EXPECT_NE(std::string(error.what()).find("no space left"), std::string::npos)
          << error.what();
    }
    EXPECT_TRUE(fs::is_empty(name));
    ::umount(name.c_str());
  }
  fs::remove(name);
}

TEST(StorageFaults, AFileSizeLimitIsAnErrorNotADeath) {
  std::string name = (fs::temp_directory_path() / "octavo-limit-XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  SampleVolume volume = make_sample({64, 64, 64}, VoxelType::int16, Pattern::gradient);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  ::signal(SIGXFSZ, SIG_IGN);
  // The write that crosses the limit is cut short first: what is left of it must be tried and
  // reported.
  for (const rlim_t limit : {rlim_t{100}, rlim_t{512}, rlim_t{100'000}}) {
    const rlimit tight{limit, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
    EXPECT_THROW(write_sample(local_storage(), name + "/a.8vo", volume), Error);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_TRUE(fs::is_empty(name));
  }
  fs::remove(name);
}

}  // namespace
}  // namespace octavo
