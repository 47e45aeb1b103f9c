// The names of all members of the metadata, in the order in which new ones are written.
//
// One list serves both ways: a reader takes the value of the member it stands at, a writer puts
// down those that are there. Only metadata*.cpp include this header.
#pragma once

#include "octavo/core/metadata_facts.h"

namespace octavo {

// Members that are changed in metadata that are there.
constexpr const char* kChosen = "chosen";
constexpr const char* kCoding = "coding";
constexpr const char* kIdentity = "identity";
constexpr const char* kIdentityAttributes = "attributes";
constexpr const char* kIdentityDropped = "dropped";
constexpr const char* kIdentityKept = "kept";
constexpr const char* kLabels = "labels";
constexpr const char* kLossySource = "lossy_source";
constexpr const char* kMadeBy = "made_by";
constexpr const char* kPrepared = "prepared";
constexpr const char* kGaps = "gaps";
constexpr const char* kGapsMadePlanes = "made_planes";
constexpr const char* kIsotropic = "isotropic";
constexpr const char* kRepaired = "repaired";
constexpr const char* kMissingPlanes = "missing_planes";
constexpr const char* kSegment = "segment";
constexpr const char* kSegments = "segments";
constexpr const char* kSourceMaxError = "source_max_error";
constexpr const char* kUnit = "unit";
constexpr const char* kWrittenBy = "written_by";

// Members of objects that are read and written by hand.
constexpr const char* kOperation = "operation";  // of made_by
constexpr const char* kLabelName = "name";       // of a label
constexpr const char* kLabelColor = "color";
/// Text that is no metadata, where it became part of such.
constexpr const char* kUnreadable = "unreadable";

template <class Visit>
void visit_fields(Visit& visit, SourceNote& source) {
  visit.count("files", source.file_count);
  visit("format", source.format);
  visit.others(source.settings);
}

template <class Visit>
void visit_fields(Visit& visit, ComponentNote& component) {
  visit("count", component.count);
  visit("index", component.index);
  visit("name", component.name);
}

template <class Visit>
void visit_fields(Visit& visit, ChoiceNote& choice) {
  visit("channel", choice.channel);
  visit("time", choice.time);
}

template <class Visit>
void visit_fields(Visit& visit, SegmentNote& segment) {
  visit("number", segment.number);
}

template <class Visit>
void visit_fields(Visit& visit, GapsNote& gaps) {
  visit("left_out_mm", gaps.left_out_mm);
  visit("made_plane_count", gaps.made_plane_count);
  visit(kGapsMadePlanes, gaps.made_planes);
  visit("method", gaps.method);
  visit("on_gap", gaps.on_gap);
  visit("slices", gaps.slices);
  visit("step_mm", gaps.step_mm);
}

template <class Visit>
void visit_fields(Visit& visit, TiltNote& tilt) {
  visit("angle_degrees", tilt.angle_degrees);
  visit("method", tilt.method);
  visit("outside", tilt.outside);
  visit("slice_size", tilt.slice_size);
}

template <class Visit>
void visit_fields(Visit& visit, IsotropicNote& isotropic) {
  visit("left_out_mm", isotropic.left_out_mm);
  visit("made_plane_count", isotropic.made_plane_count);
  visit("method", isotropic.method);
  visit("slice_mm", isotropic.slice_mm);
  visit("slices", isotropic.slices);
  visit("step_mm", isotropic.step_mm);
}

template <class Visit>
void visit_fields(Visit& visit, PreparedNote& prepared) {
  visit("dropped_duplicates", prepared.dropped_duplicates);
  visit(kGaps, prepared.gaps);
  visit("ignored_number_gaps", prepared.ignored_number_gaps);
  visit(kIsotropic, prepared.isotropic);
  visit("tilt", prepared.tilt);
}

template <class Visit>
void visit_fields(Visit& visit, IdentityNote& identity) {
  visit(kIdentityAttributes, identity.attributes);
  visit.always(kIdentityDropped, identity.dropped);
  visit(kIdentityKept, identity.kept);
}

template <class Visit>
void visit_fields(Visit& visit, DetailErrors& errors) {
  visit.exact("max", errors.max);
  visit.exact("rms", errors.rms);
  visit.exact("psnr_db", errors.psnr_db);
}

template <class Visit>
void visit_fields(Visit& visit, CodingNote& coding) {
  visit("preset", coding.preset);
  visit("access", coding.access);
  visit.exact("max_error", coding.max_error);
  visit.exact("nan", coding.nan);
  visit.exact("inf", coding.infinity);
  visit("keep_details", coding.keep_details);
  visit("detail_errors", coding.detail_errors);
}

template <class Visit>
void visit_fields(Visit& visit, RepairNote& repair) {
  visit(kMissingPlanes, repair.missing_planes);
  visit.exact("fill", repair.fill);
}

template <class Visit>
void visit_fields(Visit& visit, WriterNote& writer) {
  visit("name", writer.name);
  visit("revision", writer.revision);
}

template <class Visit>
void visit_fields(Visit& visit, MetadataFacts& facts) {
  visit(kChosen, facts.chosen);
  visit(kCoding, facts.coding);
  visit("dicom", facts.dicom);
  visit(kIdentity, facts.identity);
  visit(kLabels, facts.labels);
  visit(kLossySource, facts.lossy_source);
  visit(kMadeBy, facts.made_by);
  visit("place_known", facts.place_known);
  visit(kPrepared, facts.prepared);
  visit(kRepaired, facts.repaired);
  visit(kSegment, facts.segment);
  visit(kSegments, facts.segments);
  visit("source", facts.source);
  visit(kSourceMaxError, facts.source_max_error);
  visit("spacing_known", facts.spacing_known);
  visit("spacing_source", facts.spacing_source);
  visit(kUnit, facts.unit);
  visit(kWrittenBy, facts.written_by);
}

}  // namespace octavo
