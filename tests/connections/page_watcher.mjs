// The page in a browser: node page_watcher.mjs ADDRESS prints where it shows robot r1, a line of JSON whenever that changes.
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

const require = createRequire(fileURLToPath(new URL('../../web/package.json', import.meta.url)));
const { chromium } = require('playwright-core');

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
const page = await browser.newPage();
await page.exposeFunction('say', (line) => console.log(line));
await page.goto(process.argv[2]);
await page.waitForSelector('.robots [data-robot="r1"] .body', { timeout: 60000 });
await page.evaluate(() => {
  let last = '';
  const look = () => {
    const transform = document.querySelector('.robots [data-robot="r1"] .body')?.getAttribute('transform') ?? '';
    if (transform !== last) {
      last = transform;
      const [x, y] = transform.match(/translate\(([\d.-]+) ([\d.-]+)\)/).slice(1).map(Number);
      window.say(JSON.stringify({ now: Date.now() / 1000, x, y }));
    }
  };
  new MutationObserver(look).observe(document.querySelector('.robots'), { subtree: true, childList: true, attributes: true });
});
await new Promise((resolve) => process.on('SIGTERM', resolve));
await browser.close();
