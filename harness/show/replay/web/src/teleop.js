// A person drives: the page shows where the vehicle is, and sends what the person does.
import * as THREE from 'three';
import { COLOURS } from './data.js';
import { unpack } from './packed.js';
import { world as makeWorld } from './ground.js';
import { Run } from './vehicle.js';

const $ = (id) => document.getElementById(id);
const data = JSON.parse($('data').textContent);
const WHEEL = 7;
const HEAD = 15;

const renderer = new THREE.WebGLRenderer({ canvas: $('view'), antialias: true });
renderer.shadowMap.enabled = true;
renderer.shadowMap.type = THREE.PCFShadowMap;
const camera = new THREE.PerspectiveCamera(50, 1, 0.05, 800);
camera.up.set(0, 0, 1);
let stage = null;
let latest = null;
let driving = false;
let kept = data.episodes;
let cockpit = false;
let frames = 0;

// The scene of a task: world and vehicle, as in a replay.
function build(scene) {
  scene.ground.z = unpack(scene.ground.heights);
  const unit = scene.vehicle.length / 4.67;
  const three = new THREE.Scene();
  three.background = new THREE.Color(0xb9cad6);
  three.add(new THREE.HemisphereLight(0xdfeaf2, 0x8a7f70, 1.5));
  const sun = new THREE.DirectionalLight(0xfff1dc, 2.2);
  sun.castShadow = true;
  sun.shadow.mapSize.set(1024, 1024);
  Object.assign(sun.shadow.camera, { left: -20 * unit, right: 20 * unit, top: 20 * unit, bottom: -20 * unit, near: unit, far: 140 * unit });
  sun.shadow.bias = -0.0006;
  sun.shadow.normalBias = 0.06 * unit;
  three.add(sun, sun.target);
  scene.runs = [];
  const world = makeWorld(scene, unit);
  three.add(world.group);
  const wheels = scene.vehicle.wheels.length;
  const [x, y, yaw] = scene.start;
  const run = {
    vehicle: scene.vehicle, wheel_count: wheels, colour: COLOURS[0], outcome: '', success: true, end: Infinity,
    times: new Float32Array(1), signals: new Float32Array(6), series: { lines: {}, curves: {} },
    poses: new Float32Array([x, y, world.height(x, y) + unit, 0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2)]),
    wheels: new Float32Array(WHEEL * wheels),
  };
  for (let w = 0; w < wheels; w += 1) run.wheels.set([0, 0, 0, 0, 1, 0, 0], WHEEL * w);
  const vehicle = new Run(run, world, unit);
  three.add(vehicle.group);
  camera.far = 800 * unit;
  camera.near = 0.05 * unit;
  camera.updateProjectionMatrix();
  $('task').textContent = scene.task;
  $('labels').textContent = `${scene.labels[0]} elevation, ${scene.labels[1]} terrain, ${scene.labels[2]} obstacles · ${scene.vehicle.name}`;
  stage = { scene, three, world, vehicle, run, unit, sun };
  latest = null;
}

// Where the camera stands: behind the vehicle, or at the driver's place.
function look(at, turn) {
  const { unit, world } = stage;
  const ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(turn);
  if (cockpit) {
    camera.position.copy(new THREE.Vector3(0.15, 0.35, 1.55).multiplyScalar(unit).applyQuaternion(turn).add(at));
    camera.up.set(0, 0, 1).applyQuaternion(turn);
    camera.lookAt(camera.position.clone().add(ahead).add(new THREE.Vector3(0, 0, -0.12)));
    camera.up.set(0, 0, 1);
    return;
  }
  const heading = new THREE.Vector3(ahead.x, ahead.y, 0).normalize();
  camera.position.copy(at).addScaledVector(heading, -9.5 * unit).add(new THREE.Vector3(0, 0, 4 * unit));
  camera.position.z = Math.max(camera.position.z, world.height(camera.position.x, camera.position.y) + unit);
  camera.lookAt(at.clone().addScaledVector(heading, 3 * unit));
}

function bar(id, share, from = 0) {
  const style = $(id).style;
  style.left = `${100 * Math.min(from, from + share)}%`;
  style.width = `${100 * Math.abs(share)}%`;
}

