/** Files of the site: all are packed with gzip, and unpacked here unless the web server has done so. */

const ROOT = new URL(".", document.baseURI).href;

export async function loadBytes(path: string): Promise<Uint8Array<ArrayBuffer>> {
  const answer = await fetch(`${ROOT}${path}.gz`);
  if (!answer.ok) throw new Error(`the site lacks the file ${path}: ${answer.status}`);
  return unpacked(new Uint8Array(await answer.arrayBuffer()));
}

export async function loadJson<T>(path: string): Promise<T> {
  return JSON.parse(new TextDecoder().decode(await loadBytes(path))) as T;
}

/** What a gzip file holds; bytes that are no gzip file come back as they are. */
export async function unpacked(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
