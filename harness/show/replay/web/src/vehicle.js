// One run in the world: vehicle, trail, ruts, what its planner intends, how it ended.
import * as THREE from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { bodies, band } from './ground.js';
import { Belt } from './belt.js';
import { Links } from './links.js';
import { locate, position, scale, signal } from './data.js';
import { unpackMeshes } from './packed.js';

const WHEEL = 7; // hub, axis, angle
const UP = new THREE.Vector3(0, 1, 0);

// One mesh a wheel, with treads and spokes by which one sees it turn.
function wheelGeometry(radius, width) {
  const parts = [];
  const add = (geometry, colour, angle = 0, out = 0) => {
    geometry.rotateY(angle);
    geometry.translate(out * radius * Math.sin(angle), 0, out * radius * Math.cos(angle));
    const paint = new THREE.Color(colour);
    const count = geometry.getAttribute('position').count;
    const colours = new Float32Array(3 * count);
    for (let k = 0; k < count; k += 1) colours.set([paint.r, paint.g, paint.b], 3 * k);
    geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
    parts.push(geometry);
  };
  add(new THREE.CylinderGeometry(radius, radius, width, 36), 0x232325);
  add(new THREE.CylinderGeometry(0.58 * radius, 0.58 * radius, 1.02 * width, 24), 0x8b8d90);
  for (let k = 0; k < 18; k += 1) add(new THREE.BoxGeometry(0.09 * radius, 0.94 * width, 0.1 * radius), 0x131314, (k * Math.PI) / 9, 0.985);
  for (let k = 0; k < 5; k += 1) add(new THREE.BoxGeometry(0.13 * radius, 1.05 * width, 0.44 * radius), k === 0 ? 0xe7c64a : 0x4a4c50, (k * 2 * Math.PI) / 5, 0.3);
  return mergeGeometries(parts);
}

function label(text, colour, unit) {
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d');
  const font = '600 44px system-ui, sans-serif';
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 44;
  canvas.height = 72;
  context.font = font;
  context.fillStyle = colour;
  context.beginPath();
  context.roundRect(0, 0, canvas.width, canvas.height, 18);
  context.fill();
  context.fillStyle = '#fff';
  context.textBaseline = 'middle';
  context.fillText(text, 22, 38);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false }));
  sprite.scale.set((canvas.width / canvas.height) * 1.1 * unit, 1.1 * unit, 1);
  sprite.renderOrder = 10;
  return sprite;
}

