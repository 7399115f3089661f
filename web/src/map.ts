import { colourOf } from './colours';
import { colourOfError, errorText } from './errors';
import { planCorners, showPlan } from './plan';
import { add, points, set } from './svg';
import type { Beacon, ErrorMap, Point, RangeCircle, RobotShape, RobotState, Site, Zone } from './types';

const trailSeconds = 30;
const trailGap = 0.03; // m between points of a trail

interface Drawn {
  group: SVGGElement;
  trail: SVGPolylineElement;
  ellipse: SVGEllipseElement;
  body: SVGGElement;
  label: SVGTextElement;
  path: { time: number; at: Point }[];
}

/** A square of the floor, and for how long robots were on it. */
export interface HeatCell {
  x: number;
  y: number;
  size: number;
  seconds: number;
}

interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** The floor plan, seen from above: x to the right, y up. */
export class FloorMap {
  readonly svg: SVGSVGElement;
  /** Metres of the map, y up: what is added here lies above all else. */
  readonly world: SVGGElement;
  private readonly layers: { plan: SVGGElement; errors: SVGGElement; zones: SVGGElement; heat: SVGGElement; views: SVGGElement; walls: SVGGElement; ranges: SVGGElement; installed: SVGGElement; cameras: SVGGElement; robots: SVGGElement };
  private readonly drawn = new Map<string, Drawn>();
  private all: Box = { x: -1, y: -1, width: 2, height: 2 };
  private shown: Box = this.all;
  private site: Site | null = null;

  constructor(svg: SVGSVGElement, private readonly onScale: (metres: number, pixels: number) => void) {
    this.svg = svg;
    // y points up on the map and down on the screen.
    const world = (this.world = add(svg, 'g', { transform: 'scale(1 -1)' }));
    this.layers = {
      plan: add(world, 'g', { class: 'plan' }),
      errors: add(world, 'g', { class: 'errors' }),
      zones: add(world, 'g', { class: 'zones' }),
      heat: add(world, 'g', { class: 'heat' }),
      views: add(world, 'g', { class: 'views' }),
      walls: add(world, 'g', { class: 'walls' }),
      ranges: add(world, 'g', { class: 'ranges' }),
      installed: add(world, 'g', { class: 'installed' }),
      cameras: add(world, 'g', { class: 'cameras' }),
      robots: add(world, 'g', { class: 'robots' }),
    };
    this.listen();
    new ResizeObserver(() => this.show(this.shown)).observe(svg);
  }

  setSite(site: Site): void {
    this.site = site;
    for (const layer of [this.layers.views, this.layers.walls, this.layers.installed, this.layers.cameras]) layer.replaceChildren();
    for (const landmark of site.landmarks) add(this.layers.installed, 'polygon', { points: points(landmark.points), 'data-landmark': landmark.id });
    for (const corner of site.corners) add(this.layers.installed, 'polyline', { points: points(corner.points), class: 'corner', 'data-corner': corner.id });
    for (const beacon of site.beacons) this.addBeacon(beacon);
    this.setZones(site.zones);
    showPlan(this.layers.plan, site.plan);
    for (const wall of site.walls) add(this.layers.walls, 'polyline', { points: points(wall) });
    for (const camera of site.cameras) {
      if (!camera.position || !camera.view) continue;
      add(this.layers.views, 'polygon', { points: points(camera.view), 'data-camera': camera.id });
      const mark = add(this.layers.cameras, 'g', { transform: `translate(${camera.position[0]} ${camera.position[1]})` });
      add(mark, 'circle', { r: 0.11 });
      const label = add(mark, 'text', { transform: 'scale(1 -1)', x: 0, y: 0.42 });
      label.textContent = camera.id;
    }
    this.setExtent(site);
  }

  /** What is shown at first, and by "Fit". A site that changed only a little does not move under whoever looks at it. */
  private setExtent(site: Site): void {
    const cameras = site.cameras.flatMap((c) => (c.position ? [c.position] : []));
    const seen = site.cameras.flatMap((c) => c.view ?? []);
    const corners: Point[] = site.walls.length ? site.walls.flat().concat(cameras) : seen.concat(cameras, site.beacons.map((b) => b.position), planCorners(site.plan));
    if (corners.length === 0) return this.fit();
    const xs = corners.map((p) => p[0]);
    const ys = corners.map((p) => p[1]);
    const margin = 0.6;
    const before = this.all;
    this.all = {
      x: Math.min(...xs) - margin,
      y: -Math.max(...ys) - margin,
      width: Math.max(...xs) - Math.min(...xs) + 2 * margin,
      height: Math.max(...ys) - Math.min(...ys) + 2 * margin,
    };
    if (JSON.stringify(before) !== JSON.stringify(this.all)) this.fit();
  }

