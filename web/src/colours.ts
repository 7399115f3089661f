// Colours that differ for most kinds of colour vision, on light and on dark ground.
const hues = ['#0b7a75', '#d1661c', '#6a5acd', '#b0304f', '#2f7d32', '#8a6d00', '#1f6fb5', '#7b4a2e'];
const given = new Map<string, string>();

/** The same colour for the same robot as long as the page is open. */
export function colourOf(robot: string): string {
  if (/^unknown-\d+$/.test(robot)) return '#808080'; // what is no robot
  let colour = given.get(robot);
  if (!colour) {
    colour = hues[given.size % hues.length];
    given.set(robot, colour);
  }
  return colour;
}
