// The page: a viewer over `@octavo/reader`.
import { open } from "@octavo/reader";
import { OctavoVolume, asFailure } from "./reader/octavo_volume.js";
import { App } from "./ui/app.js";
import { startTheme } from "./ui/theme.js";

startTheme();
const app = new App(async (source, onSlow) => {
  try {
    return new OctavoVolume(await open(source, { onSlow }));
  } catch (error) {
    throw asFailure(error);
  }
});
// For scripts that drive the page, and for tests.
(globalThis as { octavo?: App }).octavo = app;
void app.start(location.search);
