// What is seen in three dimensions: the world with its runs, and the cameras. Without WebGL there is no stage.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { deepest, Dug } from './dig.js';
import { Grains, pitCells } from './grains.js';
import { world as makeWorld } from './ground.js';
import { number } from './address.js';
import { Sensed } from './sensed.js';
import { Run } from './vehicle.js';

export const VIEWS = ['follow', 'chase', 'cockpit', 'top', 'world'];
const UP = new THREE.Vector3(0, 0, 1);
const HIGH = 400; // of the camera of the top view over the ground, in lengths of signs

// A context of WebGL 2 for a canvas, or none.
export function contextOf(canvas) {
  return canvas.getContext('webgl2', { antialias: true, powerPreference: 'high-performance' });
}

export class Stage {
  constructor(canvas, context, data) {
    Object.assign(this, { canvas, data, followed: 0, mode: 'follow', time: 0, dirty: true, digs: true, ghosts: true, through: false });
    // Lengths of signs and cameras in those of the vehicle: worlds are scaled.
    const unit = data.runs[0].vehicle.length / 4.67;
    this.unit = unit;
    this.renderer = new THREE.WebGLRenderer({ canvas, context, antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xb9cad6);
    this.light();
    this.world = makeWorld(data, unit);
    this.scene.add(this.world.group);
    this.runs = data.runs.map((run) => new Run(run, this.world, unit));
    for (const run of this.runs) this.scene.add(run.group);
    this.senses = data.runs.map((run) => new Sensed(run.sensed, data.semantics.classes, unit));
    for (const sensed of this.senses) this.scene.add(sensed.group);
    // What of the sensors is shown.
    this.wanted = { lidar: true, map: true, depth: true, estimate: true };
    this.deepest = deepest(data.runs);
    this.dug = data.runs.map(() => null);
    // Of runs that are shown as they were sampled the grains are unknown: their beds look like the ground around them.
    this.grains = data.runs.map((run) => (run.grains.radii.length ? new Grains(run, data.beds) : null));
    for (const grains of this.grains) if (grains) this.scene.add(grains.group);
    this.pits = pitCells(data.beds, data.ground);
    this.makeCameras();
  }

  light() {
    const { unit } = this;
    this.scene.add(new THREE.HemisphereLight(0xdfeaf2, 0x8a7f70, 1.5));
    // From the north-west, as on maps.
    this.sun = new THREE.DirectionalLight(0xfff1dc, 2.2);
    this.toSun = new THREE.Vector3(-0.55, 0.55, 0.62).multiplyScalar(60 * unit);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    Object.assign(this.sun.shadow.camera, { left: -30 * unit, right: 30 * unit, top: 30 * unit, bottom: -30 * unit, near: unit, far: 140 * unit });
    this.sun.shadow.bias = -0.0006;
    this.sun.shadow.normalBias = 0.06 * unit;
    this.scene.add(this.sun, this.sun.target);
  }

  // One in perspective, which one turns; one from above, which one moves, with the north up.
  makeCameras() {
    const { unit, canvas } = this;
    this.eye = new THREE.PerspectiveCamera(45, 1, 0.05 * unit, 800 * unit);
    this.eye.up.copy(UP);
    this.orbit = new OrbitControls(this.eye, canvas);
    this.orbit.maxPolarAngle = 1.53;
    this.above = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 2 * HIGH * unit);
    this.above.up.set(0, 1, 0);
    this.pan = new OrbitControls(this.above, canvas);
    Object.assign(this.pan, {
      enableRotate: false,
      minZoom: 0.05,
      maxZoom: 40,
      mouseButtons: { LEFT: THREE.MOUSE.PAN, MIDDLE: THREE.MOUSE.DOLLY, RIGHT: THREE.MOUSE.PAN },
      touches: { ONE: THREE.TOUCH.PAN, TWO: THREE.TOUCH.DOLLY_PAN },
    });
    this.span = 50 * unit; // of what the top view shows from south to north, m, before it is zoomed
    this.centre = new THREE.Vector3();
    for (const controls of [this.orbit, this.pan]) {
      controls.addEventListener('start', () => { this.touched = true; });
      controls.addEventListener('change', () => { this.dirty = true; this.freed(); this.onView?.(); });
    }
  }

  get camera() { return this.mode === 'top' ? this.above : this.eye; }

  // Once a person has moved the map, it stays where it is.
  freed() {
    const { target } = this.pan;
    if (this.mode === 'top' && this.touched && Math.hypot(target.x - this.centre.x, target.y - this.centre.y) > 1e-3 * this.unit) this.free = true;
    this.pan.zoomToCursor = this.free;
  }

