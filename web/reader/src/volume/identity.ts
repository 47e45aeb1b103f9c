// Whether the file at the source is still the one that was opened.
import { failureOf, OctavoError } from "../errors.js";
import type { FileBytes, PlacedBytes } from "../store/file_bytes.js";

/** True where bytes were not those that the file was made of: damaged, or of another file. */
export function isDamage(cause: unknown): boolean {
  return cause instanceof OctavoError && (cause.kind === "corrupt" || cause.kind === "truncated");
}

/** Header and trailer: those of two files are never alike. */
export class Identity {
  private proof: Promise<void> | null = null;

  constructor(private readonly bytes: FileBytes, private readonly ends: readonly PlacedBytes[]) {}

  /** Fetches both anew. Throws an OctavoError of kind replaced where they are others. */
  prove(): Promise<void> {
    // Many may ask at a time; a later one asks the server again.
    this.proof ??= this.compare().finally(() => {
      this.proof = null;
    });
    return this.proof;
  }

  private async compare(): Promise<void> {
    const replaced = new OctavoError("replaced",
      `${this.bytes.name}: another file stands there now; open it again`);
    const ranges = this.ends.map(({ offset, bytes }) => ({ offset, length: bytes.length }));
    let now: PlacedBytes[];
    try {
      now = await this.bytes.bytesOf(ranges, { fresh: true, priority: Infinity });
    } catch (cause) {
      if (isDamage(cause)) throw replaced;
      throw failureOf(cause, this.bytes.name);
    }
    const isSame = now.every((part, i) =>
      part.bytes.every((byte, at) => byte === this.ends[i]!.bytes[at]));
    if (!isSame) throw replaced;
  }
}
