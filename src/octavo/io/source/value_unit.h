// Units of measured values: as headers of other programs spell them, the codes that files hold, and
// the words that people read.
//
//     HU <-> [hnsf'U]     1/cm -> cm-1     suv <-> {suv}
//
// Source  The Unified Code for Units of Measure (UCUM), case-sensitive codes, version 2.1
#pragma once

#include <string>
#include <string_view>

namespace octavo {

/// `unit` where it is one that is known ("HU", "mg/ml", "mm2/s", ...; upper case counts as lower
/// case), else empty: such a field takes any text, and text of people stays out of a file.
std::string known_value_unit(const std::string& unit);

/// The code of UCUM for a unit that is known; one that UCUM has no code for as an annotation, in
/// braces. Empty for none.
std::string unit_code(std::string_view unit);

/// What is shown for a code: "HU" for [hnsf'U], the words of an annotation, else the code itself.
std::string shown_unit(std::string_view code);

}  // namespace octavo
