// Units of measured values: the codes that files hold, and the words that people read.
//
//     HU <-> [hnsf'U]     1/cm -> cm-1     suv <-> {suv}
//
// Source  The Unified Code for Units of Measure (UCUM), case-sensitive codes, version 2.1
#pragma once

#include <string>
#include <string_view>

namespace octavo {

/// The code of UCUM for a unit that io/source/value_unit.h knows; one that UCUM has no code for as
/// an annotation, in braces. Empty for none.
std::string unit_code(std::string_view unit);

/// What is shown for a code: "HU" for [hnsf'U], the words of an annotation, else the code itself.
std::string shown_unit(std::string_view code);

}  // namespace octavo
