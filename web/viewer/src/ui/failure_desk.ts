// What becomes of failures: a sentence, and a button where something can be done.
import { ReadFailure } from "../reader/volume.js";
import { type Messages } from "./messages.js";
import { type Session } from "./session.js";

function sentence(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

export class FailureDesk {
  /** Of which session the last failure to read was. */
  private failed: Session | undefined;
  private said = "";

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
  couldNotRead(error: Error, session: Session, reopen: () => void): void {
    this.failed = session;
    this.said = error.message;
    const isReplaced = error instanceof ReadFailure && error.remedy === "reopen";
    this.messages.show(
      error.message,
      "error",
      isReplaced
        ? { text: "Open the new file", act: reopen }
        : { text: "Try again", act: () => session.cells.retry() },
    );
  }

  /** What a session that is closed could not read is nobody's concern any more. */
  forget(session: Session | undefined): void {
    if (session && session === this.failed) this.messages.clear(this.said);
  }
}
