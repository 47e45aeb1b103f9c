#include "support/volume_readers.h"

namespace octavo::testing {

const VolumeReader* itk_reader() { return nullptr; }

}  // namespace octavo::testing
