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
const closed = /^[\s,]*$/;

export function importGuiCfg(text: string): Imported {
  const open = new Map<string, Set<string>>(); // workspace and system: tiles
  const remarks: string[] = [];
  let workspace = 'workspace';
  let inJars = false;
  for (const [i, raw] of text.split(/\r?\n/).entries()) {
    const line = raw.trim();
    if (line === '' || line.startsWith('//')) continue;
    const [keyword = '', ...rest] = line.split(/\s+/);
    if (keyword === 'JAR_FILES') inJars = true;
    else if (keyword === 'GROUP') inJars = false;
    else if (keyword === 'WORKSPACE') workspace = rest.join(' ') || 'workspace';
    else if (!inJars && !keywords.includes(keyword)) addWindow(line, i + 1, workspace, open, remarks);
  }
  const layouts = [...open].map(([key, tiles]) => {
    const [name = '', system = '0', isDrive] = key.split('\n');
    if (isDrive) return { name: `${name}, drive (robot ${system})`, address: `#/drive/${system}` };
    return { name: `${name} (robot ${system})`, address: `#/robot/${system}?tiles=${[...tiles].join(',')}` };
  });
  if (layouts.length === 0) remarks.push('it has no open windows of components');
  return { layouts, remarks };
}

function addWindow(line: string, number: number, workspace: string, open: Map<string, Set<string>>, remarks: string[]) {
  const match = window.exec(line);
  if (match === null) {
    remarks.push(`line ${number} is neither a keyword nor a window: ${line}`);
    return;
  }
  const [, , view = '', instance, place = '', options = ''] = match;
  if (closed.test(place) || instance === undefined) return;
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
