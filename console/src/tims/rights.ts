// What each message, and each question to a router or an agent, needs of a login: the table of the router
// (router/io/rights.h), which checks all that it gets. browser/login.test.mjs compares the two.

import { findNamed } from '../codec/catalogue';
import { types } from './header';

export type Right = 'none' | 'look' | 'drive' | 'configure';

export const order: readonly Right[] = ['none', 'look', 'drive', 'configure'];

const reading = new Set<number>([
  types.getStatus,
  types.getData,
  types.getContData,
  types.stopContData,
  types.getNextData,
  types.getParam,
  types.getParamEffects,
  types.getDescription,
  types.getRuntime,
  types.getListeners,
  types.adminRequest, // by its question
]);

// Of single classes: all others may change something.
const readingOfClass: Record<string, string[]> = {
  GDOS: ['GET_LOG', 'GET_TEXTS'],
  Chassis: ['GET_PARAMETER'],
  Position: ['WGS84_TO_POS', 'POS_TO_WGS84', 'GK_TO_POS', 'POS_TO_GK', 'UTM_TO_POS', 'POS_TO_UTM'],
  Camera: ['GET_PARAMETER'],
  Pilot: ['GET_STATUS'],
  Datalog: ['GET_LOG_STATUS'],
  Scan3d: ['GET_RANGE_IMAGE'],
  Planner: ['GET_COMMAND'],
  FeatureMap: ['GET_LAYER'],
  Path: ['GET_DBG_GRIDMAP', 'GET_LAYER'],
  World: ['GET_LINES'],
};

export function neededForType(type: number, ofClass = ''): Right {
  if (type === types.setParam) return 'configure';
  const isReading =
    reading.has(type) || readingOfClass[ofClass]?.some((name) => findNamed(`${ofClass}.${name}`)?.type === type);
  return isReading ? 'look' : 'drive';
}

const ofQuestions: Record<string, Right> = {
  lease: 'drive',
  link: 'configure',
  fault: 'configure',
  route_add: 'configure',
  route_delete: 'configure',
};

// Of agents, all that is not one of these changes something.
const readingAgents = ['list', 'get', 'options', 'describe', 'state', 'check', 'history', 'generation', 'fleet'];

export function neededForQuestion(ask: string): Right {
  const [, ofAgent] = /^conf_(.*)$/.exec(ask) ?? [];
  if (ofAgent !== undefined) return readingAgents.includes(ofAgent) ? 'look' : 'configure';
  return ofQuestions[ask] ?? 'look';
}
