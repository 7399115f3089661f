import './style.css';
import { CameraCard } from './cameras';
import { colourOf } from './colours';
import { bestOfAll, errorClasses, errorsOf, errorText } from './errors';
import { clockText, Past } from './history';
import { FloorMap } from './map';
import { Operator } from './operator';
import type { RobotState, SenseState, SinkState, Site, State, Zone, ZoneEvent } from './types';
import { ZoneTool } from './zones';

function element<T extends Element = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as unknown as T;
}

const connection = element('connection');
const map = new FloorMap(element<SVGSVGElement>('map'), (metres, pixels) => {
  const scale = element('scale');
  scale.querySelector('span')!.textContent = metres < 1 ? `${metres * 100} cm` : `${metres} m`;
  scale.querySelector('i')!.style.width = `${pixels}px`;
});
const cards = new Map<string, CameraCard>();
const rows = new Map<string, HTMLElement>();
const past = new Past(
  element('map-panel'),
  element('map-tools'),
  (robots, time) => {
    map.setRanges([]);
    showRobotsAt(robots, time);
  },
  (cells) => map.setHeat(cells),
);

const zoneTool = new ZoneTool(map, element('map-panel'), element('map-tools'), (...change) => operator.send(...change), showZones);
const operator = new Operator(document.querySelector('header')!, (yes) => zoneTool.allow(yes));
let shownVersion = 0; // of the site

function showZones(zones: Zone[]): void {
  map.setZones(zones);
  zoneTool.setZones(zones);
}

function connected(state: 'live' | 'connecting' | 'lost'): void {
  connection.textContent = state === 'lost' ? 'connection lost' : state;
  connection.dataset.status = state === 'live' ? 'ok' : state === 'lost' ? 'failed' : 'waiting';
}

/** The choice of an error map, for those cameras that have one. */
function offerErrors(site: Site): void {
  const choice = element<HTMLSelectElement>('errors');
  const before = choice.value;
  const cameras = site.cameras.filter((c) => c.errors?.cells.length);
  choice.hidden = cameras.length === 0;
  const options: [string, string][] = [['', 'No error map'], ...(cameras.length > 1 ? [[bestOfAll, 'Error: best camera'] as [string, string]] : [])];
  for (const camera of cameras) options.push([camera.id, `Error: ${camera.id}`]);
  choice.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  if (options.some(([value]) => value === before)) choice.value = before;
  const legend = element('error-legend');
  legend.replaceChildren(
    'Expected 95 % error',
    ...errorClasses.map((c) => {
      const entry = document.createElement('span');
      entry.style.setProperty('--class', c.colour);
      entry.textContent = c.upTo === Infinity ? c.label : `≤ ${c.label}`;
      return entry;
    }),
  );
  choice.onchange = () => {
    legend.hidden = !choice.value;
    map.setErrors(choice.value ? errorsOf(site, choice.value) : []);
  };
}

function showSite(site: Site): void {
  element('site-name').textContent = site.name;
  document.title = `${site.name} - roomfix`;
  map.setSite(site);
  zoneTool.setZones(site.zones);
  offerErrors(site);
  const list = element('cameras');
  list.replaceChildren();
  cards.clear();
  for (const camera of site.cameras) {
    const card = new CameraCard(camera);
    cards.set(camera.id, card);
    list.append(card.element);
  }
}

/** Radius of the 95 % ellipse's longer axis, in words. */
function uncertainty([xx, xy, yy]: RobotState['cov']): string {
  const largest = (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy);
  return errorText(Math.sqrt(5.991 * Math.max(largest, 0)));
}

function showRobots(robots: RobotState[]): void {
  const list = element('robots');
  const present = new Set(robots.map((r) => r.id));
  for (const [id, row] of rows) {
    if (present.has(id)) continue;
    row.remove();
    rows.delete(id);
  }
  list.classList.toggle('empty', robots.length === 0);
  for (const robot of robots) {
    let row = rows.get(robot.id);
    if (!row) {
      row = document.createElement('div');
      row.className = 'robot';
      row.innerHTML = '<i></i><b></b><span class="pill"></span><span class="place"></span><span class="quiet"></span>';
      row.style.setProperty('--robot', colourOf(robot.id));
      row.querySelector('b')!.textContent = robot.id;
      rows.set(robot.id, row);
      list.append(row);
    }
    const status = row.querySelector<HTMLElement>('.pill')!;
    status.textContent = robot.status;
    status.dataset.status = robot.status;
    const yaw = robot.yaw === null ? '' : `, ${((robot.yaw * 180) / Math.PI).toFixed(1)}°`;
    row.querySelector('.place')!.textContent = `${robot.x.toFixed(3)}, ${robot.y.toFixed(3)} m${yaw}${robot.zones?.length ? `, in ${robot.zones.join(', ')}` : ''}`;
    row.querySelector('.quiet')!.textContent = `${uncertainty(robot.cov)}${robot.sources.length ? ` from ${robot.sources.join(', ')}` : ''}${robot.identity === undefined ? '' : `; its name is ${Math.round(100 * robot.identity)} % sure`}`;
  }
}

