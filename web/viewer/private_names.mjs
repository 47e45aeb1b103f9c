// Names that private members alone have among all that is bundled: nobody outside asks for them,
// so that they can be written short.
import { readFile, readdir } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import ts from "typescript";

const isPrivate = (node) =>
  node.modifiers?.some(({ kind }) => kind === ts.SyntaxKind.PrivateKeyword) === true;

/** Whether something is asked for by the name of a node, as `one.name`. */
function isMember(node) {
  if (ts.isParameter(node)) return node.modifiers !== undefined;
  return ts.isClassElement(node) || ts.isTypeElement(node) || ts.isEnumMember(node) ||
    ts.isObjectLiteralElement(node);
}

function collect(text, privates, others) {
  const visit = (node) => {
    if (isMember(node) && node.name) (isPrivate(node) ? privates : others).add(node.name.text);
    ts.forEachChild(node, visit);
  };
  visit(ts.createSourceFile("", text, ts.ScriptTarget.ES2022));
}

/** A pattern of the names that only private members of the sources in `folders` have. */
export async function privateNames(folders) {
  const [privates, others] = [new Set(), new Set(["constructor"])];
  // Browsers bring names of their own.
  const library = dirname(createRequire(import.meta.url).resolve("typescript"));
  for (const folder of [library, ...folders]) {
    const isWanted = folder === library ? /^lib\.(dom|es).*\.d\.ts$/ : /\.ts$/;
    for (const name of await readdir(folder, { recursive: true })) {
      if (!isWanted.test(name)) continue;
      collect(await readFile(join(folder, name), "utf8"), privates, others);
    }
  }
  return new RegExp(`^(${[...privates].filter((name) => !others.has(name)).join("|")})$`);
}
