// Reads gui.cfg, the layout of the original's window, as layouts of the console: each of its workspaces becomes one
// page of a robot, with the windows that were open on it. Pure.
//
//   GROUP drivers
//   rack.gui.main.LadarGui 0 (10,20,300,200,0) -system=3 -F2
//
// A window without an instance (messages, map) is a page of the console and no tile; the stick in the window is the
// page that drives, and PositionNavi is a part of the view of Position. What the console has no use for
// (positions, colours, routers' addresses) is left out, and named.

import { classId } from '../codec/catalogue';

export interface Layout {
  name: string;
  address: string; // "#/robot/3?tiles=Ladar/0"
}

export interface Imported {
  layouts: Layout[];
  remarks: string[];
}

const keywords = ['TIMS_PARAM', 'TIMS', 'MAIN_FRAME', 'NAV_UPDATE', 'RACK_NAME'];
const window = /^([\w.]*?)(\w+Gui|JoystickSoftware|PositionNavi)\s+(?:(\d+)\s*)?\(([-\d,\s]*)\)\s*(.*)$/;
const ownPages: Record<string, string> = { GdosGui: 'messages', MapViewGui: 'map' };
const closed = /^[\s,]*$/;

export function importGuiCfg(text: string): Imported {
  const open = new Map<string, Set<string>>(); // workspace and system: tiles
  const remarks: string[] = [];
  const left = new Map<string, number[]>(); // what it is: lines
  let workspace = 'workspace';
  let inJars = false;
  for (const [i, raw] of text.split(/\r?\n/).entries()) {
    const line = raw.trim();
    if (line === '' || line.startsWith('//')) continue;
    const [keyword = '', ...rest] = line.split(/\s+/);
    if (keyword === 'JAR_FILES') inJars = true;
    else if (keyword === 'GROUP') inJars = false;
    else if (keyword === 'WORKSPACE') workspace = rest.join(' ') || 'workspace';
    else if (keywords.includes(keyword)) leave(left, keyword, i + 1);
    else if (inJars) leave(left, 'plug-ins', i + 1);
    else addWindow(line, i + 1, workspace, { open, remarks, left });
  }
  const layouts = [...open].map(([key, tiles]) => {
    const [name = '', system = '0', isDrive] = key.split('\n');
    if (isDrive) return { name: `${name}, drive (robot ${system})`, address: `#/drive/${system}` };
    return { name: `${name} (robot ${system})`, address: `#/robot/${system}?tiles=${[...tiles].join(',')}` };
  });
  for (const [what, lines] of left) remarks.push(`left out: ${what} (${linesText(lines)})`);
  if (layouts.length === 0) remarks.push('it has no open windows of components');
  return { layouts, remarks };
}

function leave(left: Map<string, number[]>, what: string, line: number): void {
  left.set(what, [...(left.get(what) ?? []), line]);
}

const linesText = (lines: number[]) =>
  lines.length > 1 ? `${lines.length} lines, the first is ${lines[0]}` : `line ${lines[0]}`;

interface Found {
  open: Map<string, Set<string>>;
  remarks: string[];
  left: Map<string, number[]>;
}

function addWindow(line: string, number: number, workspace: string, { open, remarks, left }: Found): void {
  const match = window.exec(line);
  if (match === null) {
    remarks.push(`line ${number} is neither a keyword nor a window: ${line}`);
    return;
  }
  const [, , view = '', instance, place = '', options = ''] = match;
  if (closed.test(place)) return;
  leave(left, 'positions and sizes of windows', number);
  if (/(^|\s)-bg/.test(options)) leave(left, 'background pictures of maps: choose them on the page of the map', number);
  if (instance === undefined) {
    const page = ownPages[view];
    leave(left, page === undefined ? view : `${view}, which is a page: #/${page}`, number);
    return;
  }
  const name = view === 'PositionNavi' ? 'Position' : view.replace(/Gui$/, '');
  const system = /-system=(\d+)/.exec(options)?.[1] ?? '0';
  const key = `${workspace}\n${system}`;
  if (view === 'JoystickSoftware') {
    open.set(`${key}\ndrive`, new Set());
    return;
  }
  if (classId(name) === undefined) {
    remarks.push(`line ${number}: the console has no class ${name}`);
    return;
  }
  const tiles = open.get(key) ?? new Set<string>();
  tiles.add(`${name}/${instance}`);
  open.set(key, tiles);
}
