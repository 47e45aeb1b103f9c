"""A CT scan to the surface of its largest bone, for a printer.

usage: skull_to_stl.py SCAN.8vo SKULL.stl [MM]

MM  how far the surface may lie from the full one; 0.3 where it is not given.
"""

import sys

import octavo


def main(scan, stl, mm="0.3"):
    with octavo.open(scan) as head:
        bone = head.threshold(tissue="bone").components(keep_largest=1, connectivity=26)
        facts = bone.save_surface(stl, max_deviation_mm=float(mm), overwrite=True)
        row, = bone.measure(of=head)
    print(f"{stl}: {facts['triangles']:,} of {facts['full_triangles']:,} triangles, "
          f"{facts['volume_mm3'] / 1000:.1f} cm3, closed: {facts['closed']}")
    print(f"bone: {row['voxels']:,} voxels, mean {row['mean']:.0f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
