// The view of each class of components; of those without one, all fields.

import type { ComponentType } from 'preact';
import { classId } from '../codec/catalogue';
import { CameraView } from './camera_view';
import { ChassisView } from './chassis_view';
import { FieldsView } from './fields_view';
import { GyroView } from './gyro_view';
import { ScanView } from './scan_view';
import type { ViewProperties } from './view';

const views = new Map<number | undefined, ComponentType<ViewProperties>>([
  [classId('Camera'), CameraView],
  [classId('Chassis'), ChassisView],
  [classId('Gyro'), GyroView],
  [classId('Ladar'), ScanView],
  [classId('Scan2d'), ScanView],
]);

export function viewFor(id: number): ComponentType<ViewProperties> {
  return views.get(id) ?? FieldsView;
}
