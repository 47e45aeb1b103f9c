// Manual pages in roff: one for the program, one for each verb.
#pragma once

#include <string>

#include "common/option_tree.h"

namespace octavo::cli {

/// octavo(1) or octavo-mpi(1): what the program is, its verbs, and the options that all of them
/// have.
std::string program_page(const ProgramEntry& program, const std::string& version);

/// octavo-VERB(1): PROGRAM-VERB.
std::string verb_page(const ProgramEntry& program, const VerbEntry& verb,
                      const std::string& version);

}  // namespace octavo::cli
