// The view of each class of components; of those without one, all fields.

import type { ComponentType } from 'preact';
import { classId } from '../codec/catalogue';
import { IoView, VehicleView } from './actuator_views';
import { CameraView } from './camera_view';
import { ChassisView } from './chassis_view';
import { DatalogView } from './datalog_view';
import { PtzView, ServoView } from './drive_views';
import { FieldsView } from './fields_view';
import { GyroView } from './gyro_view';
import { MapView } from './map_view';
import { ObjectsView, OdometryView, PilotView, PlannerView, PositionView } from './navigation_views';
import { GridMapView, Scan3dView } from './picture_views';
import { ScanView } from './scan_view';
import { ClockView, CompassView, GpsView, JoystickView } from './sensor_views';
import type { ViewProperties } from './view';

const byName: Record<string, ComponentType<ViewProperties>> = {
  Camera: CameraView,
  Chassis: ChassisView,
  Clock: ClockView,
  Compass: CompassView,
  Datalog: DatalogView,
  FeatureMap: MapView,
  Gps: GpsView,
  GridMap: GridMapView,
  Gyro: GyroView,
  Io: IoView,
  Joystick: JoystickView,
  Ladar: ScanView,
  Mcl: MapView,
  ObjRecog: ObjectsView,
  Odometry: OdometryView,
  Path: MapView,
  Pilot: PilotView,
  Planner: PlannerView,
  Position: PositionView,
  PtzDrive: PtzView,
  Scan2d: ScanView,
  Scan3d: Scan3dView,
  ServoDrive: ServoView,
  Vehicle: VehicleView,
};

const views = new Map(Object.entries(byName).map(([name, view]) => [classId(name), view]));

export function viewFor(id: number): ComponentType<ViewProperties> {
  return views.get(id) ?? FieldsView;
}
