// The replay: a world, its runs, a clock.
import { Address, number, read as readAddress } from './address.js';
import { locate, read, signal } from './data.js';
import { rutGradient } from './dig.js';
import { Keys, nameOf } from './keys.js';
import { Plots } from './plots.js';
import { contextOf, Stage, VIEWS } from './stage.js';
import { tellEnd, tellMap, tellRun, tellTask, tellTrail } from './told.js';
import { WheelPanel } from './wheels.js';

const $ = (id) => document.getElementById(id);
const begun = performance.now();
// What a page tells whose script isn't beside it.
$('alone')?.remove();
const data = read();
const canvas = $('view');
const context = contextOf(canvas);
// None without WebGL: then curves, wheels and what is told of the runs are all there is.
const stage = context ? new Stage(canvas, context, data) : null;
const SPEEDS = [...$('speed').options].map((option) => Number(option.value));
const NARROW = 720;
const TRAIL = 'speed'; // by what it is coloured at first

let time = 0;
let playing = false;
let speed = 1;
let followed = 0;
let mode = 'follow';

const plots = new Plots(data, $('plots'), (t) => { play(false); seek(t); });
const wheels = new WheelPanel($('wheels'));
const address = new Address(() => [
  ['t', number(time)],
  ...(data.runs.length > 1 ? [['run', followed + 1]] : []),
  ['view', mode],
  ...(stage?.view ?? []),
  ...(stage && $('trail').value !== TRAIL ? [['trail', $('trail').value]] : []),
  ...(hidden().length ? [['hide', hidden().join()]] : []),
  ...(stage?.senses.some((s) => !s.labels) ? [['depth', 'distance']] : []),
]);

function ends(which) {
  let most = 0;
  for (const run of data.runs) {
    for (let k = 0; k < run.times.length; k += 1) most = Math.max(most, Math.abs(signal(run, k, which)));
  }
  return most;
}
const MOST = { speed: Math.max(ends(0), 0.1), roll: Math.min(Math.max(ends(1), 1), 45) };
function colourTrails(by) {
  for (const run of stage?.runs ?? []) run.colourTrail(by, MOST[by] ?? 1);
  tellTrail(by, MOST[by] ?? 1);
  if (stage) stage.dirty = true;
  address.changed(playing);
}

function showMap() {
  tellMap(stage && mode === 'top' ? stage.metresPerPixel : null);
  address.changed(playing);
}

function show() {
  const run = data.runs[followed];
  stage?.show(time);
  stage?.showSenses($('depth-image'));
  wheels.show(locate(run.times, time)[0]);
  $('slider').value = time;
  $('slider').setAttribute('aria-valuetext', `${time.toFixed(1)} s`);
  $('time').textContent = `${time.toFixed(2)} / ${data.end.toFixed(2)} s`;
  plots.cursor(time, locate);
  tellEnd(run, time);
  address.changed(playing);
}

function seek(t) {
  time = Math.min(data.end, Math.max(0, t));
  show();
}

function look(to) {
  mode = to;
  for (const b of document.querySelectorAll('#camera button')) b.setAttribute('aria-pressed', b.value === mode);
  stage?.look(mode);
  showMap();
}

function play(on) {
  playing = on;
  if (playing && time >= data.end) time = 0;
  $('play').textContent = playing ? '❚❚' : '▶';
  $('play').setAttribute('aria-label', playing ? 'Pause' : 'Play');
}

function pace(to) {
  speed = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, to))];
  $('speed').value = speed;
}

function follow(k) {
  followed = k;
  document.querySelectorAll('#runs li').forEach((li, i) => li.setAttribute('aria-current', i === k));
  stage?.follow(k);
  plots.followed = k;
  plots.make();
  wheels.make(data.runs[k]);
  tellRun(data.runs[k]);
  look(mode);
  show();
}

tellTask(data, follow);
const slider = $('slider');
slider.max = data.end;
slider.step = 0.01;
slider.addEventListener('input', () => { play(false); seek(Number(slider.value)); });
$('play').addEventListener('click', () => play(!playing));
$('speed').addEventListener('change', () => pace($('speed').selectedIndex));
$('trail').addEventListener('change', (e) => colourTrails(e.target.value));
$('camera').addEventListener('click', (e) => { const b = e.target.closest('button'); if (b) look(b.value); });
// The depth camera's image as kinds of ground, or as distances.
function showDepth(labels) {
  for (const sensed of stage?.senses ?? []) sensed.labels = labels;
  stage?.showSenses($('depth-image'));
  address.changed(playing);
}
$('depth').addEventListener('click', () => showDepth(!stage?.senses[0]?.labels));

