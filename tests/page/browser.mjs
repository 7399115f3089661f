// A headless Chromium and a program that shows its page, for the tests of the page.
// ROOMFIX is the program, ROOMFIX_SCREENSHOTS (optional) a folder for pictures to look at.
import { mkdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

const require = createRequire(fileURLToPath(new URL('../../web/package.json', import.meta.url)));
const { chromium } = require('playwright-core');
const screenshots = process.env.ROOMFIX_SCREENSHOTS;

export const program = process.env.ROOMFIX;

export function launch() {
  if (screenshots) mkdirSync(screenshots, { recursive: true });
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
           '--disable-component-update', '--disable-sync'],
  });
}

/** Where a program that has just been started shows its page. */
export function addressOf(started) {
  return new Promise((resolve, reject) => {
    let said = '';
    started.stderr.on('data', (text) => {
      said += text;
      const found = said.match(/http:\/\/[\d.:]+/);
      if (found) resolve(found[0]);
    });
    started.on('exit', () => reject(new Error(`the program ended: ${said}`)));
  });
}

/** A picture to be looked at, where they are asked for; `settled` ms later. */
export async function picture(page, name, settled = 0) {
  if (!screenshots) return;
  await page.waitForTimeout(settled);
  await page.screenshot({ path: `${screenshots}/${name}.png` });
}
