// PNG pictures as Chromium and the program write them: 8 bits of grey, color, or color and alpha.
import { inflateSync } from "node:zlib";

const channelsOf = { 0: 1, 2: 3, 6: 4 };

/** Width, height, red, green and blue of each pixel, the first of these alone, and whether any pixel
 *  is not grey. */
export function pngPixels(png) {
  let [width, height, channels] = [0, 0, 0];
  const data = [];
  for (let at = 8; at < png.length;) {
    const length = png.readUInt32BE(at);
    const name = png.toString("latin1", at + 4, at + 8);
    const body = png.subarray(at + 8, at + 8 + length);
    if (name === "IHDR") {
      width = body.readUInt32BE(0);
      height = body.readUInt32BE(4);
      channels = channelsOf[body[9]];
      if (body[8] !== 8 || !channels || body[12] !== 0) throw new Error("a PNG of another kind");
    }
    if (name === "IDAT") data.push(body);
    at += 12 + length;
  }
  const rows = unfiltered(inflateSync(Buffer.concat(data)), width * channels, height, channels);
  const grey = new Uint8Array(width * height);
  const rgb = new Uint8Array(3 * width * height);
  let isColored = false;
  for (let i = 0; i < grey.length; ++i) {
    const pixel = rows.subarray(i * channels, i * channels + 3);
    grey[i] = pixel[0];
    for (let c = 0; c < 3; ++c) rgb[3 * i + c] = pixel[channels > 1 ? c : 0];
    if (channels > 1 && (pixel[0] !== pixel[1] || pixel[0] !== pixel[2])) isColored = true;
  }
  return { width, height, grey, rgb, isColored };
}

function unfiltered(bytes, rowLength, height, step) {
  const out = new Uint8Array(rowLength * height);
  for (let y = 0; y < height; ++y) {
    const filter = bytes[y * (rowLength + 1)];
    const row = bytes.subarray(y * (rowLength + 1) + 1, (y + 1) * (rowLength + 1));
    for (let x = 0; x < rowLength; ++x) {
      const i = y * rowLength + x;
      const left = x >= step ? out[i - step] : 0;
      const up = y > 0 ? out[i - rowLength] : 0;
      const corner = x >= step && y > 0 ? out[i - rowLength - step] : 0;
      out[i] = row[x] + [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
    }
  }
  return out;
}

function paeth(left, up, corner) {
  const guess = left + up - corner;
  const [a, b, c] = [left, up, corner].map((v) => Math.abs(guess - v));
  return a <= b && a <= c ? left : b <= c ? up : corner;
}