export class Run {
  constructor(run, world, unit) {
    Object.assign(this, { run, world, unit });
    this.group = new THREE.Group();
    this.body = new THREE.Group();
    this.hull = bodies(unpackMeshes(run.vehicle.parts), new THREE.MeshLambertMaterial({ color: run.colour, flatShading: true }));
    this.edges = new THREE.LineSegments(
      new THREE.EdgesGeometry(this.hull.geometry, 12),
      new THREE.LineBasicMaterial({ color: 0x10181c, transparent: true }),
    );
    this.body.add(this.hull, this.edges);
    const rubber = new THREE.MeshLambertMaterial({ vertexColors: true });
    const geometries = new Map();
    this.wheels = Array.from({ length: run.wheel_count }, (_, w) => {
      const [radius, width] = run.vehicle.wheels[w];
      const key = `${radius} ${width}`;
      // Between the rims of a belted wheel its guides run.
      if (!geometries.has(key)) geometries.set(key, wheelGeometry(radius, run.vehicle.belt ? 0.6 * width : width));
      return new THREE.Mesh(geometries.get(key), rubber);
    });
    this.body.add(...this.wheels);
    this.belts = run.vehicle.belt && run.wheel_count ? [0, 1].map((side) => new Belt(run, side)) : [];
    for (const belt of this.belts) this.body.add(belt.mesh);
    this.axes = this.wheels.map(() => UP.clone());
    this.links = this.wheels.length ? new Links(run.vehicle, unit) : null;
    if (this.links) this.body.add(this.links.mesh);
    this.group.add(this.body);
    this.makeTrail();
    this.plans = Object.entries(run.series.lines).map(([name, steps]) => {
      const material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.9 });
      const lines = new THREE.LineSegments(new THREE.BufferGeometry(), material);
      lines.frustumCulled = false;
      this.group.add(lines);
      return { name, steps, times: steps.map((s) => s[0]), lines, shown: -1 };
    });
    const last = run.times.length - 1;
    this.flag = label(run.outcome, run.success ? '#2f9463' : '#c0412b', unit);
    const [x, y, z] = position(run, last);
    this.flag.position.set(x, y, z + 3.4 * unit);
    this.group.add(this.flag);
    this.look(false, false);
  }

  // Whether it is one of the runs that are not followed, and whether one sees the wheels and bars behind its hull.
  look(ghost, through) {
    const fade = (mesh, opacity) => {
      Object.assign(mesh.material, { transparent: opacity < 1, opacity, depthWrite: opacity > 0.3, needsUpdate: true });
      mesh.castShadow = !ghost;
    };
    fade(this.hull, through ? 0.22 : ghost ? 0.4 : 1);
    this.edges.material.opacity = ghost ? 0.25 : 0.55;
    for (const { mesh } of [...this.belts, ...(this.links ? [this.links] : [])]) fade(mesh, ghost ? 0.45 : 1);
    for (const mesh of this.wheels) fade(mesh, ghost ? 0.45 : 1);
    this.trail.material.opacity = ghost ? 0.6 : 0.95;
    this.trail.renderOrder = ghost ? 1 : 2;
  }

  // A point of the trail about every tenth of a second, and the last.
  makeTrail() {
    const { run } = this;
    this.trailFrames = [];
    run.times.forEach((t, k) => {
      const before = this.trailFrames.length ? run.times[this.trailFrames.at(-1)] : -1;
      if (t - before > 0.099 || k === run.times.length - 1) this.trailFrames.push(k);
    });
    this.trailTimes = Float32Array.from(this.trailFrames, (k) => run.times[k]);
    const points = this.trailFrames.map((k) => [...position(run, k).subarray(0, 2)]);
    const colours = new Float32Array(6 * points.length);
    this.trail = band(points, 0.4 * this.unit, 0.09 * this.unit, this.world.height, colours, { transparent: true });
    this.group.add(this.trail);
  }

  // By speed, by roll, or in the run's own colour; `most` is the end of the scale.
  colourTrail(by, most) {
    const own = new Float32Array([1, 3, 5].map((k) => (parseInt(this.run.colour.slice(k, k + 2), 16) / 255) ** 2.2));
    const colours = this.trail.geometry.getAttribute('color');
    this.trailFrames.forEach((k, i) => {
      const value = by === 'speed' ? signal(this.run, k, 0) : Math.abs(signal(this.run, k, 1));
      const c = by === 'run' ? own : scale(value / most).map((v) => v ** 2.2);
      colours.array.set([...c, ...c], 6 * i);
    });
    colours.needsUpdate = true;
  }

  pose(t) {
    const [k, share] = locate(this.run.times, t);
    const next = Math.min(k + 1, this.run.times.length - 1);
    const [a, b] = [k, next].map((i) => this.run.poses.subarray(7 * i, 7 * i + 7));
    const at = new THREE.Vector3(...a.subarray(0, 3)).lerp(new THREE.Vector3(...b.subarray(0, 3)), share);
    const turn = new THREE.Quaternion(...a.subarray(3)).slerp(new THREE.Quaternion(...b.subarray(3)), share);
    return { k, next, share, at, turn };
  }

  show(t) {
    const { k, next, share, at, turn } = this.pose(t);
    this.body.position.copy(at);
    this.body.quaternion.copy(turn);
    const n = this.run.wheel_count;
    this.wheels.forEach((mesh, w) => {
      const [a, b] = [k, next].map((i) => this.run.wheels.subarray(WHEEL * (n * i + w), WHEEL * (n * i + w + 1)));
      const mix = (i) => a[i] + share * (b[i] - a[i]);
      mesh.position.set(mix(0), mix(1), mix(2));
      const axis = new THREE.Vector3(mix(3), mix(4), mix(5)).normalize();
      this.axes[w].copy(axis);
      mesh.quaternion.setFromUnitVectors(UP, axis)
        .multiply(new THREE.Quaternion().setFromAxisAngle(UP, mix(6)));
    });
    for (const belt of this.belts) belt.show(this.wheels, (w) => {
      const [a, b] = [k, next].map((i) => this.run.wheels[WHEEL * (n * i + w) + 6]);
      return a + share * (b - a);
    });
    this.links?.show(this.wheels, this.axes);
    const [trail] = locate(this.trailTimes, t);
    this.trail.geometry.setDrawRange(0, t <= 0 ? 0 : 6 * trail);
    for (const plan of this.plans) this.showPlan(plan, t);
    this.flag.visible = t >= this.run.end - 1e-3;
  }

  showPlan(plan, t) {
    const step = plan.times.length && plan.times[0] <= t + 1e-6 ? locate(plan.times, t + 1e-6)[0] : -1;
    if (step === plan.shown) return;
    plan.shown = step;
    const points = [];
    const colours = [];
    if (step >= 0) {
      const [, lines, costs] = plan.steps[step];
      // Colours by rank: one very bad course must not make all others look alike.
      const ranks = (costs ?? []).filter((c) => c !== null).sort((a, b) => a - b);
      lines.forEach((line, i) => {
        const cost = costs?.[i] ?? null;
        const c = cost === null ? [0.1, 0.9, 0.82] : scale(ranks.indexOf(cost) / Math.max(1, ranks.length - 1));
        const at = (k) => {
          const [x, y, z] = line.slice(3 * k, 3 * k + 3);
          return [x, y, z ?? this.world.height(x, y) + 0.35 * this.unit];
        };
        const add = (a, b) => { points.push(...a, ...b); colours.push(...c, ...c); };
        // A single point is a place: a pole with a cross.
        if (line.length === 3) {
          const [x, y, z] = at(0);
          const r = 0.6 * this.unit;
          add([x, y, z - 0.3 * this.unit], [x, y, z + 3 * r]);
          add([x - r, y, z + r], [x + r, y, z + r]);
          add([x, y - r, z + r], [x, y + r, z + r]);
        }
        for (let k = 1; 3 * k < line.length; k += 1) add(at(k - 1), at(k));
      });
    }
    plan.lines.geometry.dispose();
    plan.lines.geometry = new THREE.BufferGeometry();
    plan.lines.geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
    plan.lines.geometry.setAttribute('color', new THREE.Float32BufferAttribute(colours, 3));
  }
}
