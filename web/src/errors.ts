import type { ErrorMap, Site } from './types';

/** Classes of the 95 % error, m, and their colours: dark to light for most kinds of colour vision. */
export const errorClasses: { upTo: number; colour: string; label: string }[] = [
  { upTo: 0.01, colour: '#440154', label: '1 cm' },
  { upTo: 0.02, colour: '#414487', label: '2 cm' },
  { upTo: 0.05, colour: '#2a788e', label: '5 cm' },
  { upTo: 0.1, colour: '#22a884', label: '10 cm' },
  { upTo: 0.2, colour: '#7ad151', label: '20 cm' },
  { upTo: Infinity, colour: '#fde725', label: 'more' },
];

export const bestOfAll = '*';

export function colourOfError(radius: number): string {
  return errorClasses.find((c) => radius <= c.upTo)!.colour;
}

export function errorText(radius: number): string {
  return radius < 1 ? `± ${(100 * radius).toFixed(1)} cm` : `± ${radius.toFixed(1)} m`;
}

/** One camera's errors, or everywhere those of the camera that knows best. */
export function errorsOf(site: Site, camera: string): ErrorMap[] {
  const maps = site.cameras.filter((c) => c.errors && (camera === bestOfAll || c.id === camera)).map((c) => c.errors!);
  if (camera !== bestOfAll || maps.length < 2) return maps;
  const cell = Math.max(...maps.map((m) => m.cell));
  const best = new Map<string, [number, number, number]>();
  for (const map of maps) {
    for (const [x, y, radius] of map.cells) {
      const [i, j] = [Math.floor(x / cell), Math.floor(y / cell)];
      const known = best.get(`${i},${j}`);
      if (!known || radius < known[2]) best.set(`${i},${j}`, [(i + 0.5) * cell, (j + 0.5) * cell, radius]);
    }
  }
  return [{ cell, cells: [...best.values()] }];
}
