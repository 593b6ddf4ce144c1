// Written by tims-schema --types from the C++ structs: do not change it here.

// A bigint where a number would not be exact.
export type Integer64 = number | bigint;

export interface ContDataReply {
  periodTime: number; // ms
}

export interface Parameter {
  name: string;
  type: number;
  valueInt: number;
  valueFloat: number;
  valueString: string;
}

export interface ParameterList {
  count?: number;
  parameters: Parameter[];
}

export interface ParameterEffect {
  name: string;
  takesEffect: number;
}

export interface ParameterEffects {
  count?: number;
  effects: ParameterEffect[];
}

export interface RuntimePlace {
  kind: number;
  count: Integer64;
  where: string;
}

export interface RuntimeData {
  since: number; // ms
  watch: number;
  loops: Integer64;
  blocked: Integer64;
  preempted: Integer64;
  pageFaults: Integer64;
  lost: Integer64;
  placeNum?: number;
  places: RuntimePlace[];
}

export interface ListenerInfo {
  mailbox: number;
  periodTime: number; // ms
  priority: number;
}

export interface ListenersData {
  periodTime: number; // ms
  dataSets: Integer64;
  listenerNum?: number;
  listeners: ListenerInfo[];
}

export interface DescriptionPage {
  size: number;
  offset: number;
  textNum?: number;
  text: string;
}

export interface GetDataRequest {
  recordingTime: number; // ms
}

export interface GetContDataRequest {
  periodTime: number; // ms
  dataMbxAdr: number;
}

export interface StopContDataRequest {
  dataMbxAdr: number;
}

export interface DescriptionRequest {
  offset: number;
  bytesMax: number;
}

export interface CameraData {
  recordingTime: number; // ms
  width: number; // px
  height: number; // px
  depth: number; // bit/px
  mode: number;
  colorFilterId: number;
  image: Uint8Array;
}

export interface CameraFormatData {
  width: number; // px
  height: number; // px
  depth: number; // bit/px
  mode: number;
}

export interface CameraParamData {
  calibration_width: number; // px
  calibration_height: number; // px
  f: number; // mm
  fx: number; // px
  fy: number; // px
  sx: number;
  sy: number;
  dx: number; // mm
  dy: number; // mm
  k1: number; // 1/mm2
  k2: number; // 1/mm2
  p1: number; // 1/mm
  p2: number; // 1/mm
  e0: number; // px
  n0: number; // px
  coordinateRotation: number[];
  coordinateTranslation: number[]; // mm
}

export interface ChassisData {
  recordingTime: number; // ms
  deltaX: number; // mm
  deltaY: number; // mm
  deltaRho: number; // rad
  vx: number; // mm/s
  vy: number; // mm/s
  omega: number; // rad/s
  battery: number; // V
  activePilot: number;
}

export interface ChassisMoveData {
  vx: number; // mm/s
  vy: number; // mm/s
  omega: number; // rad/s
}

export interface ChassisSetActivePilotData {
  activePilot: number;
}

export interface ChassisParamData {
  vxMax: number; // mm/s
  vyMax: number; // mm/s
  vxMin: number; // mm/s
  vyMin: number; // mm/s
  accMax: number; // mm/s2
  decMax: number; // mm/s2
  omegaMax: number; // rad/s
  minTurningRadius: number; // mm
  breakConstant: number; // mm/(mm/s)
  safetyMargin: number; // mm
  safetyMarginMove: number; // mm
  comfortMargin: number; // mm
  boundaryFront: number; // mm
  boundaryBack: number; // mm
  boundaryLeft: number; // mm
  boundaryRight: number; // mm
  wheelBase: number; // mm
  wheelRadius: number; // mm
  trackWidth: number; // mm
  pilotParameterA: number; // rad/mm
  pilotParameterB: number; // 1/s
  pilotVTransMax: number; // mm/s
}

export interface ClockData {
  recordingTime: number; // ms
  hour: number;
  minute: number;
  second: number;
  day: number;
  month: number;
  year: number;
  utcTime: Integer64; // s
  dayOfWeek: number;
  syncMode: number;
  varT: number; // ms
}

export interface CompassData {
  recordingTime: number; // ms
  orientation: number; // rad
  varOrientation: number; // rad
}

export interface Position3d {
  x: number; // mm
  y: number; // mm
  z: number; // mm
  phi: number; // rad
  psi: number; // rad
  rho: number; // rad
}