  // The sensors of the vehicle that is followed.
  showSenses(canvas) {
    const { runs, senses, followed, wanted, time, world } = this;
    senses.forEach((sensed, k) => {
      sensed.group.visible = k === followed;
      if (k !== followed) return;
      const { at } = runs[k].pose(time);
      sensed.hidden = { lidar: !wanted.lidar, map: !wanted.map };
      sensed.show(time, world.height(at.x, at.y));
      sensed.estimate.visible = wanted.estimate;
    });
    canvas.parentElement.hidden = !wanted.depth || !senses[followed].has.depth;
    if (!canvas.parentElement.hidden) senses[followed].drawDepth(canvas, time);
    this.dirty = true;
  }

  // The ground as the vehicle that is followed has left it: each run has a world of its own.
  showRuts() {
    const { dug, followed, data, world, scene } = this;
    if (!data.runs[followed].ruts.count) return;
    if (!dug[followed]) {
      dug[followed] = new Dug(data.runs[followed], world, this.deepest);
      scene.add(dug[followed].group);
    }
    dug[followed].show(this.digs ? this.time : -1);
  }

  // The one that is followed, and the others as ghosts.
  showRuns() {
    this.runs.forEach((run, k) => {
      run.look(k !== this.followed, this.through);
      run.group.visible = this.ghosts || k === this.followed;
    });
    this.dirty = true;
  }

  follow(k) {
    this.followed = k;
    this.showRuns();
    this.dug.forEach((dug, i) => { if (dug) dug.group.visible = i === k; });
    this.showRuts();
    const { grains, pits, dug } = this;
    grains.forEach((one, i) => { if (one) one.group.visible = i === k; });
    const open = dug[k]?.closed;
    this.world.leaveOut(grains[k] ? pits.map((pit, i) => pit || open?.[i] || 0) : open);
  }

  // Everything at a time.
  show(time) {
    const { unit, world, eye, orbit, centre, mode } = this;
    this.time = time;
    for (const run of this.runs) run.show(time);
    this.showRuts();
    this.grains[this.followed]?.show(time);
    const { at, turn } = this.runs[this.followed].pose(time);
    const moved = at.clone().sub(centre);
    centre.copy(at);
    this.sun.position.copy(at).add(this.toSun);
    this.sun.target.position.copy(at);
    const ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(turn);
    const heading = new THREE.Vector3(ahead.x, ahead.y, 0).normalize();
    if (mode === 'follow') {
      eye.position.add(moved);
      orbit.target.add(moved);
    } else if (mode === 'chase') {
      eye.position.copy(at).addScaledVector(heading, -9.5 * unit).addScaledVector(UP, 4 * unit);
      eye.position.z = Math.max(eye.position.z, world.height(eye.position.x, eye.position.y) + unit);
      eye.lookAt(at.clone().addScaledVector(heading, 3 * unit));
    } else if (mode === 'cockpit') {
      eye.position.copy(new THREE.Vector3(0.15, 0.35, 1.55).multiplyScalar(unit).applyQuaternion(turn).add(at));
      eye.up.copy(UP).applyQuaternion(turn);
      eye.lookAt(eye.position.clone().add(ahead).addScaledVector(UP, -0.12));
      eye.up.copy(UP);
    } else if (mode === 'top' && !this.free) this.centreMap(at);
    this.dirty = true;
  }

  centreMap(at) {
    this.pan.target.copy(at);
    this.above.position.set(at.x, at.y, at.z + HIGH * this.unit);
    this.pan.update();
  }

  // One of the views, as it is at first.
  look(mode) {
    const { eye, orbit, pan, unit, data } = this;
    Object.assign(this, { mode, touched: false, free: false });
    pan.zoomToCursor = false;
    const { at, turn } = this.runs[this.followed].pose(this.time);
    orbit.enabled = mode === 'follow' || mode === 'world';
    pan.enabled = mode === 'top';
    orbit.target.copy(at);
    const ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(turn);
    if (mode === 'follow') eye.position.copy(at).add(new THREE.Vector3(-11 * ahead.x + 6 * ahead.y, -11 * ahead.y - 6 * ahead.x, 7).multiplyScalar(unit));
    if (mode === 'world') {
      const half = Math.max(...data.ground.half);
      orbit.target.set(0, 0, at.z);
      eye.position.set(-0.55 * half, -1.75 * half, 1.35 * half);
    }
    if (mode === 'top') {
      this.above.zoom = 1;
      this.centreMap(at);
    }
    this.centre.copy(at);
    if (orbit.enabled) orbit.update();
    this.frame();
    this.show(this.time);
    this.onView?.();
  }

