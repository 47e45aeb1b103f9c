#include "octavo/core/error.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "octavo/core/checked.h"
#include "octavo/core/progress.h"

namespace octavo {
namespace {

TEST(Error, EveryKindHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (int kind = 0; kind <= static_cast<int>(ErrorKind::internal); ++kind) {
    names.insert(error_kind_name(static_cast<ErrorKind>(kind)));
  }
  EXPECT_EQ(names.size(), 11u);
  EXPECT_EQ(error_kind_name(ErrorKind::source_rejected), "source_rejected");
  EXPECT_EQ(error_kind_name(static_cast<ErrorKind>(99)), "internal");
}

TEST(Error, SaysThePathFirstAndOnlyOnce) {
  const Error bare(ErrorKind::corrupt, "broken", {}, 17);
  EXPECT_STREQ(bare.what(), "broken");
  const Error named = bare.with_path("a\nb");
  EXPECT_STREQ(named.what(), "a\\x0ab: broken");
  EXPECT_EQ(named.path(), "a\nb");
  EXPECT_EQ(named.offset(), 17u);
  EXPECT_STREQ(named.with_path("c").what(), "a\\x0ab: broken");
}

TEST(Error, KeepsItsOptionsWhateverElseIsSetAndNamesTheFirst) {
  const Error bare(ErrorKind::source_rejected, "uneven", {}, 17);
  EXPECT_EQ(bare.field(), "");
  const Error about = bare.with_field("untilt").with_field("on_gap", "fill");
  EXPECT_TRUE(bare.hints().empty());
  const Error moved = about.with_path("a.dcm").with_detail("very uneven");
  EXPECT_EQ(moved.hints(), (std::vector<OptionHint>{{"untilt", ""}, {"on_gap", "fill"}}));
  EXPECT_EQ(moved.field(), "untilt");
  EXPECT_STREQ(moved.what(), "a.dcm: very uneven");
  EXPECT_EQ(moved.kind(), ErrorKind::source_rejected);
  EXPECT_EQ(moved.offset(), 17u);
}

TEST(Escaped, KeepsPrintableBytesAndCutsLongText) {
  EXPECT_EQ(escaped(" ~\x1f\x7f\xff"), " ~\\x1f\\x7f\\xff");
  EXPECT_EQ(escaped(std::string(200, 'a')), std::string(200, 'a'));
  EXPECT_EQ(escaped(std::string(201, 'a')), std::string(200, 'a') + "...");
  EXPECT_LE(escaped(std::string(1000, '\n')).size(), 200u + 3 + 3);
}

TEST(Escaped, KeepsCharactersOfAnyScript) {
  for (const char* text : {"Größe", "左肾", "Ωλένη", "\xf0\x9f\xa6\xb4", "\xc2\xa0"}) {
    EXPECT_EQ(escaped(text), text);
  }
}

TEST(Escaped, EscapesWhatIsNoTextOrTurnsIt) {
  EXPECT_EQ(escaped("a\xc2\x9b" "31m"), "a\\xc2\\x9b31m") << "a control character";
  EXPECT_EQ(escaped("\xe2\x80\xae" "x"), "\\xe2\\x80\\xaex") << "from right to left";
  EXPECT_EQ(escaped("\xe2\x80\xa8"), "\\xe2\\x80\\xa8") << "a line end";
  EXPECT_EQ(escaped("\xe2\x82"), "\\xe2\\x82") << "breaks off";
  EXPECT_EQ(escaped("\xc0\xaf"), "\\xc0\\xaf") << "overlong";
}

TEST(Escaped, CutsBehindWholeCharacters) {
  std::string text(199, 'a');
  text += "\xc3\xa9";
  EXPECT_EQ(escaped(text), std::string(199, 'a') + "...");
  text.erase(0, 1);
  EXPECT_EQ(escaped(text), text);
}

/// The kind of what `work` throws, or nothing.
template <class Work>
std::optional<ErrorKind> thrown_by(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.kind();
  }
  return {};
}

TEST(Checked, TheLargestResultIsGivenAndTheNextOneRejected) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(checked_mul(0xffffffffu, 0x100000001u, "size"), kMost);
  EXPECT_EQ(thrown_by([] { checked_mul(std::uint64_t{1} << 32, std::uint64_t{1} << 32, "size"); }),
            ErrorKind::limit_exceeded);
  EXPECT_EQ(checked_add(kMost, 0, "size"), kMost);
  EXPECT_EQ(thrown_by([] { checked_add(kMost, 1, "size"); }), ErrorKind::limit_exceeded);
  constexpr std::int64_t kFar = std::int64_t{1} << 62;
  EXPECT_EQ(checked_count(kFar, 1, "voxels"), kFar);
  EXPECT_EQ(thrown_by([] { checked_count(kFar, 2, "voxels"); }), ErrorKind::limit_exceeded);
}

/// Notes what it hears.
class Recorder final : public Progress {
 public:
  void begin(std::string_view what, std::int64_t, std::string_view) override { text += what; }
  void advance(std::int64_t) override {}
  void end() override { text += " ended"; }
  bool is_cancelled() const override { return false; }
  std::string text;
};

TEST(ProgressScope, EndsHoweverTheWorkEnds) {
  Recorder recorded;
  EXPECT_THROW(
      {
        const ProgressScope scope(recorded, "planes", 3, "planes");
        throw Error(ErrorKind::io, "the disk fails");
      },
      Error);
  EXPECT_EQ(recorded.text, "planes ended");
}

}  // namespace
}  // namespace octavo
