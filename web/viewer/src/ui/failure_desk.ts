// What becomes of failures: a sentence, and a button where something can be done.
import { ReadFailure, type Volume } from "../reader/volume.js";
import { type Messages } from "./messages.js";
import { type Session } from "./session.js";

function sentence(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

export class FailureDesk {
  constructor(private readonly messages: Messages) {}

  /** again  undefined where another try finds the same. */
  couldNotOpen(error: unknown, again: (() => void) | undefined): void {
    const canRetry = again && error instanceof ReadFailure && error.remedy !== "none";
    this.messages.show(
      sentence(error),
      "error",
      canRetry ? { text: "Try again", act: again } : undefined,
    );
  }

  /** What is shown stays; nothing of another file is ever shown beside it. */
  couldNotRead(error: Error, session: Session, reopened: (volume: Volume) => void): void {
    const remedy = error instanceof ReadFailure ? error.remedy : "none";
    if (remedy === "reopen") {
      this.messages.show(error.message, "error", {
        text: "Open the new file",
        act: () => void this.reopen(session, reopened),
      });
      return;
    }
    this.messages.show(error.message, "error", {
      text: "Try again",
      act: () => session.cells.retry(),
    });
  }

  private async reopen(session: Session, reopened: (volume: Volume) => void): Promise<void> {
    try {
      reopened(await session.volume.reopen());
    } catch (error) {
      this.couldNotOpen(error, () => void this.reopen(session, reopened));
    }
  }
}
