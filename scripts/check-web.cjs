// Tries the page in headless Chromium: it draws, moves, follows a dragged target, says what is wrong with a bad bundle,
// and writes nothing to the console. `node scripts/check-web.cjs PAGE CHROMIUM [FOLDER FOR PICTURES]`
const fs = require('fs');
const http = require('http');
const path = require('path');
const puppeteer = require('puppeteer-core');

const [page_folder, chromium, pictures] = process.argv.slice(2);
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm' };
const wait = (ms) => new Promise((go) => setTimeout(go, ms));

function serve() {
  const server = http.createServer((request, answer) => {
    const name = new URL(request.url, 'http://x').pathname.slice(1) || 'index.html';
    if (name === 'bad.throng') return answer.end('this is no bundle at all');
    if (name === 'favicon.ico') { answer.statusCode = 204; return answer.end(); }
    const file = path.join(page_folder, path.basename(name));
    if (!fs.existsSync(file)) { answer.statusCode = 404; return answer.end(); }
    answer.setHeader('Content-Type', TYPES[path.extname(file)] ?? 'application/octet-stream');
    fs.createReadStream(file).pipe(answer);
  });
  return new Promise((go) => server.listen(0, '127.0.0.1', () => go(server)));
}

function check(what, good) {
  console.log(`${good ? 'ok  ' : 'FAIL'} ${what}`);
  if (!good) process.exitCode = 1;
}

(async () => {
  const server = await serve();
  const base = `http://127.0.0.1:${server.address().port}/`;
  const args = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'];
  const browser = await puppeteer.launch({ executablePath: chromium, headless: true, args, protocolTimeout: 600000 });
  const said = [];
  const open = async (url) => {
    const page = await browser.newPage();
    await page.setViewport({ width: 800, height: 500 });
    page.on('console', (m) => { if (['error', 'warning', 'warn'].includes(m.type()) && !m.text().includes('GPU stall')) said.push(m.text()); });
    page.on('pageerror', (e) => said.push(String(e)));
    await page.goto(url);
    await page.waitForFunction(() => window.throng && (document.getElementById('figures').textContent.includes('frame') || document.getElementById('fault').textContent), { timeout: 120000 });
    return page;
  };
  const text = (page, id) => page.$eval(`#${id}`, (e) => e.textContent);
  const picture = async (page, name) => {
    const path_ = pictures ? path.join(pictures, `web-${name}.png`) : undefined;
    return page.screenshot({ path: path_ });
  };
  const places = (page) => page.evaluate(() => {
    const words = window.throng.records();
    const floats = new Float32Array(words.buffer);
    return Array.from({ length: words.length / 8 }, (_, k) => [floats[8 * k + 4], floats[8 * k + 6]]);
  });

  const page = await open(base);
  await wait(4000);
  const [first, before] = [await picture(page, 'people'), await places(page)];
  check('a thousand people are there', before.length === 1000);
  await wait(3000);
  const [second, after] = [await picture(page, 'people-later'), await places(page)];
  check('the picture changes', !Buffer.from(first).equals(Buffer.from(second)));
  check('people move', after.filter(([x, z], k) => Math.hypot(x - before[k][0], z - before[k][1]) > 0.3).length > 200);
  const colours = await page.evaluate(() => {
    const canvas = document.querySelector('canvas');
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext('2d');
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add((data[i] >> 4) << 8 | (data[i + 1] >> 4) << 4 | data[i + 2] >> 4);
    return seen.size;
  });
  check(`people are drawn: ${colours} colours`, colours > 60);
  // A ring is dragged towards the middle of the picture.
  const ring = await page.evaluate(() => {
    const { camera, targets } = window.throng;
    const p = targets[0].position.clone().project(camera);
    return [(p.x + 1) / 2 * innerWidth, (1 - p.y) / 2 * innerHeight, targets[0].position.x, targets[0].position.z];
  });
  await page.mouse.move(ring[0], ring[1]);
  await page.mouse.down();
  await page.mouse.move(420, 340, { steps: 8 });
  await page.mouse.up();
  const moved = await page.evaluate(() => { const t = window.throng.targets[0].position; return [t.x, t.z]; });
  check('a ring follows the mouse', Math.hypot(moved[0] - ring[2], moved[1] - ring[3]) > 2);
  const far = (all) => all.filter((_, k) => k % 6 === 0).reduce((sum, [x, z]) => sum + Math.hypot(x - moved[0], z - moved[1]), 0) / 167;
  const far_before = far(await places(page));
  await wait(6000);
  const far_after = far(await places(page));
  check(`its people come nearer: ${far_before.toFixed(1)} to ${far_after.toFixed(1)} m`, far_after < far_before);
  console.log(await text(page, 'figures'));
  await page.select('#scene', 'agents');
  await wait(4000);
  const crossing = await places(page);
  await wait(2000);
  await picture(page, 'agents');
  const later = await places(page);
  check('agents cross', later.filter(([x, z], k) => Math.hypot(x - crossing[k][0], z - crossing[k][1]) > 0.3).length > 500);
  console.log(await text(page, 'figures'));
  check(`nothing is said to the console ${said.join('; ')}`, said.length === 0);
  await page.close();
  const bad = await open(`${base}?bundle=bad.throng`);
  const why = await text(bad, 'fault');
  await picture(bad, 'bad');
  check(`a bad bundle says why: ${why}`, /bad\.throng.*Throng/.test(why));
  check('nor then', said.length === 0);
  await browser.close();
  server.close();
})().catch((e) => { console.error(e); process.exit(1); });
