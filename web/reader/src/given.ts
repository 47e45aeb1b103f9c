// What callers choose. Programs without types may give anything.
import { OctavoError } from "./errors.js";

/** A number from 0 on, or the usual one. Throws invalid_argument for anything else. */
export function countOr(usual: number, given: unknown, what: string): number {
  const count = given ?? usual;
  if (typeof count === "number" && count >= 0) return count;
  throw new OctavoError("invalid_argument", `${what} is ${String(given)}, no number from 0 on`);
}

/** Throws invalid_argument for what is there and no AbortSignal: those of other frames are one. */
export function requireSignal(given: unknown): void {
  if (given === undefined || given === null) return;
  const signal = given as Partial<AbortSignal>;
  if (typeof signal.aborted === "boolean" && typeof signal.addEventListener === "function") return;
  throw new OctavoError("invalid_argument", `signal is ${String(given)}, no AbortSignal`);
}

/** Throws invalid_argument for what is there and no address or path. */
export function requirePlace(given: unknown, what: string): void {
  if (given === undefined || typeof given === "string" || given instanceof URL) return;
  throw new OctavoError(
    "invalid_argument", `${what} is ${String(given)}, no address and no path`);
}

/** An address that counts from another. Throws invalid_argument where it is none. */
export function addressAt(place: string | URL, base: string | undefined): URL {
  try {
    return new URL(place, base);
  } catch (cause) {
    throw new OctavoError("invalid_argument", `${String(place)}: no address`, { cause });
  }
}
