// Web servers as people run them, each in a process of its own: nginx and caddy as HOSTING.md says,
// and the one of Python, which ignores ranges.
import { spawn, spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { delimiter, join } from "node:path";
import { root } from "./golden.mjs";

/** Where tests/web/setup has put them, before those of the system. */
export function findServersIn(folder) {
  const own = ["usr/sbin", "usr/bin"].map((path) => join(folder, "servers", path));
  process.env.PATH = [...own, process.env.PATH, "/usr/sbin"].join(delimiter);
}

/** Whether a server is there. */
export const hasServer = (name) => spawnSync("which", [name]).status === 0;

async function freePort() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

/** The block of a server in HOSTING.md, without what is not needed by whoever reads. */
function hostingBlock(name) {
  const text = readFileSync(join(root, "web/viewer/HOSTING.md"), "utf8");
  const block = new RegExp(`\\*\\*${name}\\*\\*\\n\\n((?: {4}.*\\n|\\n)+)`).exec(text)[1];
  // Pages of other origins read neither Content-Range nor ETag.
  return block.split("\n").filter((line) => !line.includes("Expose-Headers")).join("\n");
}

const configurations = {
  nginx: (folder, port) => {
    const file = join(folder, "nginx.conf");
    const log = join(folder, "nginx.log");
    const temporary = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"]
      .map((name) => `${name}_temp_path ${join(folder, `nginx-${name}`)};`).join("\n");
    writeFileSync(file, `daemon off; master_process off; pid ${join(folder, "nginx.pid")};
error_log ${join(folder, "nginx-errors.log")}; events {}
http { log_format plain '$request_method $uri $http_range $status'; access_log ${log} plain;
${temporary}
server { listen 127.0.0.1:${port};
${hostingBlock("nginx").replace("/srv/www", folder)}
} }
`);
    const requests = () => readFileSync(log, "utf8").trim().split("\n").map((line) => {
      const [method, path] = line.split(" ");
      return { method, path };
    });
    return { words: ["nginx", "-c", file, "-e", join(folder, "nginx-errors.log")], requests };
  },
  caddy: (folder, port) => {
    const file = join(folder, "Caddyfile");
    const log = join(folder, "caddy.log");
    const block = hostingBlock("caddy").replace("example.org", `http://127.0.0.1:${port}`)
      .replace("/srv/www", folder)
      .replace("file_server", `file_server\n log {\n output file ${log}\n format json\n }`);
    writeFileSync(file, `{\n admin off\n auto_https off\n}\n${block}\n`);
    const requests = () => readFileSync(log, "utf8").trim().split("\n").map((line) => {
      const { request } = JSON.parse(line);
      return { method: request.method, path: request.uri };
    });
    return { words: ["caddy", "run", "--config", file, "--adapter", "caddyfile"], requests };
  },
  python3: (folder, port) => ({
    words: ["python3", "-m", "http.server", "--bind", "127.0.0.1", "--directory", folder, `${port}`],
    requests: () => [],
  }),
};

export const realServers = Object.keys(configurations);

/**
 * Starts a server over a folder, in which the site stands in scans/.
 * The result has `url`, of scans/; `requests()`, those that were answered; and `close()`.
 */
export async function startRealServer(name, folder) {
  const port = await freePort();
  const { words, requests } = configurations[name](folder, port);
  const [program, ...rest] = words;
  const errors = [];
  const child = spawn(program, rest, {
    stdio: ["ignore", "ignore", "pipe"], cwd: folder,
    env: { ...process.env, HOME: folder, XDG_DATA_HOME: folder, XDG_CONFIG_HOME: folder },
  });
  child.stderr.on("data", (text) => errors.push(text));
  const ended = new Promise((resolve) => child.on("exit", resolve));
  const url = `http://127.0.0.1:${port}/scans`;
  for (let i = 0; ; ++i) {
    try {
      await fetch(`${url}/files.json`);
      break;
    } catch (cause) {
      if (i === 600 || child.exitCode !== null) {
        throw new Error(`${name} does not start: ${Buffer.concat(errors)}`, { cause });
      }
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
  }
  return {
    url, requests,
    close: async () => {
      child.kill();
      await ended;
    },
  };
}
