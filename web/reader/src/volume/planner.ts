// What has to be fetched: the index of a file in an instance of its own.
//
// Bytes tell where others stand, so a plan takes rounds: pages of the index, then models and pieces
// of bricks, then those parts of pieces that a list in others names.
import type { Box } from "../api.js";
import { type EnginePlan, EngineFile } from "../decode/engine.js";
import type { FileBytes, WaitOptions } from "../store/file_bytes.js";
import { type ByteRange, joined } from "../store/ranges.js";
import { cornersOf } from "./cells.js";

export interface NeededBytes {
  readonly ranges: ByteRange[];
  readonly isComplete: boolean;
  readonly bricks: number;
  readonly uniformBricks: number;
}

/** More than a box ever takes. */
const mostRounds = 8;

export class Planner {
  private plansUnderWay = 0;

  constructor(readonly file: EngineFile, private readonly bytes: FileBytes) {}

  /**
   * What a box needs, whether it is here or not.
   * wait  how to fetch what tells of others; null: without fetching more than pages of the index
   */
  async needed(
    box: Box, level: number, pages: WaitOptions, wait: WaitOptions | null): Promise<NeededBytes> {
    this.plansUnderWay += 1;
    try {
      await this.bringPages(box, level, pages);
      const ranges: ByteRange[] = [];
      for (let round = 1; ; ++round) {
        const plan = await this.plan(box, level);
        ranges.push(...plan.ranges);
        const isLast = plan.isComplete || round === mostRounds ||
          (wait === null && this.bytes.missing(plan.ranges).length > 0);
        if (isLast) {
          const [bricks, uniformBricks] = plan.rest as [number, number];
          return { ranges: joined(ranges, 0), isComplete: plan.isComplete, bricks, uniformBricks };
        }
        await this.bring(plan.ranges, wait ?? pages);
      }
    } finally {
      this.plansUnderWay -= 1;
      // What is parsed is kept, so the next plan names all that it needs again.
      if (this.plansUnderWay === 0) {
        await this.file.use((exports, volume) => exports.octavo_forget(volume, 0))
          .catch(() => undefined);
      }
    }
  }

  /** Pages of the index that describe the bricks of a box. */
  async bringPages(box: Box, level: number, options: WaitOptions): Promise<void> {
    const pages = await this.file.use((exports, volume, engine) =>
      engine.withBox(cornersOf(box), (place) =>
        engine.plan(exports.octavo_plan_pages(volume, place, level))));
    await this.bring(pages.ranges, options);
  }

  private async bring(ranges: readonly ByteRange[], options: WaitOptions): Promise<void> {
    for (const part of await this.bytes.bytesOf(ranges, options)) await this.file.put(part);
  }

  private plan(box: Box, level: number): Promise<EnginePlan> {
    return this.file.use((exports, volume, engine) => engine.withBox(cornersOf(box), (place) =>
      engine.plan(exports.octavo_plan(volume, place, level), 2)));
  }
}
