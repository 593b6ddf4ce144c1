// What the npm package rack-codec contains (codec/pack.mjs).
export * from './codec/catalogue';
export { hexOf, toJson } from './codec/json';
export type * from './codec/messages';
export { bytesOfHex, CodecError, type DecodeOptions, type Fields, Struct } from './codec/struct';
export { shownText } from './codec/text';
export type { Elements } from './codec/views';
export {
  addressOf,
  addressText,
  type Fields as AddressFields,
  fieldsOf,
  originalWidths,
  type Widths,
} from './tims/address';
export { decodeHeader, encodeMessage as encodeWithHeader, flags, type Header, headerSize, types } from './tims/header';
