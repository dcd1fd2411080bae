import { dressed } from "../views/dressed.ts";
import { Replay } from "./app.ts";

for (const replay of document.querySelectorAll("hawk-replay")) {
  if (!(replay instanceof Replay)) continue;
  replay.every = frames;
  dressed("archive-replay-mark", () => replay.drawAgain());
  void replay.begin();
}

/** Calls with the seconds since the call before, at each frame of the browser, until the answer is called. */
function frames(draw: (passed: number) => void): () => void {
  let before = performance.now();
  let asked = requestAnimationFrame(function next(now) {
    draw(Math.min(1, Math.max(0, now - before) / 1000));
    before = now;
    asked = requestAnimationFrame(next);
  });
  return () => cancelAnimationFrame(asked);
}