  // Nearer (above 1) or farther.
  zoom(factor) {
    this.touched = true;
    if (this.mode === 'top') {
      this.above.zoom = Math.min(this.pan.maxZoom, Math.max(this.pan.minZoom, this.above.zoom * factor));
      this.above.updateProjectionMatrix();
    } else if (this.orbit.enabled) {
      const { eye, orbit } = this;
      eye.position.sub(orbit.target).divideScalar(factor).add(orbit.target);
    } else return;
    this.dirty = true;
    this.onView?.();
  }

  // Sideways and up, in steps: moves the map, or turns the camera about what it looks at.
  move(right, up) {
    this.touched = true;
    if (this.mode === 'top') {
      const step = (0.1 * this.span) / this.above.zoom;
      for (const p of [this.pan.target, this.above.position]) { p.x += right * step; p.y += up * step; }
      this.pan.update();
      this.freed();
    } else if (this.orbit.enabled) {
      const { eye, orbit } = this;
      const from = eye.position.clone().sub(orbit.target).applyAxisAngle(UP, 0.12 * right);
      const side = from.clone().cross(UP).normalize();
      const turned = from.clone().applyAxisAngle(side, 0.08 * up);
      const polar = turned.angleTo(UP);
      eye.position.copy(polar > 0.05 && polar < orbit.maxPolarAngle ? turned : from).add(orbit.target);
      orbit.update();
    } else return;
    this.dirty = true;
    this.onView?.();
  }

  // What tells this view from that at first: names and values of the address.
  get view() {
    const { mode, eye, orbit, pan, centre } = this;
    const list = (p) => p.toArray().map((v) => number(v, 2)).join(',');
    const told = [];
    if (!this.touched) return told;
    if (mode === 'follow') told.push(['eye', list(eye.position.clone().sub(centre))], ['aim', list(orbit.target.clone().sub(centre))]);
    if (mode === 'world') told.push(['eye', list(eye.position)], ['aim', list(orbit.target)]);
    if (mode === 'top') {
      if (this.free) told.push(['at', `${number(pan.target.x)},${number(pan.target.y)}`]);
      told.push(['span', number(this.span / this.above.zoom)]);
    }
    return told;
  }

  // The view of an address, whose numbers `numbers` gives by name and count.
  restore(numbers) {
    const { mode, eye, orbit, pan, centre, above } = this;
    const [from, aim, at, span] = [numbers('eye', 3), numbers('aim', 3), numbers('at', 2), numbers('span', 1)];
    if (orbit.enabled && from && aim) {
      const origin = mode === 'follow' ? centre : new THREE.Vector3();
      eye.position.set(...from).add(origin);
      orbit.target.set(...aim).add(origin);
      orbit.update();
      this.touched = true;
    }
    if (mode === 'top' && (at || span?.[0] > 0)) {
      if (at) {
        this.free = true;
        this.centreMap(new THREE.Vector3(...at, this.world.height(...at)));
      }
      if (span?.[0] > 0) above.zoom = Math.min(pan.maxZoom, Math.max(pan.minZoom, this.span / span[0]));
      above.updateProjectionMatrix();
      this.touched = true;
      this.freed();
    }
    this.dirty = true;
  }

  // Where a place is on the page, px from the left and the top.
  project(x, y, z) {
    this.camera.updateMatrixWorld();
    const p = new THREE.Vector3(x, y, z).project(this.camera);
    return [(0.5 + 0.5 * p.x) * this.canvas.clientWidth, (0.5 - 0.5 * p.y) * this.canvas.clientHeight];
  }

  // Metres of the top view in a pixel of the page.
  get metresPerPixel() { return this.span / this.above.zoom / (this.canvas.clientHeight || 1); }

  // Fits the cameras to the window.
  frame() {
    const [w, h] = [innerWidth, innerHeight];
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    this.renderer.setSize(w, h, false);
    this.eye.aspect = w / h;
    this.eye.updateProjectionMatrix();
    const half = 0.5 * this.span;
    Object.assign(this.above, { left: (-half * w) / h, right: (half * w) / h, top: half, bottom: -half });
    this.above.updateProjectionMatrix();
    this.dirty = true;
  }

  render() {
    if (!this.dirty) return;
    this.dirty = false;
    this.renderer.render(this.scene, this.camera);
  }
}
