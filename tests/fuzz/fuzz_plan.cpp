// Plans of arbitrary text: what is read is written as it was, and says nothing that a part or a
// join would stumble over.
#include <algorithm>
#include <string>

#include "fuzz/fuzz_target.h"
#include "octavo/dist/plan_text.h"

namespace {

using namespace octavo;
using fuzz::require;

/// Slices that a part would open.
void check_excerpts(const BuildPlan& plan) {
  const SliceStack& stack = *plan.stack;
  const std::int64_t planes = stack.description.size.z;
  for (const std::int64_t first : {std::int64_t{0}, planes / 2, planes - 1}) {
    const auto [paths, outline] = excerpt_of(stack.files, first, planes);
    require(!paths.empty() && paths.size() <= plan.files.size(), "slices that are not there");
    for (const PlaneOrigin& plane : outline.planes) {
      require(plane.below + (plane.weight_above > 0 ? 1 : 0) < paths.size(),
              "a plane of a slice that is not opened");
    }
    require(!outline.tilt || outline.tilt->shift.size() == paths.size(), "other shifts");
  }
}

void check_plan(const BuildPlan& plan) {
  require(first_plane_of(plan, plan.group_count) == plan.source.size.z, "groups beyond the end");
  BrickAt before = {0, 0};
  for (std::int64_t part = 1; part <= std::min<std::int64_t>(plan.part_count, 100); ++part) {
    const BrickAt begin = begin_of(place_of(plan, part));
    require(begin > before && begin <= BrickAt{plan.group_count, 0}, "a part without bricks");
    before = begin;
  }
  if (plan.stack) check_excerpts(plan);
  BuildPlan moved = plan;
  move_files(moved, "/elsewhere");
  require(moved.files.size() == plan.files.size(), "files are lost");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::expect_error_or_success([&] {
    const BuildPlan plan = parse_plan(text);
    require(plan_text(plan) == text, "another text");
    check_plan(plan);
  });
  return 0;
}
