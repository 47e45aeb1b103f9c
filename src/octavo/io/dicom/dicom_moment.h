// When a frame was taken: the numbers that tell moments of one body apart.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

struct DicomSlice;

/// Times that a header gives a frame; absent where it does not.
struct DicomMoment {
  std::optional<double> offset_s;      ///< Temporal Position Time Offset
  std::optional<double> delay_ms;      ///< Nominal Cardiac Trigger Delay Time
  std::optional<double> phase_percent; ///< Nominal Percentage of Cardiac Phase
  std::optional<double> trigger_ms;    ///< Trigger Time to a tenth
  std::optional<double> reference_ms;  ///< Frame Reference Time
  // As a header writes them: 20261231235959.25 is the last second of a year.
  std::optional<double> reference_clock;    ///< Frame Reference DateTime
  std::optional<double> acquisition_clock;  ///< Acquisition DateTime
  std::optional<double> acquisition_time;   ///< Acquisition Time, behind its date if it has one
};

/// The times of a frame: its own functional groups speak first, then those of all frames, then the
/// data set.
/// Source  DICOM PS3.3 C.7.6.16.2.7 (Cardiac Synchronization), C.7.6.16.2.21 (Temporal Position),
///         C.7.6.16.2.25.1 (Unassigned Per-Frame Converted Attributes), C.8.9.4 (PET Image)
DicomMoment read_dicom_moment(const DicomSet& data, const DicomSet& shared, const DicomSet& frame);

enum class MomentKind {
  count,    ///< the same for all slices of a moment
  run,      ///< so may this be, or another for each slice
  measure,  ///< may be measured anew for each slice
  clock     ///< so may this, which tells no moments where anything else tells slices apart
};

/// A number that may tell moments apart.
struct MomentNumber {
  const char* name;  ///< of the attribute
  const char* unit;  ///< with a blank before it; empty where it has none
  MomentKind kind;
  std::optional<double> (*of)(const DicomSlice&);

  /// The value without its unit.
  std::string text(double value) const;
};

/// Those that are known; what tells a moment most surely comes first.
std::span<const MomentNumber> moment_numbers();

/// The first number that tells two slices apart, with both values; empty where none does.
std::string moment_difference(const DicomSlice& a, const DicomSlice& b);

}  // namespace octavo
