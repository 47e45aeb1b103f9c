// A plan as text, for those who make parts elsewhere: lines of JSON.
//
//   line 1   an object: what the first group decides, members by name
//   others   ["NAME"] for each name that the source is opened by, then
//            ["PATH",LENGTH,TIME] for each file of the source
//
// Names and paths are bytes: those that are no UTF-8 stand as plan_word has them.
//
// Invariants
//   A plan has one text, and a text that was changed in any byte is no plan.
#pragma once

#include <string>
#include <string_view>

#include "octavo/dist/build_plan.h"

namespace octavo {

inline constexpr int kPlanVersion = 1;
inline constexpr int kBandedPlanVersion = 2;  ///< of plans whose parts share groups

/// Any bytes as UTF-8: each that belongs to no character, and 0, is U+0000 and two digits.
std::string plan_word(std::string_view bytes);

/// The bytes of a plan_word.
/// Throws Error{corrupt}
std::string bytes_of_word(std::string_view word);

/// The text, each line with its end.
std::string plan_text(const BuildPlan& plan);

/// The plan of a text.
/// Throws  Error{corrupt} for what is no plan or was changed, Error{unsupported_version},
///         Error{limit_exceeded}; Error{invalid_argument} for a plan whose groups this program
///         would make otherwise
BuildPlan parse_plan(std::string_view text);

}  // namespace octavo
