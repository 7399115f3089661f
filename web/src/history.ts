// The last hour again: a slider over time, a heat map of where robots were, and the fixes as CSV.
import './history.css';
import { made } from './made';
import type { HeatCell } from './map';
import type { RecordedFix, RobotState } from './types';

const span = 3600; // s that can be looked at again
const most = 100000; // fixes that are fetched
const freshness = 1; // s: a robot whose last fix is older is not shown
const cell = 0.25; // m, edge of the heat map's cells
const speeds = [1, 10, 60];

/** A moment for people: the time of day, or seconds where the recording's clock began at zero. */
export function clockText(time: number): string {
  return time > 1e8 ? new Date(time * 1000).toLocaleTimeString() : `${time.toFixed(1)} s`;
}

function stateOf(fix: RecordedFix): RobotState {
  const [xx, xy, , , yy, , , , yawyaw] = fix.covariance;
  const known = fix.robot !== null;
  return { id: fix.robot ?? fix.id ?? '', status: known ? fix.status : 'unknown', x: fix.x, y: fix.y, yaw: fix.yaw ?? null, cov: [xx, xy, yy, yawyaw], sources: fix.sources };
}

/** The fixes of each robot, in the order of their times. */
function tracksOf(fixes: RecordedFix[]): Map<string, RecordedFix[]> {
  const tracks = new Map<string, RecordedFix[]>();
  for (const fix of fixes) {
    const name = fix.robot ?? fix.id ?? '';
    const track = tracks.get(name);
    if (track) track.push(fix);
    else tracks.set(name, [fix]);
  }
  return tracks;
}

/** For how long robots were in each cell of the floor: every fix counts until the robot's next one. */
export function heatOf(tracks: Iterable<RecordedFix[]>): HeatCell[] {
  const cells = new Map<string, HeatCell>();
  for (const track of tracks) {
    track.forEach((fix, i) => {
      const seconds = Math.min((track[i + 1]?.time ?? fix.time) - fix.time, freshness);
      const x = Math.floor(fix.x / cell);
      const y = Math.floor(fix.y / cell);
      const entry = cells.get(`${x} ${y}`) ?? { x: x * cell, y: y * cell, size: cell, seconds: 0 };
      entry.seconds += seconds;
      cells.set(`${x} ${y}`, entry);
    });
  }
  return [...cells.values()].filter((entry) => entry.seconds > 0);
}

export class Past {
  /** The map shows the past; what is live waits. */
  shown = false;
  private readonly button = made('button', { id: 'history', type: 'button', title: 'The last hour again', textContent: 'History', hidden: true });
  private readonly bar = made('div', { id: 'past', hidden: true });
  private readonly play = made('button', { type: 'button', textContent: 'Play' });
  private readonly slider = made('input', { type: 'range', min: '0', step: 'any', ariaLabel: 'Time' });
  private readonly clock = made('output', {});
  private readonly speed = made('select', { ariaLabel: 'Speed' });
  private readonly heat = made('input', { type: 'checkbox' });
  private readonly csv = made('a', { textContent: 'CSV', download: 'fixes.csv' });
  private readonly live = made('button', { type: 'button', textContent: 'Live' });
  private tracks = new Map<string, RecordedFix[]>();
  private begin = 0; // s
  private last = 0; // s, the moment that is shown
  private playing = false;

  constructor(
    panel: Element,
    tools: Element,
    private readonly show: (robots: RobotState[], time: number) => void,
    private readonly showHeat: (cells: HeatCell[]) => void,
  ) {
    for (const factor of speeds) this.speed.append(new Option(`${factor} x`, String(factor)));
    this.speed.value = '10';
    const heatLabel = made('label', {});
    heatLabel.append(this.heat, ' Heat map');
    this.bar.append(this.play, this.slider, this.clock, this.speed, heatLabel, this.csv, this.live);
    panel.append(this.bar);
    tools.prepend(this.button);
    this.button.onclick = () => void this.open();
    this.live.onclick = () => this.close();
    this.slider.oninput = () => this.go(this.begin + Number(this.slider.value));
    this.heat.onchange = () => this.showHeat(this.heat.checked ? heatOf(this.tracks.values()) : []);
    this.play.onclick = () => this.setPlaying(!this.playing);
  }

  /** Shows the button if there is a history. */
  async offer(): Promise<void> {
    const answer = await fetch('api/history?limit=1').catch(() => null);
    this.button.hidden = !answer || answer.status === 404;
  }

  private async open(): Promise<void> {
    const newest = await this.fetchFixes('limit=1');
    if (newest.length === 0) return;
    const question = `from=${(newest[0].time - span).toFixed(3)}&to=${(newest[0].time + 0.001).toFixed(3)}&limit=${most}`;
    const fixes = (await this.fetchFixes(question)).reverse(); // beyond the limit the oldest are left out
    if (fixes.length === 0) return;
    this.tracks = tracksOf(fixes);
    this.begin = fixes[0].time;
    const end = fixes[fixes.length - 1].time;
    this.slider.max = String(end - this.begin);
    this.slider.value = this.slider.max;
    this.csv.href = `api/history?${question}&order=oldest&format=csv`;
    this.shown = true;
    this.bar.hidden = false;
    this.go(end);
  }

  private close(): void {
    this.setPlaying(false);
    this.shown = false;
    this.bar.hidden = true;
    this.heat.checked = false;
    this.showHeat([]);
    this.show([], this.last); // what is live comes with the next state
  }

  private async fetchFixes(question: string): Promise<RecordedFix[]> {
    const answer = await fetch(`api/history?${question}`).catch(() => null);
    if (!answer?.ok) {
      this.button.title = answer ? await answer.text() : 'no connection';
      return [];
    }
    const lines = (await answer.text()).split('\n').filter((line) => line);
    return lines.map((line) => JSON.parse(line) as RecordedFix).filter((fix) => fix.status === 'ok' || fix.status === 'coasting');
  }

  /** The last fix of each robot at a moment. */
  private at(time: number): RobotState[] {
    const states: RobotState[] = [];
    for (const track of this.tracks.values()) {
      let low = 0;
      let high = track.length;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (track[middle].time <= time + 1e-6) low = middle + 1;
        else high = middle;
      }
      if (low > 0 && time - track[low - 1].time <= freshness) states.push(stateOf(track[low - 1]));
    }
    return states;
  }

  private go(time: number): void {
    if (time < this.last || time - this.last > 2 * freshness) this.show([], time); // no trail across a jump
    this.last = time;
    this.clock.textContent = clockText(time);
    this.show(this.at(time), time);
  }

  private setPlaying(playing: boolean): void {
    this.playing = playing;
    this.play.textContent = playing ? 'Pause' : 'Play';
    if (!playing) return;
    if (this.slider.value === this.slider.max) this.slider.value = '0';
    let before = performance.now();
    const step = (now: number) => {
      if (!this.playing) return;
      const length = Number(this.slider.max);
      const next = Math.min(Number(this.slider.value) + ((now - before) / 1000) * Number(this.speed.value), length);
      before = now;
      this.slider.value = String(next);
      this.go(this.begin + next);
      if (next < length) requestAnimationFrame(step);
      else this.setPlaying(false);
    };
    requestAnimationFrame(step);
  }
}
