// What the page shows, as the harness wrote it.
import { unpack, unpackEach } from './packed.js';

export const floats = (text) => {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let k = 0; k < binary.length; k += 1) bytes[k] = binary.charCodeAt(k);
  return new Float32Array(bytes.buffer);
};

// What the wheels and the ground do to each other, if it is known: the share of the weight, the slip, the depth in m.
function contact(told) {
  if (!told) return null;
  const values = unpackEach(told);
  const at = (which) => (k) => values[3 * k + which];
  return { load: at(0), slip: at(1), depth: at(2) };
}

// The time of each of `count` events, of which `steps` tells when how many happened.
function timesOf(steps, count) {
  const times = new Float32Array(count);
  let from = 0;
  for (let k = 0; k < steps.length; k += 2) {
    times.fill(steps[k], from, from + steps[k + 1]);
    from += steps[k + 1];
  }
  return times;
}

// The cells of the ground that yielded, in the order of time: when, where, and by how much the ground is higher there, m.
function ruts(told) {
  const cells = unpack(told.cells);
  const count = cells.length / 3;
  const [x, y, change] = [0, 1, 2].map((which) => Float32Array.from({ length: count }, (_, k) => cells[3 * k + which]));
  const times = timesOf(unpack(told.steps), count);
  let deepest = 0;
  for (const v of change) deepest = Math.max(deepest, -v);
  return { count, side: told.side, times, x, y, change, deepest };
}

// The grains of granular beds: radii, places at the start, and the moves in the order of time, each with its grain.
function grains({ radii, start, steps, moves }) {
  const told = { radii: unpack(radii), start: unpack(start), moves: unpack(moves) };
  told.times = timesOf(unpack(steps), told.moves.length / 4);
  return told;
}

export const COLOURS = ['#2a6fb3', '#d07a1d', '#2c8c5a', '#8057b8', '#c0412b', '#168a92', '#8a6636', '#b94888'];
export const SIGNALS = 6; // speed, roll, pitch, steering, throttle, brake
const POSE = 7; // x, y, z, quaternion

export function read() {
  const data = JSON.parse(document.getElementById('data').textContent);
  data.ground.z = unpack(data.ground.heights);
  data.runs.forEach((run, k) => {
    run.colour = COLOURS[k % COLOURS.length];
    for (const key of ['times', 'poses', 'signals']) run[key] = unpack(run[key]);
    run.wheels = unpackEach(run.wheels);
    run.contact = contact(run.contact);
    run.ruts = ruts(run.ruts);
    run.grains = grains(run.grains);
    run.end = run.times[run.times.length - 1];
  });
  data.end = Math.max(...data.runs.map((r) => r.end));
  return data;
}

// The frame at or before a time, and how far the next one is away.
export function locate(times, t) {
  let low = 0;
  let high = times.length - 1;
  if (t >= times[high]) return [high, 0];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  const span = times[high] - times[low];
  return [low, span > 0 ? Math.max(0, (t - times[low]) / span) : 0];
}

export const position = (run, k) => run.poses.subarray(POSE * k, POSE * k + 3);
export const signal = (run, k, which) => run.signals[SIGNALS * k + which];

// Heights as the physics has them: cells cut from south-west to north-east.
export function heightOf(ground) {
  const { rows, cols, resolution, half, z } = ground;
  return (x, y) => {
    const fx = (x + half[0]) / resolution[0];
    const fy = (y + half[1]) / resolution[1];
    const c = Math.min(cols - 2, Math.max(0, Math.floor(fx)));
    const r = Math.min(rows - 2, Math.max(0, Math.floor(fy)));
    const [u, v] = [fx - c, fy - r];
    const k = r * cols + c;
    const [a, b, d, e] = [z[k], z[k + 1], z[k + cols], z[k + cols + 1]];
    return v >= u ? a + (d - a) * v + (e - d) * u : a + (b - a) * u + (e - b) * v;
  };
}

// Colours of a scale in [0, 1], from low to high: blue, teal, yellow, red.
const STOPS = [[38, 70, 131], [38, 145, 140], [122, 196, 91], [250, 213, 61], [221, 66, 38]];
export function scale(share) {
  const at = Math.min(1, Math.max(0, share)) * (STOPS.length - 1);
  const k = Math.min(STOPS.length - 2, Math.floor(at));
  return STOPS[k].map((v, i) => (v + (at - k) * (STOPS[k + 1][i] - v)) / 255);
}
export const gradient = () => `linear-gradient(90deg,${STOPS.map((s) => `rgb(${s})`).join(',')})`;
