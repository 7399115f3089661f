// Draws zones on the map, for the operator: click corners, drag them, name the zone, save it.
import './zones.css';
import { made } from './made';
import type { FloorMap } from './map';
import { add, points } from './svg';
import type { Point, Zone } from './types';

const clickPixels = 5; // a pointer that moves farther drags

type Send = (method: 'PUT' | 'DELETE', path: string, content?: unknown) => Promise<string>;

export class ZoneTool {
  private readonly button = made('button', { id: 'zone-tool', type: 'button', title: 'Draw or change a zone', textContent: 'Zones', hidden: true });
  private readonly bar = made('form', { id: 'zone-bar', hidden: true });
  private readonly choice = made('select', { ariaLabel: 'Zone' });
  private readonly name = made('input', { type: 'text', placeholder: 'name', required: true, pattern: '[A-Za-z0-9_\\-]{1,64}', title: 'letters, digits, _ and -', ariaLabel: 'Name of the zone' });
  private readonly hint = made('span', { className: 'quiet' });
  private readonly drop = made('button', { type: 'button', textContent: 'Remove corner' });
  private readonly save = made('button', { type: 'submit', textContent: 'Save' });
  private readonly remove = made('button', { type: 'button', textContent: 'Delete zone' });
  private readonly cancel = made('button', { type: 'button', textContent: 'Cancel', title: 'Escape' });
  private readonly message = made('p', { className: 'message' });
  private readonly layer: SVGGElement;

  private zones: Zone[] = [];
  private corners: Point[] = [];
  private chosen = -1; // the corner that was touched last
  private dragging = false;
  private pressed: PointerEvent | null = null;

  /** `changed` gets the zones as they are once the server has taken a change. */
  constructor(
    private readonly map: FloorMap,
    panel: Element,
    tools: Element,
    private readonly send: Send,
    private readonly changed: (zones: Zone[]) => void,
  ) {
    this.layer = add(map.world, 'g', { class: 'drawn-zone' });
    this.message.setAttribute('role', 'alert');
    this.bar.append(this.choice, this.name, this.hint, this.drop, this.save, this.remove, this.cancel, this.message);
    panel.append(this.bar);
    tools.prepend(this.button);
    this.button.onclick = () => (this.bar.hidden ? this.open() : this.close());
    this.cancel.onclick = () => this.close();
    this.choice.onchange = () => this.begin(this.zones.find((zone) => zone.id === this.choice.value));
    this.drop.onclick = () => this.dropCorner();
    this.remove.onclick = () => void this.change('DELETE');
    this.bar.onsubmit = (event) => {
      event.preventDefault();
      void this.change('PUT');
    };
    this.listen();
  }

  allow(operator: boolean): void {
    this.button.hidden = !operator;
    if (!operator) this.close();
  }

  setZones(zones: Zone[]): void {
    this.zones = zones;
    if (this.bar.hidden) return;
    const chosen = this.choice.value; // what is just being drawn stays
    this.offerZones();
    this.choice.value = chosen;
  }

  private offerZones(): void {
    this.choice.replaceChildren(new Option('New zone', ''), ...this.zones.map((zone) => new Option(zone.id, zone.id)));
  }

  private open(): void {
    this.bar.hidden = false;
    this.offerZones();
    this.begin(undefined);
  }

  private close(): void {
    this.bar.hidden = true;
    this.corners = [];
    this.dragging = false;
    this.show();
  }

  /** A new zone, or one that is there. */
  private begin(zone: Zone | undefined): void {
    this.corners = zone ? zone.border.map(([x, y]) => [x, y]) : [];
    this.chosen = -1;
    this.name.value = zone?.id ?? '';
    this.name.readOnly = zone !== undefined;
    this.remove.hidden = zone === undefined;
    this.message.textContent = '';
    this.show();
  }

