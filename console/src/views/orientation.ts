// How a picture is turned or mirrored before it is shown: a camera may hang upside down. Pure.

// Columns and rows are exchanged first, then either is reversed.
export interface Orientation {
  swap: boolean;
  reverseX: boolean;
  reverseY: boolean;
}

const turn = (swap: boolean, reverseX: boolean, reverseY: boolean): Orientation => ({ swap, reverseX, reverseY });

export const orientations: Record<string, Orientation> = {
  'not turned': turn(false, false, false),
  '90° to the right': turn(true, true, false),
  '180°': turn(false, true, true),
  '90° to the left': turn(true, false, true),
  mirrored: turn(false, true, false),
  '90° and mirrored': turn(true, false, false),
};

export interface Area {
  width: number;
  height: number;
}

export function turnedSize({ width, height }: Area, { swap }: Orientation): Area {
  return swap ? { width: height, height: width } : { width, height };
}

// For CanvasRenderingContext2D.setTransform: a, b, c, d, e, f.
export function matrixOf(orientation: Orientation, picture: Area): [number, number, number, number, number, number] {
  const { swap, reverseX, reverseY } = orientation;
  const { width, height } = turnedSize(picture, orientation);
  const [x, y] = [reverseX ? -1 : 1, reverseY ? -1 : 1];
  const [e, f] = [reverseX ? width : 0, reverseY ? height : 0];
  return swap ? [0, y, x, 0, e, f] : [x, 0, 0, y, e, f];
}

// The pixel of the picture that is shown at a place.
export function pixelAt(orientation: Orientation, picture: Area, x: number, y: number): [number, number] {
  const { width, height } = turnedSize(picture, orientation);
  const column = orientation.reverseX ? width - 1 - x : x;
  const row = orientation.reverseY ? height - 1 - y : y;
  return orientation.swap ? [row, column] : [column, row];
}
