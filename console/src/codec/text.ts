// Texts of messages. Programs send UTF-8, those of the original RACK also Latin-1; the messages do not state which.
// A byte that is not part of UTF-8 becomes the lone surrogate U+DC00 + byte, so that every text can be sent back
// unchanged.

const utf8 = new TextDecoder('utf-8', { fatal: true, ignoreBOM: true });
const escaped = 0xdc00;

// Valid sequences of UTF-8, or a single byte that is not part of one.
const sequences =
  /[\xC2-\xDF][\x80-\xBF]|\xE0[\xA0-\xBF][\x80-\xBF]|[\xE1-\xEC\xEE\xEF][\x80-\xBF]{2}|\xED[\x80-\x9F][\x80-\xBF]|\xF0[\x90-\xBF][\x80-\xBF]{2}|[\xF1-\xF3][\x80-\xBF]{3}|\xF4[\x80-\x8F][\x80-\xBF]{2}|[\x80-\xFF]/g;

export function textOf(bytes: Uint8Array): string {
  try {
    return utf8.decode(bytes);
  } catch {
    let latin1 = '';
    for (const byte of bytes) latin1 += String.fromCharCode(byte);
    return latin1.replace(sequences, (sequence) =>
      sequence.length > 1
        ? utf8.decode(Uint8Array.from(sequence, (c) => c.charCodeAt(0)))
        : String.fromCharCode(escaped + sequence.charCodeAt(0)),
    );
  }
}

export function bytesOf(text: string): Uint8Array {
  const encoder = new TextEncoder();
  const parts = text.split(/([\uDC80-\uDCFF])/u).map((part, i) => {
    return i % 2 === 0 ? encoder.encode(part) : Uint8Array.of(part.charCodeAt(0) - escaped);
  });
  const bytes = new Uint8Array(parts.reduce((size, part) => size + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

// For people: bytes that are not UTF-8 are taken for Latin-1.
export function shownText(text: string): string {
  return text.replace(/[\uDC80-\uDCFF]/gu, (c) => String.fromCharCode(c.charCodeAt(0) - escaped));
}
