// Groups of components, in the order in which their data flow.

import { classId } from '../codec/catalogue';

const members: Record<string, string[]> = {
  Drivers: [
    'Chassis',
    'Ladar',
    'Camera',
    'Gps',
    'Gyro',
    'Compass',
    'Clock',
    'Joystick',
    'Io',
    'ServoDrive',
    'PtzDrive',
    'Vehicle',
  ],
  Perception: ['Scan2d', 'Scan3d', 'ObjRecog'],
  Navigation: ['Odometry', 'Position', 'Mcl', 'FeatureMap', 'GridMap', 'Path', 'Pilot', 'Planner'],
  Tools: [],
};

export const groups = Object.keys(members);

const groupsById = new Map<number | undefined, string>(
  Object.entries(members).flatMap(([group, names]) => names.map((name) => [classId(name), group] as const)),
);

export function groupOf(id: number): string {
  return groupsById.get(id) ?? 'Tools';
}