export interface GpsData {
  recordingTime: number; // ms
  mode: number;
  latitude: number; // rad
  longitude: number; // rad
  altitude: number; // mm
  heading: number; // rad
  speed: number; // mm/s
  satelliteNum: number;
  utcTime: Integer64; // s
  pdop: number;
  pos: Position3d;
  var: Position3d;
}

export interface GyroData {
  recordingTime: number; // ms
  roll: number; // rad
  pitch: number; // rad
  yaw: number; // rad
  aX: number; // mm/s2
  aY: number; // mm/s2
  aZ: number; // mm/s2
  wRoll: number; // rad/s
  wPitch: number; // rad/s
  wYaw: number; // rad/s
}

export interface IoData {
  recordingTime: number; // ms
  valueNum?: number;
  values: Uint8Array;
}

export interface JoystickAxes {
  x: number; // %
  y: number; // %
  z: number; // %
  phi: number; // rad
  psi: number; // rad
  rho: number; // rad
}

export interface JoystickData {
  recordingTime: number; // ms
  position: JoystickAxes;
  buttons: number;
}

export interface LadarPoint {
  angle: number; // rad
  distance: number; // mm
  type: number;
  intensity: number;
}

export interface LadarData {
  recordingTime: number; // ms
  duration: number; // ms
  maxRange: number; // mm
  startAngle: number; // rad
  endAngle: number; // rad
  pointNum?: number;
  points: LadarPoint[];
}

export interface PtzDriveData {
  recordingTime: number; // ms
  posPan: number; // rad
  posTilt: number; // rad
  posZoom: number; // %
}

export interface PtzDriveMovePosData {
  posPan: number; // rad
  posTilt: number; // rad
  posZoom: number; // %
  velPan: number; // rad/s
  velTilt: number; // rad/s
  velZoom: number; // %/s
  accPan: number; // rad/s2
  accTilt: number; // rad/s2
  accZoom: number; // %/s2
  replyPosReached: number;
}

export interface PtzDriveMoveVelData {
  velPan: number; // rad/s
  velTilt: number; // rad/s
  velZoom: number; // %/s
}

export interface ServoDriveData {
  recordingTime: number; // ms
  position: number;
}

export interface ServoDriveMovePosData {
  position: number;
  vel: number;
  acc: number;
  replyPositionReached: number;
}

export interface ServoDriveMoveVelData {
  vel: number;
}

export interface VehicleData {
  recordingTime: number; // ms
  speed: number; // mm/s
  omega: number; // rad/s
  throttle: number; // %
  brake: number; // %
  clutch: number; // %
  steering: number; // %
  gear: number;
  engine: number;
  parkBrake: number;
  vehicleProtect: number;
  activeController: number;
}

export interface VehicleSetValueData {
  throttle: number; // %
  brake: number; // %
  clutch: number; // %
  steering: number; // %
  gear: number;
  engine: number;
  parkBrake: number;
  vehicleProtect: number;
  activeController: number;
}

export interface FeatureMapDataPoint {
  x: number; // mm
  y: number; // mm
  x2: number; // mm
  y2: number; // mm
  l: number; // mm
  rho: number; // rad
  sin: number;
  cos: number;
  layer: number;
  type: number;
}

export interface FeatureMapData {
  recordingTime: number; // ms
  pos: Position3d;
  featureNum?: number;
  features: FeatureMapDataPoint[];
}

export interface FileName {
  length?: number;
  name: string;
}

export interface FeatureMapFeature {
  recordingTime: number; // ms
  feature: FeatureMapDataPoint;
  featureNumTemp: number;
}

export interface FeatureMapLayerData {
  layerNum?: number;
  layers: number[];
}

export interface GridMapData {
  recordingTime: number; // ms
  offsetX: number; // mm
  offsetY: number; // mm
  scale: number; // mm/cell
  gridNumX: number;
  gridNumY: number;
  occupancy: Uint8Array;
}

export interface MclDataPoint {
  x: number; // mm
  y: number; // mm
  z: number; // mm
  type: number;
  layer: number;
}

export interface MclData {
  recordingTime: number; // ms
  pos: Position3d;
  pointNum?: number;
  points: MclDataPoint[];
}

export interface Velocity3d {
  x: number; // mm/s
  y: number; // mm/s
  z: number; // mm/s
  phi: number; // rad/s
  psi: number; // rad/s
  rho: number; // rad/s
}

export interface Point3d {
  x: number; // mm
  y: number; // mm
  z: number; // mm
}

export interface ImageRect {
  x: number; // px
  y: number; // px
  width: number; // px
  height: number; // px
}

