#include "octavo/io/dicom/dicom_counts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kKindTag = 0x00080060;
constexpr std::uint32_t kAcquisition = 0x00200012;
constexpr std::uint32_t kTemporalPosition = 0x00200100;
constexpr std::uint32_t kTemporalPositions = 0x00200105;
constexpr std::uint32_t kImages = 0x00201002;
constexpr std::uint32_t kConcatenation = 0x00209161;
constexpr std::uint32_t kPart = 0x00209162;
constexpr std::uint32_t kParts = 0x00209163;
constexpr std::uint32_t kReferenceTime = 0x00541300;
constexpr std::uint32_t kSlices = 0x00540081;
constexpr std::uint32_t kTimeSlices = 0x00540101;

using Change = std::function<void(DicomElements&, int)>;

/// Slices 3 mm apart, `count` of them at each of several moments, with what `change` makes of each.
void write_slices(const TempFolder& folder, int count, const Change& change, int moments = 1) {
  for (int i = 0; i < count * moments; ++i) {
    DicomElements elements = ct_elements(5, 3, 8, i % count * 3);
    change(elements, i);
    elements.write(folder.file("s" + std::to_string(i)), kExplicitLittle);
  }
}

/// Whether a warning of missing pictures has all `words`; false where there is none.
bool is_told(const PlaneSource& source, const std::vector<std::string>& words) {
  return std::ranges::any_of(source.warnings(), [&](const Warning& warning) {
    return contains(warning, "may be missing") &&
           std::ranges::all_of(words, [&](const auto& word) { return contains(warning, word); });
  });
}

TEST(DicomCounts, PartsOfAConcatenationMustAllBeThere) {
  const auto parts = [](std::uint16_t first, std::uint16_t all) {
    return [=](DicomElements& elements, int i) {
      elements.set(kConcatenation, "UI", std::string("1.2.3\0", 6));
      elements.set_number(kPart, static_cast<std::uint16_t>(first + i));
      if (all > 0) elements.set_number(kParts, all);
    };
  };
  for (const std::uint16_t all : std::vector<std::uint16_t>{0, 2}) {
    const TempFolder whole;
    write_slices(whole, 2, parts(1, all));
    const auto source = open_source({whole.path()}, {});
    EXPECT_EQ(source->description().size.z, 2);
    EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
  }
  const TempFolder last;
  write_slices(last, 2, parts(1, 3));
  expect_rejected(last.path(), {"2 files of a concatenation are there",
                                "In-concatenation Total Number (0020,9163) says 3",
                                "complete the series"});
  const TempFolder first;
  write_slices(first, 2, parts(2, 0));
  expect_rejected(first.path(), {"2 files of a concatenation are there",
                                 "In-concatenation Number (0020,9162) goes up to 3"});
}

TEST(DicomCounts, FewerSlicesOfPetThanTheHeaderSaysAreTold) {
  const auto pet = [](DicomElements& elements, int) {
    elements.set(kKindTag, "CS", "PT");
    elements.set_number(kSlices, 5);
  };
  const TempFolder few;
  write_slices(few, 4, pet);
  EXPECT_TRUE(is_told(*open_source({few.path()}, {}),
                      {"4 slices are there, Number of Slices (0054,0081) says 5"}));
  const TempFolder all;
  write_slices(all, 5, pet);
  EXPECT_FALSE(is_told(*open_source({all.path()}, {}), {}));
  const TempFolder ct;
  write_slices(ct, 4, [](DicomElements& elements, int) { elements.set_number(kSlices, 5); });
  EXPECT_FALSE(is_told(*open_source({ct.path()}, {}), {}));
}

TEST(DicomCounts, FewerImagesThanTheAcquisitionHasAreTold) {
  const auto images = [](const char* count) {
    return [=](DicomElements& elements, int i) {
      elements.set(kImages, "IS", count);
      elements.set(kAcquisition, "IS", i < 3 ? "1 " : "2 ");
    };
  };
  const TempFolder few;
  write_slices(few, 4, images("5 "));
  EXPECT_TRUE(is_told(*open_source({few.path()}, {}),
                      {"4 images are there, Images in Acquisition (0020,1002) says 5"}));
  // Of one acquisition, of all, or of none that a program counted.
  for (const char* count : {"3 ", "4 ", "1 ", "0 ", "-1"}) {
    const TempFolder all;
    write_slices(all, 4, images(count));
    EXPECT_FALSE(is_told(*open_source({all.path()}, {}), {})) << count;
  }
}

TEST(DicomCounts, FewerMomentsThanTheHeaderSaysAreTold) {
  const auto moments = [](int said) {
    return [=](DicomElements& elements, int i) {
      elements.set(kTemporalPosition, "IS", i < 2 ? "1 " : "2 ");
      elements.set(kTemporalPositions, "IS", std::to_string(said) + " ");
    };
  };
  const auto of_pet = [](DicomElements& elements, int i) {
    elements.set(kKindTag, "CS", "PT");
    elements.set(kReferenceTime, "DS", i < 2 ? "0 " : "9 ");
    elements.set_number(kTimeSlices, 3);
  };
  SourceOptions options;
  options.time = 1;
  const TempFolder few;
  write_slices(few, 2, moments(3), 2);
  EXPECT_TRUE(is_told(*open_source({few.path()}, options),
                      {"2 points in time are there, Number of Temporal Positions (0020,0105) "
                       "says 3"}));
  const TempFolder pet;
  write_slices(pet, 2, of_pet, 2);
  EXPECT_TRUE(is_told(*open_source({pet.path()}, options),
                      {"2 points in time are there, Number of Time Slices (0054,0101) says 3"}));
  const TempFolder all;
  write_slices(all, 2, moments(2), 2);
  EXPECT_FALSE(is_told(*open_source({all.path()}, options), {}));
  // A moment that stands alone is whole.
  const TempFolder one;
  write_slices(one, 2, moments(3));
  EXPECT_FALSE(is_told(*open_source({one.path()}, {}), {}));
}

}  // namespace
}  // namespace octavo::testing
