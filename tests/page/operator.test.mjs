// What an operator does on the page, and the plan below the map, in headless Chromium: node --test tests/page/operator.test.mjs
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { tmpdir } from 'node:os';
import { fileURLToPath } from 'node:url';
import { addressOf, launch, picture, program } from './browser.mjs';

const token = 'only for operators';
const plan = { width: 60, height: 40, resolution: 0.1, x: -0.6, y: -1.9, degrees: 20, dark: [41, 12] }; // dark: column and row of the one black pixel
const folder = mkdtempSync(`${tmpdir()}/roomfix-operator-`);
const siteFile = `${folder}/site/site.yaml`;
let run;
let address;
let browser;

before(async () => {
  assert.ok(program, 'set ROOMFIX to the roomfix program');
  cpSync(fileURLToPath(new URL('../../examples/labyrinth', import.meta.url)), `${folder}/site`, { recursive: true });
  const pixels = Buffer.alloc(plan.width * plan.height, 235);
  pixels[plan.dark[1] * plan.width + plan.dark[0]] = 0;
  writeFileSync(`${folder}/plan.pgm`, Buffer.concat([Buffer.from(`P5\n${plan.width} ${plan.height}\n255\n`), pixels]));
  const more = `plan: {image: ${folder}/plan.pgm, resolution: ${plan.resolution}, origin: [${plan.x}, ${plan.y}, ${plan.degrees}]}\noutputs: {web: {operator: {env: ROOMFIX_TEST_OPERATOR}}}\n`;
  writeFileSync(siteFile, readFileSync(siteFile, 'utf8') + more);
  run = spawn(program, ['run', siteFile, '--port', '0'], { stdio: ['ignore', 'ignore', 'pipe'], env: { ...process.env, ROOMFIX_TEST_OPERATOR: token } });
  [address, browser] = await Promise.all([addressOf(run), launch()]);
});

after(async () => {
  await browser?.close();
  if (run) {
    const ended = new Promise((resolve) => run.on('exit', resolve));
    run.kill('SIGKILL');
    await ended;
  }
  rmSync(folder, { recursive: true });
});

async function open(options = { viewport: { width: 1280, height: 800 } }) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  await page.goto(address);
  await page.waitForSelector('.plan image', { state: 'attached', timeout: 30000 });
  return { page, close: () => context.close() };
}

/** Where a place of the map is in the window, px. */
function onScreen(page, [x, y]) {
  return page.evaluate(([mapX, mapY]) => {
    const svg = document.querySelector('#map');
    const p = new DOMPoint(mapX, -mapY).matrixTransform(svg.getScreenCTM());
    return [p.x, p.y];
  }, [x, y]);
}

async function clickAt(page, place) {
  await page.mouse.click(...(await onScreen(page, place)));
}

/** The corners of a zone in the site file. */
function written(zone) {
  const found = readFileSync(siteFile, 'utf8').match(new RegExp(`^  ${zone}: (\\[.*\\])$`, 'm'));
  return found ? JSON.parse(found[1]) : null;
}

function assertNear(corners, expected) {
  assert.equal(corners?.length, expected.length);
  corners.forEach(([x, y], i) => assert.ok(Math.hypot(x - expected[i][0], y - expected[i][1]) < 0.02, `corner ${i} is ${x}, ${y}`)); // a pixel or two
}

async function becomeOperator(page) {
  await page.click('#operator');
  await page.fill('#operator-token input', token);
  await page.click('#operator-token [type=submit]');
  await page.waitForSelector('#zone-tool', { state: 'visible' });
}

test('who has not the token changes nothing', async () => {
  const { page, close } = await open();
  await page.waitForSelector('#operator', { state: 'visible' });
  assert.equal(await page.isVisible('#zone-tool'), false);
  await page.click('#operator');
  await page.fill('#operator-token input', 'a guess');
  await page.click('#operator-token [type=submit]');
  await page.waitForFunction(() => document.querySelector('#operator-token .message').textContent.includes('not the operator'));
  await picture(page, 'operator-wrong-token');
  await page.fill('#operator-token input', token);
  await page.click('#operator-token [type=submit]');
  await page.waitForSelector('#zone-tool', { state: 'visible' });
  await page.reload();
  await page.waitForSelector('#zone-tool', { state: 'visible' }); // this tab remembers it
  await page.click('#operator');
  await page.waitForSelector('#zone-tool', { state: 'hidden' });
  await close();
});