export interface ObjRecogObject {
  objectId: number;
  type: number;
  pos: Position3d;
  varPos: Position3d;
  vel: Velocity3d;
  varVel: Velocity3d;
  dim: Point3d;
  prob: number;
  imageArea: ImageRect;
}

export interface ObjRecogData {
  recordingTime: number; // ms
  refPos: Position3d;
  varRefPos: Position3d;
  objectNum?: number;
  objects: ObjRecogObject[];
}

export interface ScanPoint {
  x: number; // mm
  y: number; // mm
  z: number; // mm
  type: number;
  segment: number;
  intensity: number;
}

export interface Scan2dData {
  recordingTime: number; // ms
  duration: number; // ms
  maxRange: number; // mm
  sectorNum: number;
  sectorIndex: number;
  refPos: Position3d;
  pointNum?: number;
  points: ScanPoint[];
}

export interface Scan3dData {
  recordingTime: number; // ms
  duration: number; // ms
  maxRange: number; // mm
  scanNum: number;
  scanPointNum: number;
  scanMode: number;
  scanHardware: number;
  sectorNum: number;
  sectorIndex: number;
  refPos: Position3d;
  pointNum: number;
  compressed: number;
  points: ScanPoint[];
  compressedPoints: Uint8Array;
}

export interface RangePixel {
  range: number; // mm
  type: number;
}

export interface Scan3dRangeImageData {
  recordingTime: number; // ms
  scanMode: number;
  maxRange: number; // mm
  scanNum: number;
  scanPointNum: number;
  points: RangePixel[];
}

export interface DatalogLogInfo {
  logEnable: number;
  moduleMbx: number;
  periodTime: number; // ms
  maxDataLen: number; // bytes
  filename: string;
  bytesLogged: number; // bytes
  setsLogged: number;
}

export interface DatalogData {
  recordingTime: number; // ms
  logPathName: string;
  logNum?: number;
  logInfo: DatalogLogInfo[];
}

export interface GdosData {
  recordingTime: number; // ms
  sender: number;
  level: number;
  textNum?: number;
  text: string;
}

export interface GdosLogAddress {
  log: number;
  version: number;
}

export interface GdosTexts {
  textNum?: number;
  text: string;
}

export interface OdometryData {
  recordingTime: number; // ms
  pos: Position3d;
}

export interface Waypoint2d {
  x: number; // mm
  y: number; // mm
  speed: number; // mm/s
  maxRadius: number; // mm
  type: number;
  request: number;
  lbo: number; // mm
  id: number;
  wayId: number;
  layer: number;
  actionStart: number;
  actionEnd: number;
}

export interface Position2d {
  x: number; // mm
  y: number; // mm
  rho: number; // rad
}

export interface PolarSpline {
  basepoint: Waypoint2d;
  startPos: Position2d;
  endPos: Position2d;
  centerPos: Position2d;
  length: number; // mm
  radius: number; // mm
  vMax: number; // mm/s
  vStart: number; // mm/s
  vEnd: number; // mm/s
  accMax: number; // mm/s2
  decMax: number; // mm/s2
  type: number;
  request: number;
  lbo: number; // mm
}

export interface PathData {
  recordingTime: number; // ms
  splineNum?: number;
  splines: PolarSpline[];
}

export interface PathMakeData {
  vMax: number; // mm/s
  accMax: number; // mm/s2
  decMax: number; // mm/s2
  omegaMax: number; // rad/s
}

export interface PathReplanData {
  currSpline: number;
  splinePos: Position2d;
  distToObstacle: number; // mm
  pathLength: number; // mm
}

export interface PathDestData {
  pos: Position2d;
  speed: number; // mm/s
  layer: number;
}

export interface PathRddfData {
  waypointNum?: number;
  waypoints: Waypoint2d[];
}

export interface PathLayerData {
  layer: number;
}

export interface PilotData {
  recordingTime: number; // ms
  pos: Position3d;
  dest: Position3d;
  speed: number; // mm/s
  curve: number; // 1/mm
  distanceToDest: number; // mm
  pilotState: number;
  splineNum?: number;
  splines: PolarSpline[];
}

export interface PilotDestData {
  pos: Position3d;
  speed: number; // mm/s
}

export interface PilotHoldData {
  holdState: number;
  holdTime: number; // ms
  pos: Position3d;
}

export interface PilotRevertData {
  revertTime: number; // ms
}

export interface PilotWatchdogData {
  timeout: number; // ms
}