/** How long the stages take that a user can do something about, and how late fixes are. */
function stagesText(stages: NonNullable<State['stages']>): string {
  const names: [string, string][] = [
    ['look', 'one camera looks'],
    ['fit', 'all together'],
    ['latency', 'from frame to fix'],
  ];
  const known = names.filter(([stage]) => stages[stage]);
  return known.map(([stage, name]) => `${name} ${stages[stage][0].toFixed(0)} ms (95 %: ${stages[stage][1].toFixed(0)})`).join(', ');
}

/** Rows of a list below a heading that is hidden while there are none: a name, perhaps a state, and a sentence. */
function showRows(section: string, list: string, rows: { name: string; status?: string; text: string }[]): void {
  element(section).hidden = rows.length === 0;
  element(list).replaceChildren(
    ...rows.map(({ name, status, text }) => {
      const row = document.createElement('div');
      row.className = 'connection-row';
      row.innerHTML = '<b></b><span></span><span class="quiet"></span>';
      row.querySelector('b')!.textContent = name;
      if (status) {
        const pill = row.querySelector<HTMLElement>('span')!;
        pill.className = 'pill';
        pill.textContent = status;
        pill.dataset.status = status;
      }
      row.querySelector('.quiet')!.textContent = text;
      return row;
    }),
  );
}

function showSinks(sinks: SinkState[]): void {
  const lost = (sink: SinkState): string[] => (sink.lost ? [`${sink.lost} messages lost`] : []);
  showRows('outputs', 'sinks', sinks.map((s) => ({ name: s.name, status: s.status, text: [...(s.message ? [s.message] : []), ...lost(s)].join('; ') })));
}

function showSenses(senses: SenseState[]): void {
  showRows('inputs', 'senses', senses.map((s) => ({ name: s.source, text: [`${s.readings} readings`, ...(s.message ? [s.message] : [])].join('; ') })));
}

function showZoneEvents(events: ZoneEvent[]): void {
  const shown = events.slice(-8).reverse();
  showRows('zone-events', 'events', shown.map((e) => ({ name: `${e.robot} ${e.event === 'enter' ? 'enters' : 'leaves'} ${e.zone}`, text: clockText(e.time) })));
}

function showRobotsAt(robots: RobotState[], time: number): void {
  map.setRobots(robots, time);
  showRobots(robots);
}

function showState(state: State): void {
  if (!past.shown) {
    map.setRanges(state.ranges ?? []);
    showRobotsAt(state.robots, state.time);
  }
  element('stages').textContent = stagesText(state.stages ?? {});
  showSinks(state.sinks ?? []);
  showSenses(state.senses ?? []);
  showZoneEvents(state.zone_events ?? []);
  for (const camera of state.cameras) cards.get(camera.id)?.show(camera);
}

function listen(): void {
  const events = new EventSource('api/events');
  events.onopen = () => connected('live');
  events.onerror = () => connected('lost'); // the browser tries again by itself
  events.addEventListener('state', (event) => {
    connected('live');
    const state = JSON.parse((event as MessageEvent<string>).data) as Partial<State>;
    if (!state.robots || !state.cameras) return;
    showState(state as State);
    if (state.site !== shownVersion) void fetchSite();
  });
}

let fetching = false;

/** True once the site is shown as it is now. */
async function fetchSite(): Promise<boolean> {
  if (fetching) return false;
  fetching = true;
  const answer = await fetch('api/site').catch(() => null);
  const site = answer?.ok ? ((await answer.json()) as Site) : null;
  fetching = false;
  if (!site) return false;
  shownVersion = site.version;
  showSite(site);
  void past.offer();
  void operator.offer();
  return true;
}

async function start(): Promise<void> {
  while (!(await fetchSite())) {
    connected('lost');
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
  listen();
}

element('zoom-in').addEventListener('click', () => map.zoom(1.4));
element('zoom-out').addEventListener('click', () => map.zoom(1 / 1.4));
element('zoom-fit').addEventListener('click', () => map.fit());

const root = document.documentElement;
const stored = localStorage.getItem('roomfix-theme');
if (stored) root.dataset.theme = stored;
element('theme').addEventListener('click', () => {
  const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  root.dataset.theme = dark ? 'light' : 'dark';
  localStorage.setItem('roomfix-theme', root.dataset.theme);
});

void start();
