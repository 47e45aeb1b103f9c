// Flipped bits turned back, or the damage refused and nothing written.
#include "octavo/file/mend.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "octavo/file/layout.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;
using FileContent = std::vector<std::uint8_t>;

struct Outcome {
  std::size_t flip_count = 0;
  std::string failure;
  ErrorKind kind = ErrorKind::internal;
};

Outcome mend(MemoryStorage& storage) {
  Outcome outcome;
  NoProgress progress;
  try {
    const MendOptions options{.overwrite = true, .for_each = {}};
    outcome.flip_count = mend_file(storage, "bad.8vo", "out.8vo", options, progress).flips.size();
  } catch (const Error& error) {
    outcome.failure = error.what();
    outcome.kind = error.kind();
  }
  return outcome;
}

void put(MemoryStorage& storage, const std::string& name, FileContent bytes) {
  storage.files[name] = std::make_shared<FileContent>(std::move(bytes));
}

FileContent two_tiers() {
  SampleVolume volume = make_sample({66, 12, 70}, VoxelType::uint8, Pattern::noisy_half);
  volume.model_layers = 2;
  return sample_file_bytes(volume);
}

TEST(Mend, AnyFlippedBitIsTurnedBack) {
  SampleVolume small = make_sample({16, 16, 4}, VoxelType::uint8, Pattern::noisy_half);
  const FileContent files[] = {sample_file_bytes(small), two_tiers()};
  for (const FileContent& good : files) {
    const std::size_t step = good.size() < 3000 ? 3 : 271;
    for (std::size_t bit = 0; bit < 8 * good.size(); bit += step) {
      FileContent bad = good;
      bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      MemoryStorage storage;
      put(storage, "bad.8vo", bad);
      const Outcome outcome = mend(storage);
      ASSERT_EQ(outcome.failure, "") << "byte " << bit / 8;
      ASSERT_TRUE(*storage.files.at("out.8vo") == good) << "byte " << bit / 8;
      ASSERT_TRUE(*storage.files.at("bad.8vo") == bad);
      ASSERT_EQ(storage.files.size(), 2u);
    }
  }
}

TEST(Mend, AGrowingFileIsRefusedAsSuch) {
  const FileContent good = two_tiers();
  HeaderBlock block{};
  std::copy_n(good.begin(), block.size(), block.begin());
  block = encode_header(parse_unsealed_header(block));
  for (const std::size_t length : {std::size_t{kHeaderBytes}, good.size() / 2}) {
    FileContent growing(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length));
    std::copy(block.begin(), block.end(), growing.begin());
    MemoryStorage storage;
    put(storage, "bad.8vo", growing);
    const Outcome outcome = mend(storage);
    EXPECT_EQ(outcome.kind, ErrorKind::corrupt);
    EXPECT_NE(outcome.failure.find("bad.8vo: not sealed"), std::string::npos) << outcome.failure;
    EXPECT_NE(outcome.failure.find("build it again"), std::string::npos) << outcome.failure;
    EXPECT_EQ(storage.files.size(), 1u);
  }
}

TEST(Mend, OneFlippedBitInEachOfSeveralPiecesIsTurnedBack) {
  const FileContent good = two_tiers();
  FileContent bad = good;
  // The header, a segment, the trailer.
  for (const std::size_t byte : {std::size_t{60}, std::size_t{512} + 900, good.size() - 20}) {
    bad[byte] ^= 32;
  }
  MemoryStorage storage;
  put(storage, "bad.8vo", bad);
  const Outcome outcome = mend(storage);
  EXPECT_EQ(outcome.failure, "");
  EXPECT_EQ(outcome.flip_count, 3u);
  EXPECT_TRUE(*storage.files.at("out.8vo") == good);
}

TEST(Mend, WorseDamageIsRefusedAndNothingIsWritten) {
  const FileContent good = two_tiers();
  const std::size_t places[] = {100, 700, good.size() / 2, good.size() - 70, good.size() - 30};
  for (const std::size_t place : places) {
    FileContent bad = good;
    for (std::size_t i = 0; i < 4; ++i) bad[place + i] = static_cast<std::uint8_t>(~bad[place + i]);
    MemoryStorage storage;
    put(storage, "bad.8vo", bad);
    put(storage, "out.8vo", {'o', 'l', 'd'});
    EXPECT_EQ(mend(storage).kind, ErrorKind::corrupt) << place;
    EXPECT_EQ(storage.files.size(), 2u);
    EXPECT_EQ(*storage.files.at("out.8vo"), (FileContent{'o', 'l', 'd'}));
  }
}

TEST(Mend, ACutFileIsRefused) {
  const FileContent good = two_tiers();
  for (const std::size_t length : {std::size_t{0}, std::size_t{100}, std::size_t{600},
                                   good.size() / 2, good.size() - 1}) {
    MemoryStorage storage;
    put(storage, "bad.8vo", {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)});
    const Outcome outcome = mend(storage);
    EXPECT_TRUE(outcome.kind == ErrorKind::truncated || outcome.kind == ErrorKind::not_octavo)
        << outcome.failure;
    EXPECT_EQ(storage.files.size(), 1u);
  }
}

TEST(Mend, OfASoundFileNothingIsWritten) {
  MemoryStorage storage;
  put(storage, "bad.8vo", two_tiers());
  const Outcome outcome = mend(storage);
  EXPECT_EQ(outcome.failure, "");
  EXPECT_EQ(outcome.flip_count, 0u);
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST(Mend, AnExistingFileIsKeptUnlessAskedForAlsoOneThatAppearsMeanwhile) {
  FileContent bad = two_tiers();
  bad[1000] ^= 1;
  const auto mend_into = [&](MemoryStorage& storage) {
    put(storage, "bad.8vo", bad);
    NoProgress progress;
    mend_file(storage, "bad.8vo", "out.8vo", {}, progress);
  };
  MemoryStorage empty;
  mend_into(empty);
  EXPECT_EQ(*empty.files.at("out.8vo"), two_tiers());
  for (const bool is_there_before : {true, false}) {
    MemoryStorage storage;
    if (is_there_before) put(storage, "out.8vo", {'o', 'l', 'd'});
    storage.meanwhile = [&](const std::string& what) {
      if (what == "sync") put(storage, "out.8vo", {'o', 'l', 'd'});
    };
    EXPECT_THROW(mend_into(storage), Error);
    EXPECT_EQ(storage.files.at("out.8vo")->size(), 3u);
    EXPECT_EQ(storage.files.size(), 2u);
  }
}

TEST(Mend, EveryFailingCallLeavesTheOldFile) {
  const FileContent good = two_tiers();
  FileContent bad = good;
  bad[1000] ^= 1;
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    storage.fail_at = k;
    put(storage, "bad.8vo", bad);
    put(storage, "out.8vo", {'o', 'l', 'd'});
    const Outcome outcome = mend(storage);
    ASSERT_EQ(storage.files.size(), 2u) << outcome.failure;
    if (!storage.has_failed) {
      EXPECT_GT(k, 10u);
      EXPECT_EQ(outcome.failure, "");
      break;
    }
    ASSERT_NE(outcome.failure, "") << "call " << k << " failed unnoticed";
    const FileContent& now = *storage.files.at("out.8vo");
    EXPECT_TRUE(storage.calls.back() == "sync_folder" ? now == good : now.size() == 3);
  }
}

}  // namespace
}  // namespace octavo
