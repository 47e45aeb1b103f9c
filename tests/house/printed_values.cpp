// Values that gdb_printers_test.py has printed; built without optimization, so that all are there.
#include "octavo/octree/mask_tree.h"
#include "octavo/octree/o_code.h"

octavo::Index3 place = {1, 2, 3};
octavo::Size3 size = {64, 32, 16};
octavo::Box box = {{0, 1, 2}, {64, 32, 16}};
octavo::OCode cube = {1, 065};  // octal: the cube of side 2 at (4, 2, 6)
octavo::MaskCube mask_cube = {0b11, 0b1100, 7};

int main() {
  const octavo::MaskTree tree = octavo::box_mask(size, box);
  return place.x + cube.level + static_cast<int>(mask_cube.first) == 9 && !tree.is_empty() ? 0 : 1;
}
