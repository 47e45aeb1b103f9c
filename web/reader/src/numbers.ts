// Numbers that callers choose. Programs without types may give anything.
import { OctavoError } from "./errors.js";

/** A number from 0 on, or the usual one. Throws invalid_argument for anything else. */
export function countOr(usual: number, given: unknown, what: string): number {
  const count = given ?? usual;
  if (typeof count === "number" && count >= 0) return count;
  throw new OctavoError("invalid_argument", `${what} is ${String(given)}, no number from 0 on`);
}
