// A static host for tests: answers ranges, writes down what it is asked, and can be made to fail.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";

const types = {
  ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript",
  ".css": "text/css", ".wasm": "application/wasm", ".json": "application/json",
};

/**
 * folders  what stands below a path: {"/golden": "tests/golden/v1"}
 * The result has `files`, a Map of paths to bytes that go before folders; `log`, one entry
 * {method, path, range, status, bytes} per request; `headers`, sent with every answer; and
 * `misbehave(request, response, entry)`, which may answer in place of the server and then
 * returns true.
 */
export async function startServer(folders = {}) {
  const host = {
    files: new Map(), log: [], headers: {}, misbehave: null, ignoresRanges: false,
    requestsOf: (path) => host.log.filter((entry) => entry.path === path),
  };
  const server = createServer((request, response) => {
    answer(host, folders, request, response).catch((error) => {
      response.destroy(error);
    });
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  host.url = `http://127.0.0.1:${server.address().port}`;
  host.close = () => new Promise((resolve) => {
    server.closeAllConnections();
    server.close(resolve);
  });
  return host;
}

/** Begins to answer with the range of `bytes` that is asked for, and gives what is to be sent. */
export function beginRange(request, response, bytes) {
  const [first, last] = /=(\d+)-(\d+)$/.exec(request.headers.range).slice(1).map(Number);
  const part = Buffer.from(bytes.subarray(first, last + 1));
  response.writeHead(206, { "Content-Length": part.length,
    "Content-Range": `bytes ${first}-${first + part.length - 1}/${bytes.length}` });
  return part;
}

async function bytesOf(host, folders, path) {
  if (host.files.has(path)) return host.files.get(path);
  for (const [prefix, folder] of Object.entries(folders)) {
    if (!path.startsWith(prefix)) continue;
    const name = normalize(join(folder, path.slice(prefix.length)));
    if (!name.startsWith(normalize(folder))) return null;
    return readFile(name).catch(() => null);
  }
  return null;
}

async function answer(host, folders, request, response) {
  const path = decodeURIComponent(new URL(request.url, "http://host").pathname);
  const range = request.headers.range ?? "";
  const entry = { method: request.method, path, range, status: 0, bytes: 0,
    headers: request.headers };
  host.log.push(entry);
  for (const [name, value] of Object.entries(host.headers)) response.setHeader(name, value);
  if (host.misbehave && await host.misbehave(request, response, entry)) return;
  const bytes = await bytesOf(host, folders, path);
  const send = (status, body, headers = {}) => {
    entry.status = status;
    entry.bytes = body.length;
    response.writeHead(status, { "Content-Length": body.length, ...headers });
    response.end(request.method === "HEAD" ? undefined : body);
  };
  if (request.method !== "GET" && request.method !== "HEAD") return send(405, "");
  if (bytes === null) return send(404, "not found");
  const type = { "Content-Type": types[extname(path)] ?? "application/octet-stream" };
  const asked = /^bytes=(\d+)-(\d+)$/.exec(range);
  if (!asked || host.ignoresRanges) return send(200, bytes, type);
  const first = Number(asked[1]);
  if (first >= bytes.length) {
    return send(416, "", { "Content-Range": `bytes */${bytes.length}` });
  }
  const last = Math.min(Number(asked[2]), bytes.length - 1);
  send(206, bytes.subarray(first, last + 1),
    { ...type, "Content-Range": `bytes ${first}-${last}/${bytes.length}` });
}
