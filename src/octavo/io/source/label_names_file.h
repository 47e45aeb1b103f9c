// Names and colors of labels out of a text file.
#pragma once

#include <string>

#include "octavo/core/label_names.h"

namespace octavo {

/// The names in a text file with one label a line, in one of these layouts:
///
///     1 Precentral_L                      number and name
///     1 Precentral_L 2001                 and a code, which is left out
///     1 Precentral_L 255 128 0            and a color
///     1 Precentral_L 255 128 0 255        and a color with its opacity: FreeSurfer, 3D Slicer
///     Precentral_L 2001                   name and number; a color may follow as well
///     1 255 128 0 1 1 1 "Precentral L"    ITK-SNAP
///     Precentral L                        two lines a label, as Connectome Workbench has them:
///     1 255 128 0 255                     a name; then number, color and opacity
///
/// or in the XML of a GIFTI file, label_table_xml.h.
///
/// All lines have the same layout. A name may hold blanks; in double quotes it may end in numbers,
/// too. A third word that is a number in every line is a code unless names would be the same
/// without it. Opacities are left out. Lines that begin with # are comments. The text is UTF-8,
/// with or without a byte order mark; where it is none, Latin-1. Lines end as on any system.
///
/// Throws  Error{io} when the file cannot be read; Error{source_rejected} naming the line for
///         anything else in it, for two names of one label, and for a file without names;
///         Error{limit_exceeded} for more labels than LabelNames holds
/// Memory  below 128 MiB; that of the text is at most 4 MiB
LabelNames read_label_names(const std::string& path);

}  // namespace octavo
