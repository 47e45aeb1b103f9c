#include "octavo/io/dicom/dicom_moment.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// Where a header may have a time.
struct TimePlace {
  std::optional<double> DicomMoment::* time;
  DicomTag tag;
  DicomTag own;     ///< sequence of a frame
  DicomTag shared;  ///< of all frames
  bool is_binary;
};

constexpr TimePlace kTimePlaces[] = {
    {&DicomMoment::offset_s, 0x0020930d, 0x00209310, 0x00209310, true},
    {&DicomMoment::delay_ms, 0x00209153, 0x00189118, 0x00189118, true},
    {&DicomMoment::trigger_ms, 0x00181060, 0x00209171, 0x00209170, false},
    {&DicomMoment::reference_ms, 0x00541300, 0x00209171, 0x00209170, false}};

/// Has the time itself.
DicomSet set_with(const TimePlace& place, double time) {
  DicomSet set;
  set.add_value(place.tag, place.is_binary ? bytes_of<double>({time}) : std::to_string(time));
  return set;
}

/// Has it in a group.
DicomSet group_with(DicomTag sequence, const TimePlace& place, double time) {
  DicomSet set;
  set.add_item(sequence, set_with(place, time));
  return set;
}

TEST(DicomMoment, IsThatOfTheFrameThenThatOfAllThenThatOfTheDataSet) {
  for (const TimePlace& place : kTimePlaces) {
    const DicomSet none;
    const DicomSet data = set_with(place, 1.5);
    const DicomSet shared = group_with(place.shared, place, 2.5);
    const DicomSet own = group_with(place.own, place, 3.5);
    const auto found = [&](const DicomSet& of_data, const DicomSet& of_all, const DicomSet& frame) {
      return read_dicom_moment(of_data, of_all, frame).*place.time;
    };
    EXPECT_EQ(found(none, none, none), std::nullopt) << place.tag;
    EXPECT_EQ(found(data, none, none), 1.5) << place.tag;
    EXPECT_EQ(found(none, shared, none), 2.5) << place.tag;
    EXPECT_EQ(found(data, shared, none), 2.5) << place.tag;
    EXPECT_EQ(found(data, shared, own), 3.5) << place.tag;
    // A group without the time says nothing.
    DicomSet silent;
    silent.add_item(place.own, {});
    EXPECT_EQ(found(data, shared, silent), 2.5) << place.tag;
  }
}

TEST(DicomMoment, ConvertedAttributesOfAllAreNotThoseOfAFrame) {
  const TimePlace& trigger = kTimePlaces[2];
  EXPECT_EQ(read_dicom_moment({}, group_with(trigger.own, trigger, 7), {}).trigger_ms,
            std::nullopt);
  EXPECT_EQ(read_dicom_moment({}, {}, group_with(trigger.shared, trigger, 7)).trigger_ms,
            std::nullopt);
}

TEST(DicomMoment, TriggerTimesThatDifferByLessThanATenthAreOne) {
  const TimePlace& trigger = kTimePlaces[2];
  EXPECT_EQ(read_dicom_moment(set_with(trigger, 412.512), {}, {}).trigger_ms, 412.5);
  EXPECT_EQ(read_dicom_moment(set_with(trigger, 412.488), {}, {}).trigger_ms, 412.5);
}

TEST(DicomMoment, HasNoClockWhereATextIsNoNumber) {
  for (const char* text : {"", "1", "10:15", "infini", "nan(1)", "1015301"}) {
    DicomSet data;
    data.add_value(0x00080032, text);
    EXPECT_EQ(read_dicom_moment(data, {}, {}).acquisition_time, std::nullopt) << text;
  }
  for (const char* text : {"infinity123456", "nan(123456789)", "-nan(123456789"}) {
    DicomSet data;
    data.add_value(0x0008002a, text);
    EXPECT_EQ(read_dicom_moment(data, {}, {}).acquisition_clock, std::nullopt) << text;
  }
}

}  // namespace
}  // namespace octavo::testing
