import assert from "node:assert/strict";
import test from "node:test";
import { type VolumeFacts } from "../src/reader/volume.js";
import { captionTop } from "../src/ui/annotations.js";

test("captions lie below the letter of a narrow panel", () => {
  const pen = {
    measureText: (text: string) => ({ width: 7 * text.length }),
  } as unknown as CanvasRenderingContext2D;
  const top = (width: number, isPlaceKnown: boolean): number =>
    captionTop(pen, width, { isPlaceKnown } as VolumeFacts, "axial z 1 / 2", "");
  assert.equal(top(400, true), 8);
  assert.equal(top(195, true), 26);
  assert.equal(top(195, false), 8);
});
