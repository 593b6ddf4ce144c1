// An archive of files (ustar).

export interface ArchivedFile {
  path: string; // at most 100 bytes
  content: string | Uint8Array;
}

const block = 512;

export function tar(files: ArchivedFile[], seconds: number): Uint8Array<ArrayBuffer> {
  const parts = files.flatMap(({ path, content }) => {
    const bytes = typeof content === 'string' ? new TextEncoder().encode(content) : content;
    return [header(path, bytes.length, seconds), bytes, new Uint8Array(-bytes.length & (block - 1))];
  });
  parts.push(new Uint8Array(2 * block));
  const archive = new Uint8Array(parts.reduce((size, part) => size + part.length, 0));
  let at = 0;
  for (const part of parts) {
    archive.set(part, at);
    at += part.length;
  }
  return archive;
}

function header(path: string, size: number, seconds: number): Uint8Array {
  const bytes = new Uint8Array(block);
  const put = (offset: number, text: string) => bytes.set(new TextEncoder().encode(text), offset);
  const octal = (offset: number, digits: number, value: number) => put(offset, value.toString(8).padStart(digits, '0'));
  put(0, path);
  octal(100, 7, 0o644);
  octal(108, 7, 0);
  octal(116, 7, 0);
  octal(124, 11, size);
  octal(136, 11, seconds);
  put(148, ' '.repeat(8)); // the sum is made with blanks in its place
  put(156, '0');
  put(257, 'ustar\0' + '00');
  const sum = bytes.reduce((total, byte) => total + byte, 0);
  put(148, `${sum.toString(8).padStart(6, '0')}\0 `);
  return bytes;
}