// What can be shown or not: the box, its key, what it is, whether there is any, what it does.
const seen = Boolean(stage);
const senses = (name) => [seen && stage.senses.some((s) => s.has[name]), (on) => {
  stage.wanted[name] = on;
  stage.showSenses($('depth-image'));
}];
const TOGGLES = [
  ['classes', 'g', 'terrain classes', seen, (on) => stage.world.showClasses(on)],
  ['obstacles', 'o', 'obstacles', seen, (on) => { stage.world.obstacles.visible = on; }],
  ['path', 'y', 'global path, start and goal', seen, (on) => { stage.world.path.visible = on; }],
  ['ruts', 'f', 'ruts of the followed run', seen && data.runs.some((r) => r.ruts.count), (on) => {
    stage.digs = on;
    $('rut-scale').hidden = !on;
    stage.showRuts();
  }],
  ['plan', 'i', 'plan of the planner', seen && stage.runs.some((r) => r.plans.length), (on) => {
    for (const plan of stage.runs.flatMap((run) => run.plans)) plan.lines.visible = on;
  }],
  ['ghosts', 'h', 'the other runs', seen && data.runs.length > 1, (on) => { stage.ghosts = on; stage.showRuns(); }],
  ['hull', 'x', 'hull; off: axles and links are visible', seen, (on) => { stage.through = !on; stage.showRuns(); }],
  ['beside', 'b', 'curves and wheels', true, (on) => { $('plots').parentElement.hidden = !on; plots.draw(); }],
  ['lidar', 'l', 'points of the lidar', ...senses('lidar')],
  ['map', 'm', 'local map', ...senses('map')],
  ['depth', 'z', 'image of the depth camera', ...senses('depth')],
  ['estimate', 'e', 'estimated trajectory', ...senses('estimate')],
];
const box = (name) => document.querySelector(`#toggles input[name=${name}]`);
for (const [name, key, text, there, act] of TOGGLES) {
  const input = box(name);
  input.parentElement.hidden = !there;
  input.parentElement.title = `${text} (key ${key})`;
  input.addEventListener('change', () => { act(input.checked); if (stage) stage.dirty = true; address.changed(playing); });
}
// What could be seen and is not. Whether there is room for curves beside the view is the screen's affair.
const OF_THE_SCREEN = 'beside';
function hidden() {
  return TOGGLES.filter(([name, , , there]) => there && name !== OF_THE_SCREEN && !box(name).checked).map(([name]) => name);
}
function hide(names) {
  for (const [name, , , there] of TOGGLES) {
    if (there && name !== OF_THE_SCREEN && box(name).checked === names.includes(name)) box(name).click();
  }
}

const go = (id) => () => $(id)?.click();
const held = (e) => (e.shiftKey ? 1 : 0.1);
const step = (seconds) => { play(false); seek(time + seconds); };
const frameBeside = (n) => {
  const { times } = data.runs[followed];
  const [k, share] = locate(times, time);
  play(false);
  seek(times[Math.min(times.length - 1, Math.max(0, n < 0 && share > 1e-6 ? k : k + n))]);
};
const KEYS = [
  ['Time', [
    [[' '], ['space'], 'play, pause', () => play(!playing)],
    [['ArrowLeft', 'ArrowRight'], ['←', '→'], 'back, forward by a tenth of a second; with shift by a second',
      (e) => step(e.key === 'ArrowLeft' ? -held(e) : held(e))],
    [[',', '.'], [',', '.'], 'the frame before, after', (e) => frameBeside(e.key === ',' ? -1 : 1)],
    [['Home', 'End'], ['home', 'end'], 'to the start, to the end', (e) => seek(e.key === 'Home' ? 0 : data.end)],
    [['<', '>'], ['<', '>'], 'slower, faster', (e) => pace(SPEEDS.indexOf(speed) + (e.key === '<' ? -1 : 1))],
  ]],
  ['View', [
    [['1', '2', '3', '4', '5'], ['1', '2', '3', '4', '5'], VIEWS.join(', '), (e) => look(VIEWS[Number(e.key) - 1])],
    [['w', 'a', 's', 'd'], ['w', 'a', 's', 'd'], 'turn the camera; from above, move the map',
      (e) => stage?.move({ a: -1, d: 1 }[nameOf(e)] ?? 0, { w: 1, s: -1 }[nameOf(e)] ?? 0)],
    [['+', '=', '-'], ['+', '−'], 'nearer, farther', (e) => stage?.zoom(e.key === '-' ? 1 / 1.25 : 1.25)],
    [['c'], ['c'], 'reset the view to the vehicle', () => look(mode)],
    [['t'], ['t'], 'colour the trail by speed, by roll, by run', () => {
      const by = $('trail');
      by.selectedIndex = (by.selectedIndex + 1) % by.options.length;
      colourTrails(by.value);
    }],
  ]],
  ['Runs and tasks', [
    [['r'], ['r'], 'follow the next run; with shift the previous run', (e) => follow((followed + (e.shiftKey ? data.runs.length - 1 : 1)) % data.runs.length)],
    [['p', 'n'], ['p', 'n'], 'previous, next replay of the report', (e) => go(nameOf(e) === 'p' ? 'previous' : 'next')()],
    [['u'], ['u'], 'up to the report', go('report')],
    [['?'], ['?'], 'this list; escape closes it', () => keys.toggle()],
  ]],
  ['Shown', TOGGLES.filter(([, , , there]) => there).map(([name, key, text]) => [[key], [key], text, () => box(name).click()])],
];

