// plan -- VERB ...: volumes that a verb computes, as words.
#pragma once

#include <string>
#include <vector>

#include "common/context.h"
#include "octavo/tasks/parts/computed_planes.h"

namespace octavo::cli {

/// Takes what stands behind `plan ... --` from the words of a command line into the context.
/// verb  that is on it
std::vector<std::string> without_planned_words(std::vector<std::string> words,
                                               const std::string& verb, Context& context);

/// What `VERB ...` computes: threshold, condense, transform, combine, or components with numbers.
/// Throws Error{invalid_argument} for words that are not understood, and for options that belong to
///        plan, part or join
ComputedWork parse_work(const std::vector<std::string>& words);

}  // namespace octavo::cli