  private async change(method: 'PUT' | 'DELETE'): Promise<void> {
    const id = this.name.value;
    const border = this.corners;
    if (method === 'PUT' && border.length < 3) {
      this.message.textContent = 'A zone has three corners or more: click them on the map.';
      return;
    }
    if (method === 'PUT' && !this.name.readOnly && this.zones.some((zone) => zone.id === id)) {
      this.message.textContent = `There is a zone ${id} already: choose it to change it, or take another name.`;
      return;
    }
    for (const button of [this.save, this.remove]) button.disabled = true;
    const problem = await this.send(method, `api/zones/${id}`, method === 'PUT' ? { border } : undefined);
    for (const button of [this.save, this.remove]) button.disabled = false;
    if (problem) {
      this.message.textContent = problem;
      return;
    }
    const place = this.zones.findIndex((zone) => zone.id === id);
    const zones = [...this.zones];
    if (method === 'PUT') zones.splice(place < 0 ? zones.length : place, place < 0 ? 0 : 1, { id, border });
    else zones.splice(place, 1);
    this.close();
    this.changed(zones);
  }

  private dropCorner(): void {
    if (this.corners.length === 0) return;
    this.corners.splice(this.chosen < 0 ? this.corners.length - 1 : this.chosen, 1);
    this.chosen = -1;
    this.show();
  }

  /** The border, its corners, and between them places from which new corners can be dragged. */
  private show(): void {
    this.layer.replaceChildren();
    const n = this.corners.length;
    this.map.setAside(this.bar.hidden ? null : this.choice.value);
    this.map.svg.classList.toggle('drawing', !this.bar.hidden);
    this.drop.disabled = n === 0;
    this.hint.textContent = n === 0 ? 'Click its corners on the map, one after the other.' : `${n} corner${n === 1 ? '' : 's'}`;
    if (n > 0) add(this.layer, n > 2 ? 'polygon' : 'polyline', { points: points(this.corners) });
    for (let i = 0; n > 1 && i < n; ++i) {
      const [a, b] = [this.corners[i], this.corners[(i + 1) % n]];
      add(this.layer, 'circle', { class: 'middle', 'data-middle': i, cx: (a[0] + b[0]) / 2, cy: (a[1] + b[1]) / 2 });
    }
    this.corners.forEach(([cx, cy], i) => add(this.layer, 'circle', { class: i === this.chosen ? 'corner chosen' : 'corner', 'data-corner': i, cx, cy }));
  }

  /** A corner is taken hold of, or one is made between two others. */
  private grasp(event: PointerEvent): boolean {
    const { corner, middle } = (event.target as SVGElement).dataset;
    if (corner === undefined && middle === undefined) return false;
    this.chosen = corner !== undefined ? Number(corner) : Number(middle) + 1;
    if (middle !== undefined) this.corners.splice(this.chosen, 0, this.map.at(event));
    this.dragging = true;
    return true;
  }

  /** Before the map itself hears of it: what is not for a corner moves the map as ever. */
  private listen(): void {
    const drawing = (handle: (event: PointerEvent) => boolean) => (event: PointerEvent) => {
      if (!this.bar.hidden && handle(event)) event.stopImmediatePropagation();
    };
    const svg = this.map.svg;
    svg.addEventListener('pointerdown', drawing((event) => {
      this.pressed = event;
      return this.grasp(event);
    }), true);
    svg.addEventListener('pointermove', drawing((event) => {
      if (!this.dragging) return false;
      this.corners[this.chosen] = this.map.at(event);
      this.show();
      return true;
    }), true);
    svg.addEventListener('pointerup', drawing((event) => {
      const still = this.pressed && Math.hypot(event.clientX - this.pressed.clientX, event.clientY - this.pressed.clientY) < clickPixels;
      const held = this.dragging;
      this.dragging = false;
      this.pressed = null;
      if (!held && still && !this.name.readOnly) this.chosen = this.corners.push(this.map.at(event)) - 1;
      this.show();
      return held;
    }), true);
    addEventListener('keydown', (event) => {
      if (this.bar.hidden) return;
      if (event.key === 'Escape') this.close();
      if ((event.key === 'Delete' || event.key === 'Backspace') && event.target !== this.name) this.dropCorner();
    });
  }
}
