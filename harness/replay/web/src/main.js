// The replay: a world, its runs, a clock.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { gradient, locate, read, signal } from './data.js';
import { world as makeWorld } from './ground.js';
import { Plots } from './plots.js';
import { Sensed } from './sensed.js';
import { Run } from './vehicle.js';

const $ = (id) => document.getElementById(id);
const begun = performance.now();
const data = read();
// Lengths of signs and cameras in those of the vehicle: worlds are scaled.
const unit = data.runs[0].vehicle.length / 4.67;
const resolution = 0.1 * data.scale;

const renderer = new THREE.WebGLRenderer({ canvas: $('view'), antialias: true });
renderer.shadowMap.enabled = true;
renderer.shadowMap.type = THREE.PCFShadowMap;
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xb9cad6);
const camera = new THREE.PerspectiveCamera(45, 1, 0.05 * unit, 800 * unit);
camera.up.set(0, 0, 1);
const orbit = new OrbitControls(camera, renderer.domElement);
orbit.maxPolarAngle = 1.53;
orbit.zoomToCursor = false;

scene.add(new THREE.HemisphereLight(0xdfeaf2, 0x8a7f70, 1.5));
// From the north-west, as on maps.
const sun = new THREE.DirectionalLight(0xfff1dc, 2.2);
const SUN = new THREE.Vector3(-0.55, 0.55, 0.62).multiplyScalar(60 * unit);
sun.castShadow = true;
sun.shadow.mapSize.set(2048, 2048);
Object.assign(sun.shadow.camera, { left: -30 * unit, right: 30 * unit, top: 30 * unit, bottom: -30 * unit, near: unit, far: 140 * unit });
sun.shadow.bias = -0.0006;
sun.shadow.normalBias = 0.06 * unit;
scene.add(sun, sun.target);

const world = makeWorld(data, unit);
scene.add(world.group);
const runs = data.runs.map((run, k) => new Run(run, k > 0, world, unit, resolution));
for (const run of runs) scene.add(run.group);
const senses = data.runs.map((run) => new Sensed(run.sensed, data.semantics.classes, unit));
for (const sensed of senses) scene.add(sensed.group);
// What of the sensors is shown.
const wanted = { lidar: true, map: true, depth: true, estimate: true };

let time = 0;
let playing = false;
let speed = 1;
let followed = 0;
let mode = 'follow';
let dirty = true;
const centre = new THREE.Vector3();

function ends(which) {
  let most = 0;
  for (const run of data.runs) {
    for (let k = 0; k < run.times.length; k += 1) most = Math.max(most, Math.abs(signal(run, k, which)));
  }
  return most;
}
const MOST = { speed: Math.max(ends(0), 0.1), roll: Math.min(Math.max(ends(1), 1), 45) };
function colourTrails(by) {
  for (const run of runs) run.colourTrail(by, MOST[by] ?? 1);
  $('scale').hidden = by === 'run';
  $('scale-bar').style.background = gradient();
  $('scale-end').textContent = by === 'speed' ? `${MOST.speed.toFixed(1)} m/s` : `${MOST.roll.toFixed(0)}°`;
  dirty = true;
}

const stamp = (t) => t.toFixed(2);
function banner() {
  const run = data.runs[followed];
  const over = time >= run.end - 1e-3;
  const box = $('banner');
  box.hidden = !over;
  box.className = run.success ? 'good' : 'bad';
  box.textContent = over ? `${run.outcome} after ${stamp(run.time)} s${run.success ? '' : `: ${run.reason}`}` : '';
}

// The sensors of the vehicle that is followed.
function showSenses() {
  senses.forEach((sensed, k) => {
    sensed.group.visible = k === followed;
    if (k !== followed) return;
    const at = runs[k].pose(time).at;
    sensed.hidden = { lidar: !wanted.lidar, map: !wanted.map };
    sensed.show(time, world.height(at.x, at.y));
    sensed.estimate.visible = wanted.estimate;
  });
  const box = $('depth');
  box.hidden = !wanted.depth || !senses[followed].has.depth;
  if (!box.hidden) senses[followed].drawDepth($('depth-image'), time);
}

