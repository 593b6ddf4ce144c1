// What its types accept, and what not.
import { type ChassisData, decodeStruct, encodeNamed, type LadarData } from 'rack-codec';

const scan: LadarData = decodeStruct('LadarData', new Uint8Array(24), 2);
export const nearest: number = Math.min(...scan.points.map((point) => point.distance));
export const speed: ChassisData['vx'] = 0.5;
encodeNamed('Chassis.MOVE', { vx: 200 });
// @ts-expect-error: MOVE has no such field
encodeNamed('Chassis.MOVE', { speed: 200 });
// @ts-expect-error: it is a number
encodeNamed('Chassis.MOVE', { vx: 'fast' });
