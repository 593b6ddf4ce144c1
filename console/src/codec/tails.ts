// Lengths of the tails of messages: what tail_sizes() of their structs computes in C++. A negative length is refused.
import type { Structs } from './messages';

type TailSizes = { [K in keyof Structs]?: (value: Structs[K]) => number[] };

const jpeg = 41; // camera_mode::kJpeg

const sizes: TailSizes = {
  CameraData: ({ mode, colorFilterId, width, height, depth }) => [
    mode === jpeg ? colorFilterId : Math.trunc((width * height * depth) / 8),
  ],
  GridMapData: ({ gridNumX, gridNumY }) => [gridNumX < 0 || gridNumY < 0 ? -1 : gridNumX * gridNumY],
  Scan3dData: ({ compressed, pointNum }) => (compressed !== 0 ? [0, compressed] : [pointNum, 0]),
  Scan3dRangeImageData: ({ scanNum, scanPointNum }) => [scanNum < 0 || scanPointNum < 0 ? -1 : scanNum * scanPointNum],
};

export const tailSizes = sizes as Readonly<Record<string, ((value: object) => number[]) | undefined>>;
