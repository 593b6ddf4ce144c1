import assert from 'node:assert/strict';
import { test } from 'node:test';
import { importGuiCfg } from './gui_cfg';

const example = `// settings
TIMS rack.main.tims.TimsTcp
TIMS_PARAM localhost
MAIN_FRAME (0,0,1400,800,0)
NAV_UPDATE 1000
JAR_FILES
plugins/extra.jar
GROUP drivers
rack.gui.main.GdosGui (0,600,600,200,0)
rack.gui.drivers.LadarGui 0 (10,20,300,200,0) -system=3 -F2
rack.gui.drivers.CameraGui 1 (,,,,) -show
WORKSPACE far
rack.gui.drivers.ChassisGui 0 (10,20,300,200,3)
rack.gui.drivers.LadarGui 1 (-5,20,300,200,0)
rack.gui.drivers.UnheardGui 0 (1,2,3,4,0)
nonsense
`;

test('open windows become tiles, by workspace and robot', () => {
  const { layouts } = importGuiCfg(example);
  assert.deepEqual(layouts, [
    { name: 'workspace (robot 3)', address: '#/robot/3?tiles=Ladar/0' },
    { name: 'far (robot 0)', address: '#/robot/0?tiles=Chassis/0,Ladar/1' },
  ]);
});

test('what is not understood is named with its line', () => {
  const { remarks } = importGuiCfg(example);
  assert.deepEqual(remarks, [
    'line 15: the console has no class Unheard',
    'line 16 is neither a keyword nor a window: nonsense',
    'left out: TIMS (line 2)',
    'left out: TIMS_PARAM (line 3)',
    'left out: MAIN_FRAME (line 4)',
    'left out: NAV_UPDATE (line 5)',
    'left out: plug-ins (line 7)',
    'left out: positions and sizes of windows (5 lines, the first is 9)',
    'left out: GdosGui, which is a page: #/messages (line 9)',
  ]);
});

test('a file without windows says so', () => {
  assert.deepEqual(importGuiCfg('').remarks, ['it has no open windows of components']);
});

test('the stick in the window is the page that drives, and PositionNavi is in the view of Position', () => {
  const { layouts, remarks } = importGuiCfg(
    'rack.gui.navigation.PositionNavi 0 (1,2,3,4,0) -system=2\nrack.gui.main.JoystickSoftware 0 (1,2,3,4,0) -system=2\n',
  );
  assert.deepEqual(remarks, ['left out: positions and sizes of windows (2 lines, the first is 1)']);
  assert.deepEqual(layouts, [
    { name: 'workspace (robot 2)', address: '#/robot/2?tiles=Position/0' },
    { name: 'workspace, drive (robot 2)', address: '#/drive/2' },
  ]);
});

test('a window of the map is a page, and its background is named', () => {
  const { remarks } = importGuiCfg('rack.gui.main.MapViewGui (0,0,9,9,0) -bg=hall.png -bgX=3\n');
  assert.deepEqual(remarks, [
    'left out: positions and sizes of windows (line 1)',
    'left out: background pictures of maps: choose them on the page of the map (line 1)',
    'left out: MapViewGui, which is a page: #/map (line 1)',
    'it has no open windows of components',
  ]);
});