function show() {
  for (const run of runs) run.show(time);
  showSenses();
  const own = runs[followed];
  const { at, turn } = own.pose(time);
  const moved = at.clone().sub(centre);
  centre.copy(at);
  sun.position.copy(at).add(SUN);
  sun.target.position.copy(at);
  const ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(turn);
  const heading = new THREE.Vector3(ahead.x, ahead.y, 0).normalize();
  if (mode === 'follow') {
    camera.position.add(moved);
    orbit.target.add(moved);
  } else if (mode === 'chase') {
    camera.position.copy(at).addScaledVector(heading, -9.5 * unit).add(new THREE.Vector3(0, 0, 4 * unit));
    const floor = world.height(camera.position.x, camera.position.y) + unit;
    camera.position.z = Math.max(camera.position.z, floor);
    camera.lookAt(at.clone().addScaledVector(heading, 3 * unit));
  } else if (mode === 'cockpit') {
    camera.position.copy(new THREE.Vector3(0.15, 0.35, 1.55).multiplyScalar(unit).applyQuaternion(turn).add(at));
    camera.up.set(0, 0, 1).applyQuaternion(turn);
    camera.lookAt(camera.position.clone().add(ahead).add(new THREE.Vector3(0, 0, -0.12)));
    camera.up.set(0, 0, 1);
  } else if (mode === 'top') {
    const aim = orbit.target.copy(at);
    camera.position.set(aim.x, aim.y - 1e-3, Math.max(camera.position.z, at.z + 8 * unit));
    camera.lookAt(aim);
  }
  $('slider').value = time;
  $('time').textContent = `${stamp(time)} / ${stamp(data.end)} s`;
  plots.cursor(time, locate);
  banner();
  dirty = true;
}

function seek(t) {
  time = Math.min(data.end, Math.max(0, t));
  show();
}

function look(to) {
  mode = to;
  const { at, turn } = runs[followed].pose(time);
  orbit.enabled = mode === 'follow' || mode === 'orbit';
  orbit.target.copy(at);
  const ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(turn);
  if (mode === 'follow') camera.position.copy(at).add(new THREE.Vector3(-11 * ahead.x + 6 * ahead.y, -11 * ahead.y - 6 * ahead.x, 7).multiplyScalar(unit));
  if (mode === 'orbit') {
    const half = Math.max(...data.ground.half);
    orbit.target.set(0, 0, at.z);
    camera.position.set(-0.55 * half, -1.75 * half, 1.35 * half);
  }
  if (mode === 'top') camera.position.set(at.x, at.y, at.z + 45 * unit);
  centre.copy(at);
  orbit.update();
  for (const b of document.querySelectorAll('#camera button')) b.setAttribute('aria-pressed', b.value === mode);
  show();
}

function play(on) {
  playing = on;
  if (playing && time >= data.end) time = 0;
  $('play').textContent = playing ? '❚❚' : '▶';
  $('play').setAttribute('aria-label', playing ? 'Pause' : 'Play');
}

function follow(k) {
  followed = k;
  runs.forEach((run, i) => { run.body.visible = true; run.trail.renderOrder = i === k ? 2 : 1; });
  document.querySelectorAll('#runs li').forEach((li, i) => li.setAttribute('aria-current', i === k));
  plots.followed = k;
  plots.make();
  look(mode);
}