const keys = new Keys(KEYS, $('help'));
$('keys-button').addEventListener('click', () => keys.toggle());
$('help').addEventListener('click', (e) => { if (e.target === $('help')) keys.toggle(); });
$('close').addEventListener('click', () => keys.toggle());
// A button that was clicked by the mouse does not take the space bar for itself.
addEventListener('click', (e) => { if (e.detail > 0 && e.target.closest?.('button, label')) document.activeElement?.blur?.(); });

function resize() {
  stage?.frame();
  plots.draw();
  plots.cursor(time, locate);
  showMap();
}
addEventListener('resize', resize);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => plots.draw());

let before = 0;
function frame(now) {
  requestAnimationFrame(frame);
  const passed = Math.min(0.25, (now - before) / 1000);
  before = now;
  if (playing) {
    seek(time + passed * speed);
    if (time >= data.end) play(false);
  }
  stage?.render();
}

// What the address asks for; what it doesn't say stays as it is.
function obey() {
  const asked = readAddress();
  if (asked.run !== undefined && data.runs[asked.run - 1]) follow(asked.run - 1);
  if (asked.time !== undefined) seek(asked.time);
  if (VIEWS.includes(asked.view)) look(asked.view);
  if ([...$('trail').options].some((o) => o.value === asked.trail)) {
    $('trail').value = asked.trail;
    colourTrails(asked.trail);
  }
  if (asked.hidden) hide(asked.hidden);
  if (asked.depth) showDepth(asked.depth !== 'distance');
  stage?.restore(asked.numbers);
  showMap();
}
addEventListener('hashchange', obey);

if (stage) {
  stage.onView = showMap;
  canvas.addEventListener('webglcontextlost', (e) => { e.preventDefault(); $('without').hidden = false; });
  canvas.addEventListener('webglcontextrestored', () => { $('without').hidden = true; stage.dirty = true; });
  $('rut-bar').style.background = rutGradient();
  $('rut-scale').hidden = !data.runs.some((r) => r.ruts.count);
  const { deepest } = stage;
  $('rut-end').textContent = deepest < 0.02 ? `${(1000 * deepest).toFixed(0)} mm` : `${(100 * deepest).toFixed(0)} cm`;
} else {
  $('without').hidden = false;
  for (const id of ['camera', 'trail-row']) $(id).hidden = true;
}
if (innerWidth <= NARROW) {
  for (const id of ['about', 'shown']) $(id).open = false;
  if (stage) box('beside').click();
}
colourTrails(TRAIL);
follow(0);
resize();
obey();
address.begin();
requestAnimationFrame(frame);
const made = performance.now() - begun;

// For scripts and tests: where things are.
window.replay = {
  seek,
  get time() { return time; },
  get end() { return data.end; },
  get followed() { return followed; },
  get view() { return mode; },
  get paused() { return !playing; },
  position: (k = 0) => stage.runs[k].body.position.toArray(),
  wheel: (w = 0, k = 0) => stage.runs[k].wheels[w]?.quaternion.toArray(),
  // Rods with the lengths that they have, and those that they should have, m.
  rods: (k = 0) => stage.runs[k].links.bars.filter(([role]) => role === 'rod').map(([, a, b, length]) => [a.distanceTo(b), length]),
  bars: (k = 0) => stage.runs[k].links.bars.map(([role, a, b]) => [role, a.toArray(), b.toArray()]),
  made,
  sensed: () => {
    const { lidar, map } = stage.senses[followed];
    return {
      points: lidar.visible ? (lidar.geometry.attributes.position?.count ?? 0) : 0,
      point: (k) => [...lidar.geometry.attributes.position.array.subarray(3 * k, 3 * k + 3)],
      cells: map.visible ? (map.children[0]?.geometry.attributes.position.count ?? 0) / 6 : 0,
      depth: !$('depth').hidden,
      labels: stage.senses[followed].labels,
    };
  },
  height: (x, y) => stage.world.height(x, y),
  // The corners of the triangles of stones and of trunks.
  obstacles: () => stage.world.obstacles.children.map((body) => [...body.geometry.attributes.position.array]),
  ruts: () => stage.dug[followed]?.state ?? { cells: 0, sunk: 0 },
  // The number of grains, and where one is.
  grains: (k = 0) => {
    const mesh = stage.grains[followed]?.mesh;
    return { count: mesh?.count ?? 0, at: mesh && [...mesh.instanceMatrix.array.subarray(16 * k + 12, 16 * k + 15)] };
  },
  map: () => ({ span: stage.span / stage.above.zoom, at: stage.pan.target.toArray(), free: Boolean(stage.free), camera: stage.camera.type }),
  project: (x, y, z) => stage.project(x, y, z),
  info: () => ({ ...stage.renderer.info.render }),
};