function show() {
  const { run, vehicle, sun, unit, scene } = stage;
  if (latest) {
    run.poses.set(latest.subarray(1, 8));
    run.wheels.set(latest.subarray(HEAD, HEAD + run.wheels.length));
    const [speed, roll, pitch, steering, throttle, brake, gear] = latest.subarray(8, HEAD);
    $('speed').textContent = `${speed.toFixed(1)} m/s`;
    $('gear').textContent = ['reverse', 'neutral', 'forward'][gear + 1];
    $('roll').textContent = `roll ${roll.toFixed(0)}°`;
    $('pitch').textContent = `pitch ${pitch.toFixed(0)}°`;
    $('roll').className = Math.abs(roll) > 25 ? 'steep' : '';
    $('pitch').className = Math.abs(pitch) > 25 ? 'steep' : '';
    // Positive steering is to the left.
    bar('steering', -steering / 2, 0.5);
    bar('throttle', throttle);
    bar('brake', brake);
    $('time').textContent = `${latest[0].toFixed(1)} s`;
    const away = Math.hypot(latest[1] - scene.goal[0], latest[2] - scene.goal[1]);
    $('goal').textContent = `goal ${away.toFixed(0)} m`;
  }
  vehicle.show(0);
  const { at, turn } = vehicle.pose(0);
  sun.position.copy(at).add(new THREE.Vector3(-0.55, 0.55, 0.62).multiplyScalar(60 * unit));
  sun.target.position.copy(at);
  look(at, turn);
  renderer.render(stage.three, camera);
  frames += 1;
}

// What the person does: keys that ramp, or a gamepad.
const keys = new Set();
const KEYS = {
  ArrowUp: 'up', KeyW: 'up', ArrowDown: 'down', KeyS: 'down', ArrowLeft: 'left', KeyA: 'left', ArrowRight: 'right', KeyD: 'right',
};
const hand = { steering: 0, throttle: 0, brake: 0, gear: 1 };
const toward = (value, aim, step) => value + Math.max(-step, Math.min(step, aim - value));
let pressed = false;
function act(passed) {
  const on = (name) => Number(keys.has(name));
  hand.steering = toward(hand.steering, on('left') - on('right'), 2.5 * passed);
  hand.throttle = toward(hand.throttle, on('up'), (on('up') ? 1.5 : 4) * passed);
  hand.brake = toward(hand.brake, on('down'), 3 * passed);
  const pad = navigator.getGamepads?.().find((p) => p?.connected && p.buttons.length > 7);
  if (pad) {
    const axis = Math.abs(pad.axes[0]) < 0.08 ? 0 : -pad.axes[0];
    if (axis || !keys.size) hand.steering = axis;
    hand.throttle = Math.max(hand.throttle, pad.buttons[7].value);
    hand.brake = Math.max(hand.brake, pad.buttons[6].value);
    if (pad.buttons[1].pressed && !pressed) hand.gear = -hand.gear;
    pressed = pad.buttons[1].pressed;
  }
}

const address = new URL('drive', location.href);
address.protocol = 'ws:';
const socket = new WebSocket(address);
socket.binaryType = 'arraybuffer';
const send = (message) => { if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); };
socket.addEventListener('message', (event) => {
  if (event.data instanceof ArrayBuffer) {
    if (driving) latest = new Float32Array(event.data);
    return;
  }
  const told = JSON.parse(event.data);
  if (told.scene) {
    build(told.scene);
    driving = told.driving;
    Object.assign(hand, { steering: 0, throttle: 0, brake: 0, gear: 1 });
    $('banner').hidden = driving;
  }
  if (told.ended) {
    driving = false;
    kept = told.episodes;
    $('kept').textContent = `${kept} episodes are kept`;
    $('banner').hidden = false;
    $('banner').className = told.ended.success ? 'good' : 'bad';
    $('banner').textContent = told.ended.text;
  }
  if (told.error) {
    $('banner').hidden = false;
    $('banner').className = 'bad';
    $('banner').textContent = told.error;
  }
});
socket.addEventListener('close', () => {
  driving = false;
  $('banner').hidden = false;
  $('banner').className = 'bad';
  $('banner').textContent = 'The harness is gone, or drives in another tab. What was finished is in the dataset.';
});

for (const name of data.tasks) $('tasks').append(new Option(name, name));
$('kept').textContent = `${kept} episodes are kept`;
$('start').addEventListener('click', () => { $('view').focus(); send({ start: $('tasks').value }); });
$('reset').addEventListener('click', () => { $('view').focus(); send('reset'); });
addEventListener('keydown', (e) => {
  if (e.target.closest?.('select')) return;
  const name = KEYS[e.code];
  if (name) { e.preventDefault(); keys.add(name); }
  if (e.code === 'KeyR' && !e.repeat) hand.gear = -hand.gear;
  if (e.code === 'KeyC' && !e.repeat) cockpit = !cockpit;
});
addEventListener('keyup', (e) => keys.delete(KEYS[e.code]));
addEventListener('blur', () => keys.clear());
function resize() {
  renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener('resize', resize);
resize();

// Commands go at a steady rate, whatever the picture does.
setInterval(() => {
  act(0.02);
  if (driving) send({ input: [hand.steering, hand.throttle, hand.brake, hand.gear] });
}, 20);
function frame() {
  requestAnimationFrame(frame);
  if (stage) show();
}
requestAnimationFrame(frame);

// For tests: what is going on.
window.teleop = {
  get state() { return latest ? [...latest] : []; },
  get driving() { return driving; },
  get kept() { return kept; },
  get frames() { return frames; },
  get ready() { return Boolean(stage); },
};
