// Whether the server of a file keeps up with what is asked of it, of all requests together.
import type { SlowServer } from "../api.js";

/** A request under way. */
export interface WatchedRequest {
  readonly startedAt: number;
  readonly arrivedBytes: number;
  readonly wantedBytes: number;
  askAgain(): void;
}

/** Looked back so far; what is younger is not slow yet. */
const backMs = 5000;
/** Below this a server is slow. */
const enoughBytesPerMs = 100;
const lookEveryMs = 1000;

export class SlowWatch {
  private timer: ReturnType<typeof setInterval> | undefined;
  private marks: { readonly at: number; readonly bytes: number }[] = [];
  private bytes = 0;
  private isSlow = false;

  constructor(
    private readonly running: ReadonlySet<WatchedRequest>,
    private readonly tell: (slow: SlowServer | null) => void) {}

  arrived(count: number): void {
    this.bytes += count;
  }

  /** After a request began or ended. */
  changed(): void {
    if (this.running.size > 0) {
      this.timer ??= setInterval(() => this.look(), lookEveryMs);
      return;
    }
    clearInterval(this.timer);
    this.timer = undefined;
    this.marks = [];
    this.say(null);
  }

  private look(): void {
    const { marks, bytes } = this;
    const now = performance.now();
    const requests = [...this.running];
    const sum = (of: (one: WatchedRequest) => number) => requests.reduce((n, r) => n + of(r), 0);
    const startedAt = Math.min(...requests.map((one) => one.startedAt));
    marks.push({ at: now, bytes });
    while (marks.length > 1 && marks[1]!.at <= now - backMs) marks.shift();
    const past = marks[0]!;
    const isSlow = now - startedAt >= backMs &&
      bytes - past.bytes < enoughBytesPerMs * (now - past.at);
    this.say(isSlow ? {
      arrivedBytes: sum((one) => one.arrivedBytes),
      wantedBytes: sum((one) => one.wantedBytes),
      seconds: Math.floor((now - startedAt) / 1000),
      askAgain: () => requests.forEach((one) => one.askAgain()),
    } : null);
  }

  private say(slow: SlowServer | null): void {
    if (slow || this.isSlow) this.tell(slow);
    this.isSlow = slow !== null;
  }
}
