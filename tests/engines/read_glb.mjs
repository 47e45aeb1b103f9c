// Reads a GLB file by programs of others: the validator of Khronos, and glTF Transform with the
// decoder of meshoptimizer. Prints what they find, as JSON.
//
// usage: node read_glb.mjs MODULES FILE      MODULES is the folder that setup has filled
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [modules, path] = process.argv.slice(2);
const require = createRequire(`${modules}/`);
const load = (name) => import(require.resolve(name));
const { NodeIO } = await load("@gltf-transform/core");
const { EXTMeshoptCompression, KHRMeshQuantization } = await load("@gltf-transform/extensions");
const { MeshoptDecoder } = await load("meshoptimizer");
const { validateBytes } = require("gltf-validator");

const bytes = new Uint8Array(readFileSync(path));
const { issues, info } = await validateBytes(bytes);

await MeshoptDecoder.ready;
const io = new NodeIO()
  .registerExtensions([EXTMeshoptCompression, KHRMeshQuantization])
  .registerDependencies({ "meshopt.decoder": MeshoptDecoder });
const document = await io.readBinary(bytes);

const transformed = (m, [x, y, z]) =>
  [0, 1, 2].map((row) => m[row] * x + m[row + 4] * y + m[row + 8] * z + m[row + 12]);
const parts = document.getRoot().listNodes().filter((node) => node.getMesh()).map((node) => {
  const [primitive] = node.getMesh().listPrimitives();
  const array = (accessor) =>
    Array.from({ length: accessor.getCount() }, (_, i) => accessor.getElement(i, []));
  const normals = primitive.getAttribute("NORMAL");
  return {
    name: node.getName(),
    points: array(primitive.getAttribute("POSITION")).map((point) =>
      transformed(node.getWorldMatrix(), point)),
    normals: normals ? array(normals) : [],
    numbers: Array.from(primitive.getIndices().getArray()),
  };
});
console.log(JSON.stringify({ issues, triangles: info.totalTriangleCount, parts }));
