// Files with one fault each: flipped bits, bytes of another value, ends cut off, parts swapped.

/** A generator of the same numbers every time. */
function generator(seed) {
  let state = seed;
  return (below) => {
    state = (state * 48271) % 2147483647;
    return state % below;
  };
}

/** `count` damaged forms of files [[name, bytes]]. */
export function damagedFiles(files, count) {
  const random = generator(20011);
  return Array.from({ length: count }, (_, i) => {
    const [name, sound] = files[i % files.length];
    const bytes = sound.slice();
    const at = random(bytes.length);
    switch (i % 5) {
      case 0:
        bytes[at] ^= 1 << random(8);
        return { name: `${name} bit at ${at}`, bytes };
      case 1:
        bytes[at] = (bytes[at] + 1 + random(255)) & 255;
        return { name: `${name} byte at ${at}`, bytes };
      case 2:
        return { name: `${name} cut at ${at}`, bytes: bytes.slice(0, at) };
      case 3:
        bytes.copyWithin(at, random(bytes.length), random(bytes.length));
        bytes[at] ^= 0x55;
        return { name: `${name} copied to ${at}`, bytes };
      default:
        // The header: every number in it comes from the file.
        bytes[random(512)] ^= 1 << random(8);
        return { name: `${name} header`, bytes };
    }
  });
}
