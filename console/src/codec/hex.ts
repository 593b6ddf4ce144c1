// Bytes as people write them. Pure.

const bytesARow = 8; // as many as fit into a tile

// Rows like "0008  41 42 43  ABC".
export function hexDump(bytes: Uint8Array): string {
  const rows: string[] = [];
  for (let at = 0; at < bytes.length; at += bytesARow) {
    const row = [...bytes.subarray(at, at + bytesARow)];
    const digits = row.map((byte) => byte.toString(16).padStart(2, '0')).join(' ');
    const text = row.map((byte) => (byte >= 0x20 && byte < 0x7f ? String.fromCharCode(byte) : '.')).join('');
    rows.push(`${at.toString(16).padStart(4, '0')}  ${digits.padEnd(3 * bytesARow - 1)}  ${text}`);
  }
  return rows.join('\n');
}

// "01 02ff": throws a sentence when it is none.
export function bytesOfHex(text: string): Uint8Array<ArrayBuffer> {
  const digits = text.replace(/[\s,:]+/g, '');
  if (!/^([0-9a-f]{2})*$/i.test(digits)) throw new Error(`“${text}” is not a list of bytes, of two hex digits each`);
  return Uint8Array.from(digits.match(/../g) ?? [], (byte) => Number.parseInt(byte, 16));
}
