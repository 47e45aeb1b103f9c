#include "support/source_folder.h"

namespace octavo::testing {

std::string source_folder() { return OCTAVO_SOURCE_DIR; }

}  // namespace octavo::testing
