"""The pores of a micro-CT scan: how many there are, how large, how much of the specimen.

usage: pore_statistics.py SCAN.8vo HIGHEST [TABLE.csv]

Pores are what lies at or below HIGHEST, in real values, and does not reach the outside.
"""

import csv
import sys

import octavo


def main(scan, highest, table=None):
    with octavo.open(scan) as volume:
        material = ~volume.threshold(high=float(highest))
        pores = material.fill_holes() - material
        found = pores.components(connectivity=26)
        rows = found.measure(of=volume, percentiles=())
    if not rows:
        print("no pore lies inside")
        return
    share = pores.voxels / (pores.voxels + material.voxels)
    sizes = sorted((row["voxels"] for row in rows), reverse=True)
    print(f"{len(rows):,} pores, {100 * share:.2f} % of the specimen; the largest has "
          f"{sizes[0]:,} voxels, half of them at most {sizes[len(sizes) // 2]:,}")
    if table:
        with open(table, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main(*sys.argv[1:])
