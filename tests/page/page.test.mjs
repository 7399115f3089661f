// The page in headless Chromium, fed by `roomfix demo`: node --test tests/page/page.test.mjs
// ROOMFIX is the program, ROOMFIX_SCREENSHOTS (optional) a folder for pictures to look at.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { tmpdir } from 'node:os';
import { addressOf, launch, picture, program } from './browser.mjs';

let demo;
let address;
let browser;

before(async () => {
  assert.ok(program, 'set ROOMFIX to the roomfix program');
  demo = spawn(program, ['demo', '--port', '0', '--seconds', '170'], { stdio: ['ignore', 'ignore', 'pipe'] });
  address = await addressOf(demo);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  demo?.kill();
});

async function open(options) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  const problems = [];
  page.on('pageerror', (error) => problems.push(String(error)));
  page.on('console', (message) => {
    if (message.type() === 'error' && !message.text().includes('404')) problems.push(message.text());
  });
  await page.goto(address);
  await page.waitForSelector('.robots [data-robot="r1"] .body', { timeout: 60000 });
  return { page, problems, close: () => context.close() };
}

test('robots move on the map', async () => {
  const { page, problems, close } = await open({ viewport: { width: 1280, height: 800 } });
  assert.equal(await page.textContent('#connection'), 'live');
  const place = () => page.getAttribute('.robots [data-robot="r1"] .body', 'transform');
  const first = await place();
  await page.waitForFunction((before) => document.querySelector('.robots [data-robot="r1"] .body').getAttribute('transform') !== before, first, { timeout: 30000 });
  const [x, y] = (await place()).match(/translate\(([\d.-]+) ([\d.-]+)\)/).slice(1).map(Number);
  assert.ok(x > 4 && x < 14 && y > 5 && y < 11.2, `r1 is inside the building, not at ${x}, ${y}`);
  assert.ok((await page.locator('.walls polyline').count()) >= 4);
  assert.equal(await page.locator('.views polygon').count(), 3);
  // Ranges may find a robot before a camera does.
  const byCamera = /± [\d.]+ cm from [^±]*hall/;
  const said = await page.waitForFunction((source) => {
    const text = document.querySelector('#robots').textContent;
    return new RegExp(source).test(text) && text;
  }, byCamera.source, { timeout: 30000 });
  assert.match(await said.jsonValue(), byCamera);
  assert.equal(await page.isVisible('#history'), false, 'there is no history to look at');
  assert.deepEqual(problems, []);
  await close();
});

test('a camera shows its picture with the outline on the robot', async () => {
  const { page, close } = await open({ viewport: { width: 1280, height: 800 } });
  const outline = page.locator('.camera polygon').first();
  await outline.waitFor({ state: 'attached', timeout: 60000 });
  const corners = (await outline.getAttribute('points')).split(' ');
  assert.ok(corners.length >= 4);
  await page.waitForFunction(() => [...document.querySelectorAll('.camera img')].some((i) => i.naturalWidth >= 480), undefined, { timeout: 30000 });
  await picture(page, 'page-light', 6000);
  await close();
});

test('the expected error over the floor', async () => {
  const { page, problems, close } = await open({ viewport: { width: 1280, height: 800 } });
  assert.equal(await page.locator('.errors rect').count(), 0, 'nothing unless it is asked for');
  await page.selectOption('#errors', 'hall1');
  const one = await page.locator('.errors rect').count();
  assert.ok(one > 50, `${one} cells`);
  assert.match(await page.locator('.errors rect title').first().textContent(), /± [\d.]+ c?m/);
  assert.match(await page.textContent('#error-legend'), /95 %.*≤ 1 cm.*more/);
  await page.selectOption('#errors', '*');
  assert.ok((await page.locator('.errors rect').count()) > one);
  await picture(page, 'page-errors');
  await page.selectOption('#errors', '');
  assert.equal(await page.locator('.errors rect').count(), 0);
  assert.deepEqual(problems, []);
  await close();
});

