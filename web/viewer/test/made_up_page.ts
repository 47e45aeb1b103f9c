// The page over a made-up volume: for tests of the page itself, without a file or a reader.
import { MadeUpVolume } from "./made_up_volume.js";
import { App } from "../src/ui/app.js";
import { startTheme } from "../src/ui/theme.js";

startTheme();
const app = new App(async (source) => {
  const name = typeof source === "string" ? source.split("/").at(-1)! : source.name;
  return new MadeUpVolume({
    name,
    kind: name.includes("labels") ? "labels" : "grey",
    size: name.includes("large") ? [200, 240, 160] : [96, 112, 80],
  });
});
(globalThis as { octavo?: App }).octavo = app;
void app.start(location.search);
