// What /api/site and /api/state say; see docs/openapi.json. Metres, radians, pixels.
export type Point = [number, number];
export type Segment = [number, number, number, number];

/** Expected 95 % error of a fix on the floor that a camera sees: x, y, radius of each cell, m. */
export interface ErrorMap {
  cell: number;
  cells: [number, number, number][];
}

export interface SiteCamera {
  id: string;
  width: number;
  height: number;
  position?: Point; // of a fixed camera
  view?: Point[];
  errors?: ErrorMap;
  robot?: string; // of a camera that rides on this robot
}

export interface Landmark {
  id: string;
  points: Point[];
}

export interface Beacon {
  id: string;
  position: Point;
}

export interface Corner {
  id: string;
  points: Point[]; // a bit along its x edge, the corner, a bit along its y edge
}

export interface Zone {
  id: string;
  border: Point[];
}

/** Where the picture of the site's plan lies: its lower left corner (m), the direction of its lower edge (rad). */
export interface Plan {
  width: number; // px
  height: number;
  resolution: number; // m per pixel
  x: number;
  y: number;
  yaw: number;
}

export interface RobotShape {
  shape: 'box' | 'cylinder';
  size: number[];
  many: boolean;
}

export interface Site {
  version: number;
  name: string;
  walls: Point[][];
  cameras: SiteCamera[];
  robots: Record<string, RobotShape>;
  landmarks: Landmark[];
  beacons: Beacon[];
  corners: Corner[];
  zones: Zone[];
  plan?: Plan;
}

export interface RobotState {
  id: string;
  status: 'ok' | 'coasting' | 'unknown'; // unknown: no robot of the site
  x: number;
  y: number;
  yaw: number | null;
  cov: [number, number, number, number]; // xx, xy, yy, yaw-yaw
  sources: string[];
  zones?: string[]; // that it is in
  identity?: number; // probability that it is this robot and not one that looks the same; absent: certain
}

/** A line of /api/history, of a robot or thing that was found. */
export interface RecordedFix {
  time: number;
  robot: string | null;
  id?: string; // of what is no robot
  status: 'ok' | 'coasting';
  x: number;
  y: number;
  yaw?: number | null;
  covariance: number[]; // 9, row by row over x, y, yaw
  sources: string[];
}

export interface CameraState {
  id: string;
  status: string;
  message: string;
  note?: string; // of a live camera: where its times come from, what it sets by itself
  frames: number;
  rate: number;
  busy_ms: number;
  outlines: { robot: string; points: Point[]; support: number }[];
  seen?: { landmarks: { id: string | null; points: Point[] }[]; rejected: Point[]; lamps: Segment[] };
  corner?: { id: string | null; edges: Segment[]; rejected: Segment[] }; // edges: along the ceiling, along the ceiling, between the walls
}

/** Where readings of the robots' own senses come from. */
export interface SenseState {
  source: string;
  message: string;
  readings: number;
}

/** Where fixes go to. */
export interface SinkState {
  name: string;
  status: 'ok' | 'failed';
  message: string;
  lost?: number; // messages that could not be passed on
}

export interface RangeCircle {
  robot: string;
  beacon: string;
  radius: number;
}

export interface ZoneEvent {
  time: number;
  robot: string;
  zone: string;
  event: 'enter' | 'leave';
}

export interface State {
  time: number;
  site: number; // the version of /api/site
  robots: RobotState[];
  cameras: CameraState[];
  ranges: RangeCircle[];
  sinks?: SinkState[];
  senses?: SenseState[];
  zone_events?: ZoneEvent[]; // the newest last
  stages?: Record<string, [number, number, number]>; // ms of each stage: median, 95 %, 99 %
}
