// Labels as the 3-D view keeps them: numbers of 16 bits, in the order in which labels are met, so
// that any two labels have colors of their own however far apart they are.
import { type Voxels } from "../reader/volume.js";

/** Colors stand in a texture of so many rows and columns. */
export const LABEL_COLORS_SIDE = 256;
const MOST = LABEL_COLORS_SIDE ** 2;

export class LabelIndex {
  private readonly numbers = new Map<number, number>([[0, 0]]);
  private readonly met: number[] = [0];

  /** The labels that were met; the first is the background, 0. */
  get labels(): readonly number[] {
    return this.met;
  }

  /** Labels that are met once there is no number left share those of others. */
  numberOf(label: number): number {
    const known = this.numbers.get(label);
    if (known !== undefined) return known;
    if (this.met.length === MOST) return 1 + (Math.abs(label) % (MOST - 1));
    this.numbers.set(label, this.met.length);
    return this.met.push(label) - 1;
  }

  numbered(voxels: Voxels): Uint16Array {
    const numbers = new Uint16Array(voxels.length);
    let last = 0;
    let number = 0;
    for (let i = 0; i < voxels.length; ++i) {
      if (voxels[i] !== last) {
        last = voxels[i]!;
        number = this.numberOf(last);
      }
      numbers[i] = number;
    }
    return numbers;
  }

  /** Four bytes for each number: the color of its label, as far as labels were met. */
  table(rgbaOf: (label: number) => readonly [number, number, number, number]): Uint8Array {
    const table = new Uint8Array(4 * MOST);
    for (let n = 1; n < this.met.length; ++n) table.set(rgbaOf(this.met[n]!), 4 * n);
    return table;
  }
}