test('a zone is drawn, changed and deleted', async () => {
  const { page, close } = await open();
  const other = await open(); // somebody who only looks
  await becomeOperator(page);
  await page.click('#zone-tool');
  for (const corner of [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]) await clickAt(page, corner);
  await picture(page, 'zone-being-drawn');
  await page.fill('#zone-bar input', 'dock');
  await page.click('#zone-bar [type=submit]');
  await page.waitForSelector('#zone-bar', { state: 'hidden' });
  assertNear(written('dock'), [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]);
  await other.page.waitForSelector('.zones [data-zone="dock"]', { state: 'attached', timeout: 30000 });
  await picture(other.page, 'zone-seen-by-a-viewer');

  await page.click('#zone-tool');
  await page.selectOption('#zone-bar select', 'dock');
  await clickAt(page, [2, 2]); // of a zone that is there, a click makes no corner
  await page.mouse.move(...(await onScreen(page, [1, 1]))); // half way between the last corner and the first
  await page.mouse.down();
  await page.mouse.move(...(await onScreen(page, [0.5, 1.5])), { steps: 3 });
  await page.mouse.up();
  await picture(page, 'zone-being-changed');
  await page.click('#zone-bar [type=submit]');
  await page.waitForSelector('#zone-bar', { state: 'hidden' });
  assertNear(written('dock'), [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5]]);

  await page.click('#zone-tool');
  await page.selectOption('#zone-bar select', 'dock');
  await page.click('#zone-bar button >> text=Delete zone');
  await page.waitForSelector('#zone-bar', { state: 'hidden' });
  assert.equal(written('dock'), null);
  await other.page.waitForSelector('.zones [data-zone="dock"]', { state: 'detached', timeout: 30000 });
  await other.close();
  await close();
});

test('what is wrong with a zone is said, and Escape gives it up', async () => {
  const { page, close } = await open();
  await becomeOperator(page);
  const before = readFileSync(siteFile, 'utf8');
  await page.click('#zone-tool');
  await page.fill('#zone-bar input', 'bow');
  const says = (words) => page.waitForFunction((part) => document.querySelector('#zone-bar .message').textContent.includes(part), words);
  await page.click('#zone-bar [type=submit]');
  await says('three corners or more');
  for (const corner of [[0.2, 0.2], [1.2, 0.2], [0.2, 1.2], [1.2, 1.2]]) await clickAt(page, corner);
  await page.click('#zone-bar [type=submit]');
  await says('crosses its own border');
  await picture(page, 'zone-refused');
  await page.keyboard.press('Escape');
  assert.equal(await page.isVisible('#zone-bar'), false);
  assert.equal(await page.locator('.drawn-zone *').count(), 0);
  assert.equal(readFileSync(siteFile, 'utf8'), before);
  await close();
});

test('the plan lies where its file says', async () => {
  const { page, close } = await open();
  await picture(page, 'plan', 500);
  await page.addStyleTag({ content: '#map > g > :not(.plan) { display: none }' });
  await page.evaluate(() => document.querySelector('.plan image').decode?.());
  const screenshot = (await page.screenshot()).toString('base64');
  const [u, v] = await page.evaluate(async (png) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    canvas.drawImage(bitmap, 0, 0);
    const map = document.querySelector('#map').getBoundingClientRect();
    const { data } = canvas.getImageData(0, 0, bitmap.width, map.bottom - 60); // without the scale
    let [count, sumU, sumV] = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4) {
      const [x, y] = [(i / 4) % bitmap.width, Math.floor(i / 4 / bitmap.width)];
      if (x > map.right - 260 || y < map.top + 60 || data[i] > 160) continue; // only the black pixel is that dark
      [count, sumU, sumV] = [count + 1, sumU + x + 0.5, sumV + y + 0.5];
    }
    return [sumU / count, sumV / count];
  }, screenshot);
  const [along, up] = [(plan.dark[0] + 0.5) * plan.resolution, (plan.height - plan.dark[1] - 0.5) * plan.resolution];
  const yaw = (plan.degrees * Math.PI) / 180;
  const expected = await onScreen(page, [plan.x + along * Math.cos(yaw) - up * Math.sin(yaw), plan.y + along * Math.sin(yaw) + up * Math.cos(yaw)]);
  assert.ok(Math.hypot(u - expected[0], v - expected[1]) < 1.5, `the dark pixel is at ${u}, ${v} of the window, not at ${expected}`);
  await close();
});

test('dark, and on a phone', async () => {
  const dark = await open({ viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
  await becomeOperator(dark.page);
  await dark.page.click('#zone-tool');
  await picture(dark.page, 'operator-dark', 300);
  await dark.close();
  const phone = await open({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true });
  await becomeOperator(phone.page);
  await phone.page.tap('#zone-tool');
  for (const corner of [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]) await phone.page.touchscreen.tap(...(await onScreen(phone.page, corner)));
  await phone.page.waitForFunction(() => document.querySelectorAll('.drawn-zone .corner').length === 3);
  const width = await phone.page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `nothing sticks out to the side (${width} px)`);
  await picture(phone.page, 'operator-phone', 300);
  await phone.close();
});
