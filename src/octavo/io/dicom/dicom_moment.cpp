#include "octavo/io/dicom/dicom_moment.h"

#include <charconv>
#include <cmath>

#include "octavo/core/text.h"
#include "octavo/io/dicom/dicom_slice.h"
#include "octavo/io/dicom/dicom_tags.h"

namespace octavo {

namespace {

/// A time, and the groups that may have it: a sequence of the frame, one of all frames.
struct TimeAttribute {
  DicomTag tag;
  bool is_binary;  ///< a float64, else text
  DicomTag own;
  DicomTag shared;
};

constexpr TimeAttribute kTimeOffset = {0x0020930d, true, kTemporalPositionSequence,
                                       kTemporalPositionSequence};
constexpr TimeAttribute kTriggerDelay = {0x00209153, true, kCardiacSynchronizationSequence,
                                         kCardiacSynchronizationSequence};
// Files that were converted from single slices keep these apart.
constexpr TimeAttribute kTriggerTime = {0x00181060, false, kFrameConvertedAttributesSequence,
                                        kSharedConvertedAttributesSequence};
constexpr TimeAttribute kReferenceTime = {0x00541300, false, kFrameConvertedAttributesSequence,
                                          kSharedConvertedAttributesSequence};

std::optional<double> time_in(const DicomSet& set, const TimeAttribute& time) {
  return time.is_binary ? set.float64(time.tag) : set.decimal(time.tag);
}

/// What the groups of a frame, else of all, else the data set say.
std::optional<double> find_time(const DicomSet& data, const DicomSet& shared,
                                const DicomSet& frame, const TimeAttribute& time) {
  for (const auto& [set, sequence] : {std::pair(&frame, time.own),
                                      std::pair(&shared, time.shared)}) {
    if (set->items(sequence).empty()) continue;
    const std::optional<double> found = time_in(set->items(sequence).front(), time);
    if (found) return found;
  }
  return time_in(data, time);
}

/// The number that a text starts with.
std::optional<double> leading_number(const std::string& text) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<double> temporal_index(const DicomSlice& slice) {
  if (!slice.temporal_index) return std::nullopt;
  return static_cast<double>(*slice.temporal_index);
}

std::optional<double> temporal_position(const DicomSlice& slice) {
  return leading_number(slice.layout->temporal_position);
}

std::optional<double> acquisition_number(const DicomSlice& slice) {
  return leading_number(slice.layout->acquisition);
}

constexpr MomentNumber kMomentNumbers[] = {
    {"Temporal Position Index (0020,9128)", "", temporal_index},
    {"Temporal Position Identifier (0020,0100)", "", temporal_position},
    {"Temporal Position Time Offset (0020,930d)", " s",
     [](const DicomSlice& slice) { return slice.moment.offset_s; }},
    {"Nominal Cardiac Trigger Delay Time (0020,9153)", " ms",
     [](const DicomSlice& slice) { return slice.moment.delay_ms; }},
    {"Trigger Time (0018,1060)", " ms",
     [](const DicomSlice& slice) { return slice.moment.trigger_ms; }},
    {"Frame Reference Time (0054,1300)", " ms",
     [](const DicomSlice& slice) { return slice.moment.reference_ms; }},
    {"Acquisition Number (0020,0012)", "", acquisition_number}};

}  // namespace

DicomMoment read_dicom_moment(const DicomSet& data, const DicomSet& shared,
                              const DicomSet& frame) {
  DicomMoment moment;
  moment.offset_s = find_time(data, shared, frame, kTimeOffset);
  moment.delay_ms = find_time(data, shared, frame, kTriggerDelay);
  moment.trigger_ms = find_time(data, shared, frame, kTriggerTime);
  moment.reference_ms = find_time(data, shared, frame, kReferenceTime);
  // It is measured anew for every slice.
  if (moment.trigger_ms) *moment.trigger_ms = std::round(*moment.trigger_ms * 10) / 10;
  return moment;
}

std::span<const MomentNumber> moment_numbers() { return kMomentNumbers; }

std::string moment_difference(const DicomSlice& a, const DicomSlice& b) {
  for (const MomentNumber& number : kMomentNumbers) {
    const std::optional<double> in_a = number.of(a);
    const std::optional<double> in_b = number.of(b);
    if (!in_a || !in_b || *in_a == *in_b) continue;
    return std::string(number.name) + " is " + precise_text(*in_a) + number.unit + " and " +
           precise_text(*in_b) + number.unit;
  }
  return {};
}

}  // namespace octavo
