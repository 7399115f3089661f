// What /api/site and /api/state say; see docs/formats.md. Metres, radians, pixels.
export type Point = [number, number];

export interface SiteCamera {
  id: string;
  width: number;
  height: number;
  position: Point;
  view: Point[];
}

export interface RobotShape {
  shape: 'box' | 'cylinder';
  size: number[];
  many: boolean;
}

export interface Site {
  name: string;
  walls: Point[][];
  cameras: SiteCamera[];
  robots: Record<string, RobotShape>;
}

export interface RobotState {
  id: string;
  status: 'ok' | 'coasting';
  x: number;
  y: number;
  yaw: number | null;
  cov: [number, number, number, number]; // xx, xy, yy, yaw-yaw
  sources: string[];
}

export interface CameraState {
  id: string;
  status: string;
  message: string;
  frames: number;
  rate: number;
  busy_ms: number;
  outlines: { robot: string; points: Point[]; support: number }[];
}

export interface State {
  time: number;
  robots: RobotState[];
  cameras: CameraState[];
}
