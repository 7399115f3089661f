import { colourOf } from './colours';
import { add, points, set } from './svg';
import type { CameraState, SiteCamera } from './types';

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
    title.textContent = camera.id;
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
    this.overlay.replaceChildren();
    for (const outline of state.outlines) {
      add(this.overlay, 'polygon', { points: points(outline.points), style: `--robot: ${colourOf(outline.robot)}` });
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