test('dark, and on a phone', async () => {
  const dark = await open({ viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
  const background = await dark.page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  assert.equal(background, 'rgb(18, 22, 20)');
  await picture(dark.page, 'page-dark', 1500);
  await dark.close();
  const phone = await open({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true });
  const width = await phone.page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `nothing sticks out to the side (${width} px)`);
  await picture(phone.page, 'page-phone', 1500);
  await phone.close();
});

test('the data behind the page', async () => {
  const site = await (await fetch(`${address}/api/site`)).json();
  assert.deepEqual(site.cameras.map((c) => c.id), ['hall1', 'hall2', 'hall3', 'up', 'eye']);
  assert.equal(site.cameras[3].robot, 'r1');
  assert.ok(site.cameras[0].errors.cells.every(([, , radius]) => radius > 0) && !site.cameras[3].errors);
  assert.deepEqual(site.landmarks.map((l) => l.points.length), [3, 3, 3, 3, 3, 3]);
  const state = await (await fetch(`${address}/api/state`)).json();
  assert.ok(state.ranges.every((r) => ['r1', 'scout'].includes(r.robot) && r.radius >= 0 && site.beacons.some((b) => b.id === r.beacon)));
  assert.ok(Array.isArray(state.cameras[3].seen.landmarks) && Array.isArray(state.cameras[3].seen.lamps));
  assert.deepEqual(site.corners.map((c) => c.points.length), [3, 3, 3, 3]);
  assert.ok(Array.isArray(state.cameras[4].corner.edges) && Array.isArray(state.cameras[4].corner.rejected));
  assert.ok(state.robots.every((r) => r.cov[0] > 0 && r.cov[2] > 0));
  assert.equal((await fetch(`${address}/api/cameras/nowhere.jpg`)).status, 404);
  assert.equal((await fetch(`${address}/api/history`)).status, 404, 'the demo keeps none');
  const picture = await fetch(`${address}/api/cameras/hall1.jpg`);
  assert.equal(picture.headers.get('content-type'), 'image/jpeg');
});

test('the last hour again, from the history', async () => {
  const folder = mkdtempSync(`${tmpdir()}/roomfix-page-`);
  const quiet = { stdio: 'ignore' };
  execFileSync(program, ['simulate', 'kim2011-drive', '--duration', '3', '-o', `${folder}/s`], quiet);
  const site = `${folder}/s/site.yaml`;
  writeFileSync(site, `${readFileSync(site)}\noutputs:\n  history: {database: fixes.db}\n`);
  execFileSync(program, ['run', site, '--no-page', '--speed', '0'], quiet); // fills the history
  const run = spawn(program, ['run', site, '--port', '0', '--speed', '0.02'], { stdio: ['ignore', 'ignore', 'pipe'] });
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  try {
    await page.goto(await addressOf(run));
    await page.click('#history', { timeout: 30000 });
    const place = async () => {
      const transform = await page.getAttribute('.robots [data-robot="r1"] .body', 'transform');
      return transform.match(/translate\(([\d.-]+) ([\d.-]+)\)/).slice(1).map(Number);
    };
    const truth = readFileSync(`${folder}/s/truth.csv`, 'utf8').trim().split('\n').slice(1).map((line) => line.split(','));
    const expectTruth = async (time) => {
      await page.fill('#past input[type=range]', String(time));
      assert.equal(await page.textContent('#past output'), `${time.toFixed(1)} s`);
      const [, , x, y] = truth.find(([t]) => Math.abs(Number(t) - time) < 0.01).map(Number);
      const [seenX, seenY] = await place();
      assert.ok(Math.hypot(seenX - x, seenY - y) < 0.05, `at ${time} s it was at ${x}, ${y}, and is shown at ${seenX}, ${seenY}`);
    };
    await expectTruth(2.5);
    await expectTruth(0.5);
    assert.equal(await page.locator('.heat rect').count(), 0);
    await page.check('#past input[type=checkbox]');
    const heat = await page.locator('.heat rect title').allTextContents();
    const seconds = heat.reduce((sum, text) => sum + parseFloat(text), 0);
    assert.ok(heat.length >= 3 && Math.abs(seconds - 2.95) < 0.1 * heat.length, `${seconds} s in ${heat.length} cells`);
    await expectTruth(2);
    await picture(page, 'page-history');
    const csv = await (await fetch(new URL(await page.getAttribute('#past a', 'href'), page.url()))).text();
    assert.match(csv, /^time,robot,kind,status,x,y,yaw,/);
    assert.ok(csv.trim().split('\n').length > 80);
    await page.click('#past button >> text=Play');
    await page.waitForFunction(() => document.querySelector('#past input').value === document.querySelector('#past input').max, undefined, { timeout: 30000 });
    await page.click('#past button >> text=Live');
    assert.equal(await page.isVisible('#past'), false);
    assert.equal(await page.locator('.heat rect').count(), 0);
  } finally {
    await page.close();
    const ended = new Promise((resolve) => run.on('exit', resolve));
    run.kill('SIGKILL');
    await ended;
    rmSync(folder, { recursive: true });
  }
});