// What is told beside the view.
document.title = `${data.task} on ${data.suite}`;
$('task').textContent = data.task;
$('labels').textContent = `${data.labels[0]} elevation, ${data.labels[1]} ground, ${data.labels[2]} obstacles · ${data.suite}`;
data.runs.forEach((run, k) => {
  const li = document.createElement('li');
  const button = document.createElement('button');
  button.type = 'button';
  const swatch = document.createElement('i');
  swatch.style.background = run.colour;
  const text = document.createElement('span');
  text.textContent = run.label;
  const outcome = document.createElement('em');
  outcome.textContent = `${run.outcome}, ${run.time.toFixed(1)} s`;
  outcome.className = run.success ? 'good' : 'bad';
  button.append(swatch, text, outcome);
  button.title = run.exact ? 'simulated again, bit for bit as recorded' : 'as sampled: ruts are unknown';
  button.addEventListener('click', () => follow(k));
  li.append(button);
  $('runs').append(li);
});
const legend = $('classes');
for (const c of data.semantics.classes.filter((x) => x.there)) {
  const li = document.createElement('li');
  const swatch = document.createElement('i');
  swatch.style.background = `rgb(${c.colour})`;
  li.append(swatch, c.soil ? `${c.name}, ${c.soil}` : c.name);
  legend.append(li);
}
$('depth').addEventListener('click', () => {
  for (const sensed of senses) sensed.labels = !sensed.labels;
  showSenses();
});
const thin = data.runs.map((run) => run.sensed).find((s) => s.scans_of || s.maps_of || s.images_of);
if (thin) {
  const of = [['scans', 'scans'], ['images', 'images'], ['maps', 'maps']].filter(([key]) => thin[`${key}_of`]);
  $('sensed').textContent = `sensors: ${of.map(([key, name]) => `${thin[key].length} of ${thin[`${key}_of`]} ${name}`).join(', ')} are shown`;
}
const slider = $('slider');
slider.max = data.end;
slider.step = 0.01;
slider.addEventListener('input', () => { play(false); seek(Number(slider.value)); });
const marks = $('marks');
for (const run of data.runs) {
  const mark = document.createElement('i');
  mark.style.left = `${(100 * run.end) / data.end}%`;
  mark.style.background = run.success ? '#55bd8a' : '#e8705a';
  mark.title = `${run.label}: ${run.outcome}`;
  marks.append(mark);
}
$('play').addEventListener('click', () => play(!playing));
$('speed').addEventListener('change', (e) => { speed = Number(e.target.value); });
$('trail').addEventListener('change', (e) => colourTrails(e.target.value));
$('camera').addEventListener('click', (e) => { const b = e.target.closest('button'); if (b) look(b.value); });
const toggles = {
  classes: (on) => { world.ground.material.map = world.map(on); },
  obstacles: (on) => { world.obstacles.visible = on; },
  path: (on) => { world.path.visible = on; },
  ruts: (on) => { for (const run of runs) run.ruts.visible = on; },
  plan: (on) => { for (const run of runs) for (const plan of run.plans) plan.lines.visible = on; },
  ghosts: (on) => { runs.forEach((run, k) => { run.group.visible = on || k === followed; }); },
};
for (const name of Object.keys(wanted)) toggles[name] = (on) => { wanted[name] = on; showSenses(); };
const there = (name) => senses.some((sensed) => sensed.has[name]);
const unused = { lidar: !there('lidar'), map: !there('map'), depth: !there('depth'), estimate: !there('estimate'), ruts: data.runs.every((r) => !r.ruts.length), plan: runs.every((r) => !r.plans.length), ghosts: runs.length < 2 };
for (const box of document.querySelectorAll('#toggles input')) {
  if (unused[box.name]) box.parentElement.hidden = true;
  box.addEventListener('change', () => { toggles[box.name](box.checked); dirty = true; });
}
addEventListener('keydown', (e) => {
  if (e.target.closest('select, input:not([type=range])')) return;
  const step = e.shiftKey ? 1 : 0.1;
  if (e.key === ' ') { e.preventDefault(); play(!playing); }
  if (e.key === 'ArrowRight') { e.preventDefault(); play(false); seek(time + step); }
  if (e.key === 'ArrowLeft') { e.preventDefault(); play(false); seek(time - step); }
  if (e.key === 'Home') seek(0);
  if (e.key === 'End') seek(data.end);
});
orbit.addEventListener('change', () => { dirty = true; });

const plots = new Plots(data, $('plots'), (t) => { play(false); seek(t); });
function resize() {
  const [w, h] = [innerWidth, innerHeight];
  renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
  renderer.setSize(w, h, false);
  camera.aspect = w / h;
  camera.updateProjectionMatrix();
  plots.draw();
  plots.cursor(time, locate);
  dirty = true;
}
addEventListener('resize', resize);

let before = 0;
function frame(now) {
  requestAnimationFrame(frame);
  const passed = Math.min(0.25, (now - before) / 1000);
  before = now;
  if (playing) {
    seek(time + passed * speed);
    if (time >= data.end) play(false);
  }
  if (dirty) {
    dirty = false;
    renderer.render(scene, camera);
  }
}

colourTrails('speed');
resize();
follow(0);
const asked = new URLSearchParams(location.hash.slice(1));
const first = Number(asked.get('t'));
seek(Number.isFinite(first) ? first : 0);
if (['chase', 'cockpit', 'top', 'orbit'].includes(asked.get('camera'))) look(asked.get('camera'));
requestAnimationFrame(frame);
const made = performance.now() - begun;

// For scripts and tests: where things are.
window.replay = {
  seek,
  get time() { return time; },
  get end() { return data.end; },
  position: (k = 0) => runs[k].body.position.toArray(),
  wheel: (w = 0, k = 0) => runs[k].wheels[w]?.quaternion.toArray(),
  made,
  sensed: () => ({
    points: senses[followed].lidar.visible ? (senses[followed].lidar.geometry.attributes.position?.count ?? 0) : 0,
    point: (k) => [...senses[followed].lidar.geometry.attributes.position.array.subarray(3 * k, 3 * k + 3)],
    cells: senses[followed].map.visible ? (senses[followed].map.children[0]?.geometry.attributes.position.count ?? 0) / 6 : 0,
    depth: !$('depth').hidden,
  }),
  height: (x, y) => world.height(x, y),
  ruts: (k = 0) => runs[k].ruts.geometry.drawRange.count / 6,
  info: () => ({ ...renderer.info.render }),
};
