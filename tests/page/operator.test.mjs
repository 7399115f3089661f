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
let page; // of whoever becomes the operator
let viewer; // somebody else's

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
  const open = async () => {
    const opened = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
    await opened.goto(address);
    await opened.waitForSelector('.plan image', { state: 'attached', timeout: 30000 });
    return opened;
  };
  [page, viewer] = await Promise.all([open(), open()]);
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

/** Where a place of the map is in the window, px. */
function onScreen([x, y], where = page) {
  return where.evaluate(([mapX, mapY]) => {
    const svg = document.querySelector('#map');
    const p = new DOMPoint(mapX, -mapY).matrixTransform(svg.getScreenCTM());
    return [p.x, p.y];
  }, [x, y]);
}

async function clickAt(place) {
  await page.mouse.click(...(await onScreen(place)));
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

async function becomeOperator(where) {
  await where.click('#operator');
  await where.fill('#operator-token input', token);
  await where.click('#operator-token [type=submit]');
  await where.waitForSelector('#zone-tool', { state: 'visible' });
}

test('who has not the token changes nothing', async () => {
  await page.waitForSelector('#operator', { state: 'visible' });
  assert.equal(await page.isVisible('#zone-tool'), false);
  await page.click('#operator');
  await page.fill('#operator-token input', 'a guess');
  await page.click('#operator-token [type=submit]');
  await page.waitForFunction(() => document.querySelector('#operator-token .message').textContent.includes('not the operator'));
  await picture(page, 'operator-wrong-token');
  await page.keyboard.press('Escape');
  await becomeOperator(page);
  await page.click('#operator');
  await page.waitForSelector('#zone-tool', { state: 'hidden' });
  await becomeOperator(page);
  await page.reload();
  await page.waitForSelector('#zone-tool', { state: 'visible' }); // this tab remembers it
});

test('a zone is drawn, changed and deleted', async () => {
  await page.click('#zone-tool');
  for (const corner of [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]) await clickAt(corner);
  await picture(page, 'zone-being-drawn');
  await page.fill('#zone-bar input', 'dock');
  await page.click('#zone-bar [type=submit]');
  await page.waitForSelector('#zone-bar', { state: 'hidden' });
  assertNear(written('dock'), [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]);
  await viewer.waitForSelector('.zones [data-zone="dock"]', { state: 'attached', timeout: 30000 });
  await picture(viewer, 'zone-seen-by-a-viewer');

  await page.click('#zone-tool');
  await page.selectOption('#zone-bar select', 'dock');
  await clickAt([2, 2]); // of a zone that is there, a click makes no corner
  await page.mouse.move(...(await onScreen([1, 1]))); // half way between the last corner and the first
  await page.mouse.down();
  await page.mouse.move(...(await onScreen([0.5, 1.5])), { steps: 3 });
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
  await viewer.waitForSelector('.zones [data-zone="dock"]', { state: 'detached', timeout: 30000 });
});

test('what is wrong with a zone is said, and Escape gives it up', async () => {
  const before = readFileSync(siteFile, 'utf8');
  await page.click('#zone-tool');
  await page.fill('#zone-bar input', 'bow');
  const says = (words) => page.waitForFunction((part) => document.querySelector('#zone-bar .message').textContent.includes(part), words);
  await page.click('#zone-bar [type=submit]');
  await says('three corners or more');
  for (const corner of [[0.2, 0.2], [1.2, 0.2], [0.2, 1.2], [1.2, 1.2]]) await clickAt(corner);
  await page.click('#zone-bar [type=submit]');
  await says('crosses its own border');
  await picture(page, 'zone-refused');
  await page.keyboard.press('Escape');
  assert.equal(await page.isVisible('#zone-bar'), false);
  assert.equal(await page.locator('.drawn-zone *').count(), 0);
  assert.equal(readFileSync(siteFile, 'utf8'), before);
});

test('the plan lies where its file says', async () => {
  await picture(viewer, 'plan', 500);
  await viewer.addStyleTag({ content: '#map > g > :not(.plan) { display: none }' });
  await viewer.evaluate(() => document.querySelector('.plan image').decode?.());
  const screenshot = (await viewer.screenshot()).toString('base64');
  const [u, v] = await viewer.evaluate(async (png) => {
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
  const expected = await onScreen([plan.x + along * Math.cos(yaw) - up * Math.sin(yaw), plan.y + along * Math.sin(yaw) + up * Math.cos(yaw)], viewer);
  assert.ok(Math.hypot(u - expected[0], v - expected[1]) < 1.5, `the dark pixel is at ${u}, ${v} of the window, not at ${expected}`);
});

test('dark, and on a phone', async () => {
  await page.emulateMedia({ colorScheme: 'dark' });
  await page.click('#zone-tool');
  await picture(page, 'operator-dark', 300);
  const phone = await (await browser.newContext({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true })).newPage();
  await phone.goto(address);
  await becomeOperator(phone);
  await phone.tap('#zone-tool');
  for (const corner of [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]) await phone.touchscreen.tap(...(await onScreen(corner, phone)));
  await phone.waitForFunction(() => document.querySelectorAll('.drawn-zone .corner').length === 3);
  const width = await phone.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `nothing sticks out to the side (${width} px)`);
  await picture(phone, 'operator-phone', 300);
});
