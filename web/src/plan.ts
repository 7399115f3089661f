import { add } from './svg';
import type { Plan, Point } from './types';

/** Where the picture's corners are on the map, from its lower left one counter-clockwise. */
export function planCorners(plan: Plan | undefined): Point[] {
  if (!plan) return [];
  const [cos, sin] = [Math.cos(plan.yaw), Math.sin(plan.yaw)];
  const sides: Point[] = [[0, 0], [plan.width, 0], [plan.width, plan.height], [0, plan.height]];
  return sides.map(([u, v]) => [plan.x + plan.resolution * (u * cos - v * sin), plan.y + plan.resolution * (u * sin + v * cos)]);
}

/** The picture in a layer of the map. Its first row is its upper edge; its lower left corner lies where the plan says. */
export function showPlan(layer: SVGGElement, plan: Plan | undefined): void {
  layer.replaceChildren();
  if (!plan) return;
  const [width, height] = [plan.width * plan.resolution, plan.height * plan.resolution];
  const transform = `translate(${plan.x} ${plan.y}) rotate(${(plan.yaw * 180) / Math.PI}) translate(0 ${height}) scale(1 -1)`;
  add(layer, 'image', { href: 'api/plan.png', width, height, transform, preserveAspectRatio: 'none' });
}