  setZones(zones: Zone[]): void {
    this.layers.zones.replaceChildren();
    for (const zone of zones) this.addZone(zone);
  }

  /** This zone is being changed, and drawn by whoever does that; null or the name of none: none is. */
  setAside(zone: string | null): void {
    for (const mark of this.layers.zones.children) mark.classList.toggle('aside', (mark as SVGElement).dataset.zone === zone);
  }

  /** How exactly a place on the floor would be known. */
  setErrors(maps: ErrorMap[]): void {
    this.layers.errors.replaceChildren();
    this.svg.classList.toggle('with-errors', maps.length > 0);
    for (const { cell, cells } of maps) {
      for (const [x, y, radius] of cells) {
        const mark = add(this.layers.errors, 'rect', { x: x - cell / 2, y: y - cell / 2, width: cell, height: cell, fill: colourOfError(radius) });
        add(mark, 'title', {}).textContent = errorText(radius);
      }
    }
  }

  private addZone(zone: Zone): void {
    add(this.layers.zones, 'polygon', { points: points(zone.border), 'data-zone': zone.id });
    const middle = (k: 0 | 1): number => zone.border.reduce((sum, corner) => sum + corner[k], 0) / zone.border.length;
    const label = add(this.layers.zones, 'text', { transform: 'scale(1 -1)', x: middle(0), y: -middle(1), 'data-zone': zone.id });
    label.textContent = zone.id;
  }

  /** Where robots were for long. */
  setHeat(cells: HeatCell[]): void {
    this.layers.heat.replaceChildren();
    const longest = Math.max(...cells.map((c) => c.seconds), 1e-9);
    for (const { x, y, size, seconds } of cells) {
      const opacity = (0.08 + 0.72 * Math.sqrt(seconds / longest)).toFixed(3);
      const mark = add(this.layers.heat, 'rect', { x, y, width: size, height: size, 'fill-opacity': opacity });
      add(mark, 'title', {}).textContent = `${seconds.toFixed(1)} s`;
    }
  }

  private addBeacon(beacon: Beacon): void {
    const [x, y] = beacon.position;
    const mark = add(this.layers.installed, 'g', { transform: `translate(${x} ${y})`, class: 'beacon', 'data-beacon': beacon.id });
    add(mark, 'circle', { r: 0.07 });
    const label = add(mark, 'text', { transform: 'scale(1 -1)', x: 0.16, y: -0.1 });
    label.textContent = beacon.id;
  }

  /** The circles on which each robot is by its ranges. */
  setRanges(circles: RangeCircle[]): void {
    this.layers.ranges.replaceChildren();
    for (const circle of circles) {
      const beacon = this.site?.beacons.find((b) => b.id === circle.beacon);
      if (!beacon) continue;
      add(this.layers.ranges, 'circle', { cx: beacon.position[0], cy: beacon.position[1], r: circle.radius, style: `--robot: ${colourOf(circle.robot)}` });
    }
  }

  fit(): void {
    this.show(this.all);
  }

  zoom(factor: number, centre?: Point): void {
    const { x, y, width, height } = this.shown;
    const [cx, cy] = centre ?? [x + width / 2, y + height / 2];
    const limited = Math.min(Math.max(width / factor, 0.5), this.all.width * 4) / width;
    this.show({ x: cx - (cx - x) * limited, y: cy - (cy - y) * limited, width: width * limited, height: height * limited });
  }

  setRobots(robots: RobotState[], time: number): void {
    const present = new Set(robots.map((r) => r.id));
    for (const [id, drawn] of this.drawn) {
      if (present.has(id)) continue;
      drawn.group.remove();
      this.drawn.delete(id);
    }
    for (const robot of robots) this.place(this.drawn.get(robot.id) ?? this.create(robot), robot, time);
  }

  private create(robot: RobotState): Drawn {
    const colour = colourOf(robot.id);
    const group = add(this.layers.robots, 'g', { style: `--robot: ${colour}`, 'data-robot': robot.id });
    const trail = add(group, 'polyline', { class: 'trail' });
    const ellipse = add(group, 'ellipse', { class: 'ellipse' });
    const body = add(group, 'g', { class: 'body' });
    this.drawShape(body, this.shapeOf(robot.id));
    const label = add(group, 'text', { class: 'name' });
    label.textContent = robot.id;
    const drawn = { group, trail, ellipse, body, label, path: [] };
    this.drawn.set(robot.id, drawn);
    return drawn;
  }

  private shapeOf(id: string): RobotShape | undefined {
    const robots = this.site?.robots ?? {};
    return robots[id] ?? robots[id.replace(/-\d+$/, '')];
  }

