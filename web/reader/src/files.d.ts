declare module "*.8vo" {
  const bytes: Uint8Array;
  export default bytes;
}