export interface PilotStatusData {
  recordingTime: number; // ms
  pos: Position3d;
  dest: Position3d;
  speed: number; // mm/s
  curve: number; // 1/mm
  distanceToDest: number; // mm
  pilotState: number;
}

export interface DestinationPoint {
  pos: Position3d;
  speed: number; // mm/s
}

export interface PilotMultiDestData {
  pointNum?: number;
  points: DestinationPoint[];
}

export interface PlannerString {
  stringLen: number;
  text: string;
}

export interface PlannerData {
  recordingTime: number; // ms
  state: number;
  messageNum?: number;
  messages: PlannerString[];
}

export interface PlannerCommand {
  commandNum?: number;
  commands: PlannerString[];
}

export interface PositionData {
  recordingTime: number; // ms
  pos: Position3d;
  var: Position3d;
}

export interface PositionWgs84Data {
  latitude: number; // rad
  longitude: number; // rad
  altitude: number; // mm
  heading: number; // rad
}

export interface PositionGkData {
  northing: number; // mm
  easting: number; // mm
  altitude: number; // mm
  heading: number; // rad
}

export interface PositionUtmData {
  northing: Integer64; // mm
  easting: Integer64; // mm
  zone: number;
  band: number;
  altitude: number; // mm
  heading: number; // rad
}

export interface WorldThing {
  kind: number;
  id: number;
  name: string;
  pos: Position2d;
  vx: number; // mm/s
  vy: number; // mm/s
  omega: number; // rad/s
  radius: number; // mm
  travelled: number; // mm
  isBlocked: number;
  walls: number;
  obstacles: number;
  people: number;
  robots: number;
  bumped: number;
}

export interface WorldData {
  recordingTime: number; // ms
  peopleMove: number;
  thingNum?: number;
  things: WorldThing[];
}

export interface WorldPlace {
  robot: string;
  pos: Position2d;
}

export interface Point2d {
  x: number; // mm
  y: number; // mm
}

export interface WorldObstacle {
  id: number;
  pos: Point2d;
  radius: number; // mm
  height: number; // mm
}

export interface WorldRemove {
  id: number;
}

export interface WorldPeople {
  move: number;
}

export interface WorldPlug {
  robot: string;
  sensor: string;
  isPlugged: number;
}

export interface WorldLine {
  robot: string;
  sensor: string;
  device: string;
  line: string;
  isPlugged: number;
}

export interface WorldLines {
  lineNum?: number;
  lines: WorldLine[];
}

export interface Structs {
  ContDataReply: ContDataReply;
  Parameter: Parameter;
  ParameterList: ParameterList;
  ParameterEffect: ParameterEffect;
  ParameterEffects: ParameterEffects;
  RuntimePlace: RuntimePlace;
  RuntimeData: RuntimeData;
  ListenerInfo: ListenerInfo;
  ListenersData: ListenersData;
  DescriptionPage: DescriptionPage;
  GetDataRequest: GetDataRequest;
  GetContDataRequest: GetContDataRequest;
  StopContDataRequest: StopContDataRequest;
  DescriptionRequest: DescriptionRequest;
  CameraData: CameraData;
  CameraFormatData: CameraFormatData;
  CameraParamData: CameraParamData;
  ChassisData: ChassisData;
  ChassisMoveData: ChassisMoveData;
  ChassisSetActivePilotData: ChassisSetActivePilotData;
  ChassisParamData: ChassisParamData;
  ClockData: ClockData;
  CompassData: CompassData;
  Position3d: Position3d;
  GpsData: GpsData;
  GyroData: GyroData;
  IoData: IoData;
  JoystickAxes: JoystickAxes;
  JoystickData: JoystickData;
  LadarPoint: LadarPoint;
  LadarData: LadarData;
  PtzDriveData: PtzDriveData;
  PtzDriveMovePosData: PtzDriveMovePosData;
  PtzDriveMoveVelData: PtzDriveMoveVelData;
  ServoDriveData: ServoDriveData;
  ServoDriveMovePosData: ServoDriveMovePosData;
  ServoDriveMoveVelData: ServoDriveMoveVelData;
  VehicleData: VehicleData;
  VehicleSetValueData: VehicleSetValueData;
  FeatureMapDataPoint: FeatureMapDataPoint;
  FeatureMapData: FeatureMapData;
  FileName: FileName;
  FeatureMapFeature: FeatureMapFeature;
  FeatureMapLayerData: FeatureMapLayerData;
  GridMapData: GridMapData;
  MclDataPoint: MclDataPoint;
  MclData: MclData;
  Velocity3d: Velocity3d;
  Point3d: Point3d;
  ImageRect: ImageRect;
  ObjRecogObject: ObjRecogObject;
  ObjRecogData: ObjRecogData;
  ScanPoint: ScanPoint;
  Scan2dData: Scan2dData;
  Scan3dData: Scan3dData;
  RangePixel: RangePixel;
  Scan3dRangeImageData: Scan3dRangeImageData;
  DatalogLogInfo: DatalogLogInfo;
  DatalogData: DatalogData;
  GdosData: GdosData;
  GdosLogAddress: GdosLogAddress;
  GdosTexts: GdosTexts;
  OdometryData: OdometryData;
  Waypoint2d: Waypoint2d;
  Position2d: Position2d;
  PolarSpline: PolarSpline;
  PathData: PathData;
  PathMakeData: PathMakeData;
  PathReplanData: PathReplanData;
  PathDestData: PathDestData;
  PathRddfData: PathRddfData;
  PathLayerData: PathLayerData;
  PilotData: PilotData;
  PilotDestData: PilotDestData;
  PilotHoldData: PilotHoldData;
  PilotRevertData: PilotRevertData;
  PilotWatchdogData: PilotWatchdogData;
  PilotStatusData: PilotStatusData;
  DestinationPoint: DestinationPoint;
  PilotMultiDestData: PilotMultiDestData;
  PlannerString: PlannerString;
  PlannerData: PlannerData;
  PlannerCommand: PlannerCommand;
  PositionData: PositionData;
  PositionWgs84Data: PositionWgs84Data;
  PositionGkData: PositionGkData;
  PositionUtmData: PositionUtmData;
  WorldThing: WorldThing;
  WorldData: WorldData;
  WorldPlace: WorldPlace;
  Point2d: Point2d;
  WorldObstacle: WorldObstacle;
  WorldRemove: WorldRemove;
  WorldPeople: WorldPeople;
  WorldPlug: WorldPlug;
  WorldLine: WorldLine;
  WorldLines: WorldLines;
}

