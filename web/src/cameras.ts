import { colourOf } from './colours';
import { add, points, set } from './svg';
import type { CameraState, SiteCamera, Segment } from './types';

const pictureInterval = 200; // ms between pictures of a camera that is on the screen

/** One camera: its picture with the outlines that were found, and how it is doing. */
export class CameraCard {
  readonly element = document.createElement('article');
  private readonly image = document.createElement('img');
  private readonly overlay: SVGSVGElement;
  private readonly status = document.createElement('span');
  private readonly detail = document.createElement('p');
  private visible = true;
  private loading = false;

  constructor(private readonly camera: SiteCamera) {
    this.element.className = 'camera';
    this.element.dataset.camera = camera.id;
    const picture = document.createElement('div');
    picture.className = 'picture';
    picture.style.aspectRatio = `${camera.width} / ${camera.height}`;
    this.image.alt = `Picture of camera ${camera.id}`;
    this.overlay = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    // The centre of the first pixel is (0, 0), its corner (-0.5, -0.5).
    set(this.overlay, { viewBox: `-0.5 -0.5 ${camera.width} ${camera.height}`, 'aria-hidden': 'true' });
    picture.append(this.image, this.overlay);
    const title = document.createElement('h3');
    title.textContent = camera.robot ? `${camera.id} on ${camera.robot}` : camera.id;
    this.status.className = 'pill';
    title.append(this.status);
    this.detail.className = 'quiet';
    this.element.append(title, picture, this.detail);
    new IntersectionObserver((entries) => (this.visible = entries[entries.length - 1].isIntersecting)).observe(this.element);
    window.setInterval(() => this.refresh(), pictureInterval);
  }

  show(state: CameraState): void {
    this.status.textContent = state.status;
    this.status.dataset.status = state.status;
    const speed = state.frames ? `${state.rate.toFixed(1)} frames/s, ${state.busy_ms.toFixed(1)} ms each` : 'no frame yet';
    this.detail.textContent = state.message && state.status !== 'waiting' ? `${speed}; ${state.message}` : speed;
    this.detail.title = state.note ?? '';
    this.overlay.replaceChildren();
    for (const outline of state.outlines) {
      add(this.overlay, 'polygon', { points: points(outline.points), style: `--robot: ${colourOf(outline.robot)}` });
    }
    if (state.seen) this.showSeen(state.seen);
    if (state.corner) this.showCorner(state.corner);
  }

  /** What a camera that looks for corners saw: the three edges, and faintly the lines that are none of them. */
  private showCorner(corner: NonNullable<CameraState['corner']>): void {
    const line = ([x1, y1, x2, y2]: Segment, kind: string): void => void add(this.overlay, 'line', { x1, y1, x2, y2, class: kind });
    for (const rejected of corner.rejected) line(rejected, 'stray');
    corner.edges.forEach((edge, i) => line(edge, i === 2 ? 'edge upright' : 'edge'));
    if (!corner.edges.length) return;
    const label = add(this.overlay, 'text', { x: corner.edges[0][0], y: corner.edges[0][1] - 9, class: 'landmark' });
    label.textContent = corner.id ?? '?';
  }

  /** What a camera that looks up saw: landmarks, spots that are none, lamps. */
  private showSeen(seen: NonNullable<CameraState['seen']>): void {
    for (const [left, top, right, bottom] of seen.lamps) {
      add(this.overlay, 'rect', { x: left - 2, y: top - 2, width: right - left + 5, height: bottom - top + 5, class: 'lamp' });
    }
    for (const [x, y] of seen.rejected) add(this.overlay, 'path', { d: `M${x - 4},${y - 4}l8,8m0,-8l-8,8`, class: 'rejected' });
    for (const landmark of seen.landmarks) {
      add(this.overlay, 'polygon', { points: points(landmark.points), class: 'landmark' });
      for (const [x, y] of landmark.points) add(this.overlay, 'circle', { cx: x, cy: y, r: 4, class: 'landmark' });
      const top = Math.min(...landmark.points.map((p) => p[1]));
      const middle = landmark.points.reduce((sum, p) => sum + p[0], 0) / landmark.points.length;
      const label = add(this.overlay, 'text', { x: middle, y: top - 9, class: 'landmark' });
      label.textContent = landmark.id ?? '?';
    }
  }

  private refresh(): void {
    if (!this.visible || this.loading || document.hidden) return;
    this.loading = true;
    const next = new Image();
    next.onload = () => {
      this.image.src = next.src;
      this.loading = false;
    };
    next.onerror = () => (this.loading = false);
    next.src = `api/cameras/${this.camera.id}.jpg?${Date.now()}`;
  }
}
