#include "octavo/io/dicom/dicom_moment.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "octavo/core/text.h"
#include "octavo/io/dicom/dicom_slice.h"
#include "octavo/io/dicom/dicom_tags.h"

namespace octavo {

namespace {

constexpr DicomTag kFrameContentSequence = 0x00209111;

enum class TimeForm { binary, single, decimal, clock };  // float64, float32, text

/// A time, and the groups that may have it: a sequence of the frame, one of all frames.
struct TimeAttribute {
  DicomTag tag;
  TimeForm form;
  DicomTag own;
  DicomTag shared;
};

constexpr TimeAttribute kTimeOffset = {0x0020930d, TimeForm::binary, kTemporalPositionSequence,
                                       kTemporalPositionSequence};
constexpr TimeAttribute kTriggerDelay = {0x00209153, TimeForm::binary,
                                         kCardiacSynchronizationSequence,
                                         kCardiacSynchronizationSequence};
constexpr TimeAttribute kPhase = {0x00209241, TimeForm::single, kCardiacSynchronizationSequence,
                                  kCardiacSynchronizationSequence};
constexpr TimeAttribute kReferenceClock = {0x00189151, TimeForm::clock, kFrameContentSequence,
                                           kFrameContentSequence};
// Files that were converted from single slices keep these apart.
constexpr TimeAttribute kTriggerTime = {0x00181060, TimeForm::decimal,
                                        kFrameConvertedAttributesSequence,
                                        kSharedConvertedAttributesSequence};
constexpr TimeAttribute kReferenceTime = {0x00541300, TimeForm::decimal,
                                          kFrameConvertedAttributesSequence,
                                          kSharedConvertedAttributesSequence};

/// A date and time, or a time, as a number; what is left out behind is 0. The place on earth behind
/// it is passed over, since it is that of all slices.
/// digits  of the whole number
std::optional<double> clock_number(std::string text, std::size_t digits) {
  text = text.substr(0, text.find_first_of("+-"));
  const std::size_t whole = std::min(text.find('.'), text.size());
  if (whole < 2 || whole > digits) return std::nullopt;
  text.insert(whole, std::string(digits - whole, '0'));
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value,
                                              std::chars_format::fixed);
  const bool is_number = failure == std::errc() && end == text.data() + text.size();
  return is_number && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

constexpr std::size_t kDateTimeDigits = 14;
constexpr std::size_t kTimeDigits = 6;

std::optional<double> float32_in(const DicomSet& set, DicomTag tag) {
  const std::optional<std::int64_t> bits = set.unsigned_value(tag);
  if (!bits) return std::nullopt;
  const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(*bits));
  return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
}

std::optional<double> time_in(const DicomSet& set, const TimeAttribute& time) {
  switch (time.form) {
    case TimeForm::binary: return set.float64(time.tag);
    case TimeForm::single: return float32_in(set, time.tag);
    case TimeForm::decimal: return set.decimal(time.tag);
    default: return clock_number(set.text(time.tag), kDateTimeDigits);
  }
}

/// Acquisition Time behind Acquisition Date.
std::optional<double> acquisition_time(const DicomSet& data) {
  constexpr double kDay = 1e6;
  const std::optional<double> time = clock_number(data.text(0x00080032), kTimeDigits);
  if (!time) return std::nullopt;
  return data.decimal(0x00080022).value_or(0) * kDay + *time;
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
    {"Temporal Position Index (0020,9128)", "", MomentKind::count, temporal_index},
    {"Temporal Position Identifier (0020,0100)", "", MomentKind::count, temporal_position},
    {"Temporal Position Time Offset (0020,930d)", " s", MomentKind::measure,
     [](const DicomSlice& slice) { return slice.moment.offset_s; }},
    {"Nominal Cardiac Trigger Delay Time (0020,9153)", " ms", MomentKind::measure,
     [](const DicomSlice& slice) { return slice.moment.delay_ms; }},
    {"Nominal Percentage of Cardiac Phase (0020,9241)", " %", MomentKind::count,
     [](const DicomSlice& slice) { return slice.moment.phase_percent; }},
    {"Trigger Time (0018,1060)", " ms", MomentKind::measure,
     [](const DicomSlice& slice) { return slice.moment.trigger_ms; }},
    {"Frame Reference Time (0054,1300)", " ms", MomentKind::measure,
     [](const DicomSlice& slice) { return slice.moment.reference_ms; }},
    {"Acquisition Number (0020,0012)", "", MomentKind::run, acquisition_number},
    {"Frame Reference DateTime (0018,9151)", "", MomentKind::clock,
     [](const DicomSlice& slice) { return slice.moment.reference_clock; }},
    {"Acquisition DateTime (0008,002a)", "", MomentKind::clock,
     [](const DicomSlice& slice) { return slice.moment.acquisition_clock; }},
    {"Acquisition Time (0008,0032)", "", MomentKind::clock,
     [](const DicomSlice& slice) { return slice.moment.acquisition_time; }}};

}  // namespace

DicomMoment read_dicom_moment(const DicomSet& data, const DicomSet& shared,
                              const DicomSet& frame) {
  DicomMoment moment;
  moment.offset_s = find_time(data, shared, frame, kTimeOffset);
  moment.delay_ms = find_time(data, shared, frame, kTriggerDelay);
  moment.phase_percent = find_time(data, shared, frame, kPhase);
  moment.trigger_ms = find_time(data, shared, frame, kTriggerTime);
  moment.reference_ms = find_time(data, shared, frame, kReferenceTime);
  moment.reference_clock = find_time(data, shared, frame, kReferenceClock);
  moment.acquisition_clock = clock_number(data.text(0x0008002a), kDateTimeDigits);
  moment.acquisition_time = acquisition_time(data);
  // It is measured anew for every slice.
  if (moment.trigger_ms) *moment.trigger_ms = std::round(*moment.trigger_ms * 10) / 10;
  return moment;
}

std::string MomentNumber::text(double value) const {
  if (kind != MomentKind::clock) return precise_text(value);
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.2f", value);
  std::string text = digits;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::span<const MomentNumber> moment_numbers() { return kMomentNumbers; }

std::string moment_difference(const DicomSlice& a, const DicomSlice& b) {
  for (const MomentNumber& number : kMomentNumbers) {
    const std::optional<double> in_a = number.of(a);
    const std::optional<double> in_b = number.of(b);
    if (!in_a || !in_b || *in_a == *in_b) continue;
    return std::string(number.name) + " is " + number.text(*in_a) + number.unit + " and " +
           number.text(*in_b) + number.unit;
  }
  return {};
}

}  // namespace octavo