// Bodies by CLASS.MESSAGE; without a class, of the messages of every class.
export interface Bodies {
  'OK': undefined;
  'ERROR': undefined;
  'TIMEOUT': undefined;
  'NOT_AVAILABLE': undefined;
  'ENABLED': undefined;
  'DISABLED': undefined;
  'CONT_DATA': ContDataReply;
  'PARAM': ParameterList;
  'PARAM_EFFECTS': ParameterEffects;
  'RUNTIME': RuntimeData;
  'LISTENERS': ListenersData;
  'DESCRIPTION': DescriptionPage;
  'ON': undefined;
  'OFF': undefined;
  'GET_STATUS': undefined;
  'GET_DATA': GetDataRequest;
  'GET_CONT_DATA': GetContDataRequest;
  'STOP_CONT_DATA': StopContDataRequest;
  'GET_NEXT_DATA': undefined;
  'GET_PARAM': undefined;
  'SET_PARAM': ParameterList;
  'GET_PARAM_EFFECTS': undefined;
  'GET_RUNTIME': undefined;
  'GET_LISTENERS': undefined;
  'GET_DESCRIPTION': DescriptionRequest;
  'GDOS.DATA': GdosData;
  'GDOS.GET_LOG': undefined;
  'GDOS.LOG': GdosLogAddress;
  'GDOS.GET_TEXTS': undefined;
  'GDOS.TEXTS': GdosTexts;
  'Chassis.DATA': ChassisData;
  'Chassis.MOVE': ChassisMoveData;
  'Chassis.GET_PARAMETER': undefined;
  'Chassis.SET_ACTIVE_PILOT': ChassisSetActivePilotData;
  'Chassis.PARAMETER': ChassisParamData;
  'Odometry.DATA': OdometryData;
  'Odometry.RESET': undefined;
  'Position.DATA': PositionData;
  'Position.UPDATE': PositionData;
  'Position.WGS84_TO_POS': PositionWgs84Data;
  'Position.POS_TO_WGS84': PositionData;
  'Position.GK_TO_POS': PositionGkData;
  'Position.POS_TO_GK': PositionData;
  'Position.UTM_TO_POS': PositionUtmData;
  'Position.POS_TO_UTM': PositionData;
  'Position.POS': PositionData;
  'Position.WGS84': PositionWgs84Data;
  'Position.GK': PositionGkData;
  'Position.UTM': PositionUtmData;
  'Ladar.DATA': LadarData;
  'Camera.DATA': CameraData;
  'Camera.GET_PARAMETER': undefined;
  'Camera.SET_FORMAT': CameraFormatData;
  'Camera.PARAMETER': CameraParamData;
  'Camera.FORMAT': CameraFormatData;
  'Gps.DATA': GpsData;
  'Joystick.DATA': JoystickData;
  'Pilot.DATA': PilotData;
  'Pilot.SET_DESTINATION': PilotDestData;
  'Pilot.HOLD_COMMAND': PilotHoldData;
  'Pilot.REVERT_COMMAND': PilotRevertData;
  'Pilot.WATCHDOG': PilotWatchdogData;
  'Pilot.GET_STATUS': undefined;
  'Pilot.STATUS': PilotStatusData;
  'Pilot.SET_MULTI_DESTINATION': PilotMultiDestData;
  'Scan2d.DATA': Scan2dData;
  'Datalog.DATA': DatalogData;
  'Datalog.INIT_LOG': undefined;
  'Datalog.SET_LOG': DatalogData;
  'Datalog.GET_LOG_STATUS': undefined;
  'Datalog.LOG_STATUS': DatalogData;
  'ObjRecog.DATA': ObjRecogData;
  'ObjRecog.SET_ESTIMATE': ObjRecogData;
  'ObjRecog.STOP_RECOG': ObjRecogData;
  'Clock.DATA': ClockData;
  'Vehicle.DATA': VehicleData;
  'Vehicle.SET_VALUE': VehicleSetValueData;
  'Gyro.DATA': GyroData;
  'Io.DATA': IoData;
  'Io.SET_DATA': IoData;
  'ServoDrive.DATA': ServoDriveData;
  'ServoDrive.HOME': undefined;
  'ServoDrive.MOVE_POS': ServoDriveMovePosData;
  'ServoDrive.MOVE_VEL': ServoDriveMoveVelData;
  'ServoDrive.INFORM_REACHED': undefined;
  'ServoDrive.POSITION_REACHED': undefined;
  'Scan3d.DATA': Scan3dData;
  'Scan3d.GET_RANGE_IMAGE': undefined;
  'Scan3d.STORE_DATA': undefined;
  'Scan3d.RANGE_IMAGE': Scan3dRangeImageData;
  'Planner.DATA': PlannerData;
  'Planner.COMMAND': PlannerCommand;
  'Planner.GET_COMMAND': undefined;
  'FeatureMap.DATA': FeatureMapData;
  'FeatureMap.LOAD_MAP': FileName;
  'FeatureMap.ADD_LINE': FeatureMapFeature;
  'FeatureMap.SAVE_MAP': FileName;
  'FeatureMap.GIVE_MAP': undefined;
  'FeatureMap.DELETE_LINE': FeatureMapFeature;
  'FeatureMap.DISPLACE_LINE': FeatureMapFeature;
  'FeatureMap.GET_LAYER': undefined;
  'FeatureMap.SET_LAYER': FeatureMapLayerData;
  'FeatureMap.LAYER': FeatureMapLayerData;
  'GridMap.DATA': GridMapData;
  'Path.DATA': PathData;
  'Path.MAKE': PathMakeData;
  'Path.REPLAN': PathReplanData;
  'Path.SET_DESTINATION': PathDestData;
  'Path.SET_RDDF': PathRddfData;
  'Path.GET_DBG_GRIDMAP': undefined;
  'Path.GET_LAYER': undefined;
  'Path.SET_LAYER': PathLayerData;
  'Path.DBG_GRIDMAP': GridMapData;
  'Path.LAYER': PathLayerData;
  'Mcl.DATA': MclData;
  'Mcl.LOAD_MAP': FileName;
  'PtzDrive.DATA': PtzDriveData;
  'PtzDrive.HOME': undefined;
  'PtzDrive.MOVE_POS': PtzDriveMovePosData;
  'PtzDrive.MOVE_VEL': PtzDriveMoveVelData;
  'PtzDrive.INFORM_REACHED': undefined;
  'PtzDrive.POSITION_REACHED': undefined;
  'Compass.DATA': CompassData;
  'World.DATA': WorldData;
  'World.PLACE': WorldPlace;
  'World.PUT': WorldObstacle;
  'World.REMOVE': WorldRemove;
  'World.PEOPLE': WorldPeople;
  'World.PLUG': WorldPlug;
  'World.GET_LINES': undefined;
  'World.OBSTACLE': WorldObstacle;
  'World.LINES': WorldLines;
}
