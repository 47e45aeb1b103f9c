// What the codecs need of Highway's own library, whose binary for the target is not at hand: the
// compiler's settings name the only instruction set there is.
#include <hwy/highway.h>

namespace hwy {

decltype(SupportedTargets()) SupportedTargets() { return HWY_STATIC_TARGET; }

ChosenTarget& GetChosenTarget() {
  static ChosenTarget target;
  return target;
}

}  // namespace hwy
