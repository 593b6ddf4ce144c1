import assert from 'node:assert/strict';
import { test } from 'node:test';
import { structOf } from '../codec/catalogue';
import type { Elements } from '../codec/views';
import { eachEcho, farthestEcho, pointType } from './echoes';

type Kind = 'LadarData' | 'Scan2dData';

function pointsOf(struct: Kind, points: object[], little: boolean): Elements {
  const body = structOf(struct).encode({ points } as never, little);
  return structOf(struct).decode(body, little, { elements: true }).points as Elements;
}

function echoes(struct: Kind, points: object[], little: boolean, kind?: number): number[][] {
  const found: number[][] = [];
  const take = (x: number, y: number, type: number) => found.push([Math.round(x) + 0, Math.round(y) + 0, type]);
  eachEcho(pointsOf(struct, points, little), take, kind);
  return found;
}

const farthest = (struct: Kind, points: object[], little: boolean) => farthestEcho(pointsOf(struct, points, little));

for (const little of [true, false]) {
  test(`points of a scanner and of a scan, ${little ? 'little' : 'big'} endian`, () => {
    const ladar = [
      { angle: 0, distance: 1000, type: 0, intensity: 0 },
      { angle: Math.PI / 2, distance: 500, type: 0x80, intensity: 0 },
      { angle: 0, distance: 7, type: 0x10, intensity: 0 },
    ];
    assert.deepEqual(echoes('LadarData', ladar, little), [
      [1000, 0, 0],
      [0, 500, 0x80],
    ]);
    assert.deepEqual(echoes('LadarData', ladar, little, pointType.invalid), [[7, 0, 0x10]]);
    assert.equal(farthest('LadarData', ladar, little), 1000);
    const scan = [
      { x: 5, y: -6, z: 0, type: 3, segment: 0, intensity: 0 },
      { x: 1, y: 1, z: 0, type: 0x20, segment: 0, intensity: 0 },
    ];
    assert.deepEqual(echoes('Scan2dData', scan, little), [[5, -6, 3]]);
    assert.equal(farthest('Scan2dData', scan, little), Math.sqrt(61));
    assert.equal(farthest('LadarData', [], little), 0);
  });
}
