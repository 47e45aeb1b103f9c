// How a DICOM picture was made: the few attributes that enter a file as they are.
//
// None of them names a person, a place, a day or an object, as long as it holds what the standard
// says. Where people may have written something else, it stays out: a code must look like one, a
// position of the patient must be one that is defined, a unit must be known. Free text is taken of
// device settings alone, those that the Basic Application Level Confidentiality Profile leaves in
// place.
//
// Source: DICOM PS3.15 E.1 (which attributes may tell who), PS3.5 6.2 (form of codes)
#pragma once

#include "octavo/core/json_text.h"
#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

/// The attributes of `data` that may be kept, by keyword.
JsonObject dicom_note(const DicomSet& data);

/// True for the tags of that list where nothing in `data` under them has to stay out.
bool is_dicom_metadata(const DicomSet& data, DicomTag tag);

/// True for all tags of that list.
bool is_dicom_attribute(DicomTag tag);

}  // namespace octavo
