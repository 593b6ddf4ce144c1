// What the router reports about itself and its links, as far as the pages use it (schemas tims/router_list/1,
// tims/link/1, tims/route/1, tims/route_get/1, tims/event/1, tims/hop/1, tims/mailbox/1, tims/client/1, tims/stats/1).

export interface NamedAddress {
  name: string;
  raw: string;
}

export interface RouterItem {
  name: string | null;
  role: string;
  system: number;
  id: number;
  address: NamedAddress;
  kind: 'self' | 'super' | 'peer' | 'sub' | 'missing';
  state: 'up' | 'down';
  via: string | null;
  behind?: NamedAddress;
  since_s: number | null;
  rtt_s?: number | null;
  clock?: { offset_s: number; uncertainty_s: number } | null;
  version?: string;
}

// Of what a router sends over a link, as the question `fault` names them.
export interface InjectedFaults {
  loss: number; // 0 to 1, as the next two
  duplicate: number;
  reorder: number;
  delay_s: number;
  jitter_s: number;
  rate: number; // bytes a second; 0: no limit
  blackout: boolean;
}

export interface LinkItem extends Omit<RouterItem, 'state'> {
  state: 'idle' | 'connecting' | 'refused' | 'up' | 'silent' | 'down';
  path: string | null;
  path_why: string | null;
  paths: { path: string; used: boolean; works: boolean; trouble: string | null }[];
  peer_address: string | null;
  refusal: string | null;
  heard_s: number | null;
  loss_in: number | null;
  loss_out: number | null;
  mtu_bytes: number | null;
  rate_limit_bytes_per_s: number | null;
  queue_bytes: number[]; // by class of priority, the routers' own messages last
  class_bytes_out: number[]; // as these
  wire_bytes_in: number;
  wire_bytes_out: number;
  mailboxes: number;
  drops: number;
  queue_delay_s: number | null;
  faults?: InjectedFaults | null; // missing: an older router does not report them
}

export interface RouteAnswer {
  router: string;
  address: NamedAddress;
  verdict: 'deliver' | 'forward' | 'no_route' | 'self';
  next_router?: NamedAddress | null;
  via: string | null;
  owner: { name: string | null; peer: string | null; pid: number | null } | null;
  reason: string;
  outcome?: string;
}

export interface HopRecord {
  router: string;
  time: string;
  hop: number;
  from: NamedAddress;
  to: NamedAddress;
  waited_s: number | null;
}

export interface EventItem {
  seq: number;
  time: string;
  kind: string;
  address: NamedAddress | null;
  reason: string | null;
  text: string | null;
}

// Its state is known of local ones only.
export interface MailboxItem {
  address: NamedAddress;
  via: string | null;
  router: NamedAddress | null; // where it is registered
  owner: { name: string | null; peer: string | null } | null;
  age_s: number | null;
  slots?: number;
  waiting?: number;
  received?: number;
  replaced?: number;
  refused?: number;
  too_big?: number;
}

// What has become of the messages of a port.
export interface OutcomeItem {
  port: string;
  class: number;
  outcome: string;
  meaning: string;
  dropped: boolean;
  messages: number;
}

export interface ClientItem {
  id: number;
  port: 'local' | 'tcp' | 'websocket';
  name: string | null;
  pid: number | null;
  peer: string | null;
  connected_s: number;
  mailboxes: number;
  subject: string | null; // who it has proven to be
  in_bytes: number;
  out_bytes: number;
  drops: number;
  drop_bytes: number;
  queue_bytes: number;
}

export interface StaticRoute {
  match: string;
  via: string;
}
