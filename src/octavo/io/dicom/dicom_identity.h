// What DICOM files say beside the picture and how it was made: who is in it, where and when.
#pragma once

#include "octavo/io/dicom/dicom_stack.h"
#include "octavo/io/source/source_identity.h"

namespace octavo {

/// Every element of the files of `stack` that neither the volume nor its metadata take up, by
/// keyword and nested ones as well; those of private groups are counted as "private". Text of the
/// first slice's own data set could be kept, with characters as its Specific Character Set says
/// (Latin 1 and UTF-8; others are replaced), and the labels of segments behind their numbers.
/// Throws as read_dicom_file
SourceIdentity dicom_identity(const DicomStack& stack);

}  // namespace octavo