  private drawShape(body: SVGGElement, shape: RobotShape | undefined): void {
    if (shape?.shape === 'box') {
      const [length, width] = shape.size;
      add(body, 'rect', { x: -length / 2, y: -width / 2, width: length, height: width, rx: 0.04 });
      const w = width / 4;
      add(body, 'path', { class: 'nose', d: `M ${length / 2 - 0.05} 0 L ${length / 2 - 0.05 - w} ${w} L ${length / 2 - 0.05 - w} ${-w} Z` });
    } else {
      const radius = (shape?.size[0] ?? 0.4) / 2;
      add(body, 'circle', { r: radius });
      add(body, 'path', { class: 'nose', d: `M ${radius * 0.85} 0 L 0 ${radius / 2} L 0 ${-radius / 2} Z` });
    }
  }

  private place(drawn: Drawn, robot: RobotState, time: number): void {
    const [xx, xy, yy] = robot.cov;
    // 95 % of the probability in the plane lies within sqrt(5.991) standard deviations.
    const mean = (xx + yy) / 2;
    const half = Math.hypot((xx - yy) / 2, xy);
    const angle = (Math.atan2(2 * xy, xx - yy) / 2) * (180 / Math.PI);
    set(drawn.ellipse, {
      rx: Math.sqrt(5.991 * Math.max(mean + half, 0)).toFixed(4),
      ry: Math.sqrt(5.991 * Math.max(mean - half, 0)).toFixed(4),
      transform: `translate(${robot.x} ${robot.y}) rotate(${angle.toFixed(2)})`,
    });
    const yaw = ((robot.yaw ?? 0) * 180) / Math.PI;
    set(drawn.body, { transform: `translate(${robot.x} ${robot.y}) rotate(${yaw.toFixed(2)})`, class: robot.yaw === null ? 'body headless' : 'body' });
    set(drawn.label, { transform: `translate(${robot.x} ${robot.y}) scale(1 -1)`, y: -0.55 });
    set(drawn.group, { class: robot.status });

    const last = drawn.path[drawn.path.length - 1];
    if (!last || Math.hypot(last.at[0] - robot.x, last.at[1] - robot.y) > trailGap) drawn.path.push({ time, at: [robot.x, robot.y] });
    while (drawn.path.length && time - drawn.path[0].time > trailSeconds) drawn.path.shift();
    set(drawn.trail, { points: points([...drawn.path.map((p) => p.at), [robot.x, robot.y]]) });
  }

  private show(box: Box): void {
    this.shown = box;
    set(this.svg, { viewBox: `${box.x} ${box.y} ${box.width} ${box.height}` });
    const pixels = this.svg.clientWidth;
    if (!pixels || !this.svg.clientHeight) return;
    const perMetre = Math.min(pixels / box.width, this.svg.clientHeight / box.height);
    this.svg.style.setProperty('--px', String(1 / perMetre)); // metres per screen pixel, for lines and letters of fixed size
    const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((m) => m * perMetre > 60) ?? 100;
    this.onScale(metres, metres * perMetre);
  }

  /** The place on the map, to the millimetre. */
  at(event: { clientX: number; clientY: number }): Point {
    const [x, y] = this.toMap(event);
    return [Math.round(1000 * x) / 1000, Math.round(-1000 * y) / 1000];
  }

  private toMap(event: { clientX: number; clientY: number }): Point {
    const matrix = this.svg.getScreenCTM();
    if (!matrix) return [0, 0];
    const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    return [p.x, p.y];
  }

  /** Wheel and pinch zoom, drag to move. */
  private listen(): void {
    const fingers = new Map<number, PointerEvent>();
    this.svg.addEventListener(
      'wheel',
      (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-event.deltaY * 0.0015), this.toMap(event));
      },
      { passive: false },
    );
    this.svg.addEventListener('pointerdown', (event) => {
      this.svg.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
    });
    const release = (event: PointerEvent) => fingers.delete(event.pointerId);
    this.svg.addEventListener('pointerup', release);
    this.svg.addEventListener('pointercancel', release);
    this.svg.addEventListener('pointermove', (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const other = [...fingers.values()].find((f) => f.pointerId !== event.pointerId);
      if (other) {
        const distance = (f: PointerEvent) => Math.hypot(f.clientX - other.clientX, f.clientY - other.clientY);
        this.zoom(distance(event) / Math.max(distance(before), 1), this.toMap(other));
      } else {
        const [x0, y0] = this.toMap(before);
        const [x1, y1] = this.toMap(event);
        this.show({ ...this.shown, x: this.shown.x + x0 - x1, y: this.shown.y + y0 - y1 });
      }
      fingers.set(event.pointerId, event);
    });
  }
}
