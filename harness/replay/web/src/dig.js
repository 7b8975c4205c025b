// The ground where it yielded: its mesh is refined there, and sinks where wheels have passed.
import * as THREE from 'three';

const STEPS = 16; // parts of a ground cell's side at most
const RAMP = [[255, 226, 140], [238, 134, 52], [168, 40, 74], [62, 8, 78]]; // from shallow to deep
const HEAP = [250, 244, 230];

const mix = (share) => {
  const at = Math.min(1, Math.max(0, share)) * (RAMP.length - 1);
  const k = Math.min(RAMP.length - 2, Math.floor(at));
  return RAMP[k].map((v, i) => v + (at - k) * (RAMP[k + 1][i] - v));
};
export const rutGradient = () => `linear-gradient(90deg,${RAMP.map((s) => `rgb(${s})`).join(',')})`;

// The end of the scale of depths: the deepest rut of all, on a round number of centimetres (millimetres in small worlds).
export function deepest(runs) {
  let most = 0;
  for (const run of runs) for (let k = 3; k < run.ruts.length; k += 5) most = Math.max(most, run.ruts[k]);
  const step = most > 0.02 ? 0.01 : 0.001;
  return Math.max(step, Math.ceil(most / step - 1e-6) * step);
}

// A ground material whose colour gives way to that of the attribute `rut`, as much as its fourth component says.
export function rutMaterial(map) {
  const material = new THREE.MeshLambertMaterial({ map });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nattribute vec4 rut;\nvarying vec4 vRut;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\nvRut = rut;');
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', '#include <common>\nvarying vec4 vRut;')
      .replace('#include <map_fragment>', '#include <map_fragment>\ndiffuseColor.rgb = mix(diffuseColor.rgb, vRut.rgb, vRut.a);');
  };
  return material;
}

export class Dug {
  // `most` is the depth at the end of the scale of colours, m.
  constructor(run, world, most) {
    Object.assign(this, { run, world, most, shown: 0 });
    this.group = new THREE.Group();
    this.readCells();
    this.open = this.openCells();
    this.makeMesh();
    this.dig();
  }

  // The cells of the soil: where each is, and which of them each entry of the list of ruts is about.
  readCells() {
    const { ruts, soil_resolution: side } = this.run;
    const [hx, hy] = this.world.raster.half;
    const wide = Math.ceil((2 * hx) / side) + 2;
    const known = new Map();
    this.of = new Int32Array(ruts.length / 5);
    for (let k = 0; k < this.of.length; k += 1) {
      const [i, j] = [Math.round((ruts[5 * k + 1] + hx) / side - 0.5), Math.round((ruts[5 * k + 2] + hy) / side - 0.5)];
      const key = j * wide + i;
      if (!known.has(key)) known.set(key, known.size);
      this.of[k] = known.get(key);
    }
    Object.assign(this, { wide, known });
    this.depth = new Float32Array(known.size);
    this.raised = new Float32Array(known.size);
  }

  // The cells of the ground that are refined: those with a rut in them or just beside.
  openCells() {
    const { rows, cols, resolution, half } = this.world.raster;
    const side = this.run.soil_resolution;
    const open = new Uint8Array((rows - 1) * (cols - 1));
    const within = (v, n) => Math.min(n - 2, Math.max(0, Math.floor(v)));
    for (const key of this.known.keys()) {
      const [x, y] = [((key % this.wide) + 0.5) * side, (Math.floor(key / this.wide) + 0.5) * side];
      for (let r = within((y - 1.5 * side) / resolution[1], rows); r <= within((y + 1.5 * side) / resolution[1], rows); r += 1) {
        for (let c = within((x - 1.5 * side) / resolution[0], cols); c <= within((x + 1.5 * side) / resolution[0], cols); c += 1) {
          open[r * (cols - 1) + c] = 1;
        }
      }
    }
    this.half = half;
    return open;
  }

  makeMesh() {
    const { open, world } = this;
    const { rows, cols, resolution, half, z } = world.raster;
    const side = this.run.soil_resolution;
    const [nx, ny] = resolution.map((r) => Math.min(STEPS, Math.max(1, Math.ceil(r / side - 1e-6))));
    const lattice = (cols - 1) * nx + 1;
    const vertices = new Map();
    const index = [];
    const vertex = (i, j) => {
      const key = j * lattice + i;
      let k = vertices.get(key);
      if (k === undefined) {
        k = vertices.size;
        vertices.set(key, k);
      }
      return k;
    };
    const floor = [];
    for (let cell = 0; cell < open.length; cell += 1) {
      if (!open[cell]) continue;
      const [r, c] = [Math.floor(cell / (cols - 1)), cell % (cols - 1)];
      for (let v = 0; v < ny; v += 1) {
        for (let u = 0; u < nx; u += 1) {
          const [i, j] = [c * nx + u, r * ny + v];
          const [a, b, d, e] = [vertex(i, j), vertex(i + 1, j), vertex(i, j + 1), vertex(i + 1, j + 1)];
          index.push(a, b, e, a, e, d);
        }
      }
      const k = r * cols + c;
      floor.push(k, k + 1, k + cols + 1, k, k + cols + 1, k + cols);
    }
    const count = vertices.size;
    const position = new Float32Array(3 * count);
    const uv = new Float32Array(2 * count);
    // Of each vertex: its height before anything, the slope of the ground, the four soil cells about it, its neighbours.
    this.base = new Float32Array(count);
    this.slope = new Float32Array(2 * count);
    this.cells = new Int32Array(4 * count);
    this.share = new Float32Array(2 * count);
    this.beside = new Int32Array(4 * count);
    this.change = new Float32Array(count + 1); // the last one stays 0: what lies beyond
    const normals = world.ground.geometry.getAttribute('normal').array;
    for (const [key, k] of vertices) {
      const [i, j] = [key % lattice, Math.floor(key / lattice)];
      const [x, y] = [(i * resolution[0]) / nx - half[0], (j * resolution[1]) / ny - half[1]];
      this.base[k] = world.height(x, y);
      position.set([x, y, this.base[k]], 3 * k);
      uv.set(world.uv(x, y), 2 * k);
      const [c, r] = [Math.min(cols - 2, Math.floor(i / nx)), Math.min(rows - 2, Math.floor(j / ny))];
      const [u, v] = [i / nx - c, j / ny - r];
      for (let axis = 0; axis < 2; axis += 1) {
        const at = (row, col) => { const n = 3 * (row * cols + col); return normals[n + axis] / normals[n + 2]; };
        const low = at(r, c) * (1 - u) + at(r, c + 1) * u;
        const high = at(r + 1, c) * (1 - u) + at(r + 1, c + 1) * u;
        this.slope[2 * k + axis] = low * (1 - v) + high * v;
      }
      const [fx, fy] = [(x + half[0]) / side - 0.5, (y + half[1]) / side - 0.5];
      const [ci, cj] = [Math.floor(fx), Math.floor(fy)];
      [[0, 0], [1, 0], [0, 1], [1, 1]].forEach(([p, q], n) => {
        this.cells[4 * k + n] = this.known.get((cj + q) * this.wide + ci + p) ?? -1;
      });
      this.share.set([fx - ci, fy - cj], 2 * k);
      [key + 1, key - 1, key + lattice, key - lattice].forEach((other, n) => {
        // No neighbour beyond the edge of the lattice.
        const apart = n < 2 && Math.floor(other / lattice) !== j;
        this.beside[4 * k + n] = apart ? count : vertices.get(other) ?? count;
      });
    }
    this.apart = [resolution[0] / nx, resolution[1] / ny];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute('uv', new THREE.BufferAttribute(uv, 2));
    geometry.setAttribute('rut', new THREE.BufferAttribute(new Float32Array(4 * count), 4));
    geometry.setIndex(index);
    this.mesh = new THREE.Mesh(geometry, world.dugMaterial);
    this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    // The ground as it was, below the deepest rut: whatever shows between the two meshes has its colour.
    const low = world.ground.geometry.clone();
    low.setIndex(floor);
    const below = new THREE.Mesh(low, world.ground.material);
    below.position.z = -1.2 * this.most - side;
    this.group.add(this.mesh, below);
  }

  // The ground as it is at a time; before all of them, untouched.
  show(time) {
    const { ruts } = this.run;
    let [count, high] = [0, this.of.length];
    while (count < high) {
      const middle = (count + high) >> 1;
      if (ruts[5 * middle] <= time) count = middle + 1;
      else high = middle;
    }
    if (count === this.shown) return;
    if (count < this.shown) {
      this.depth.fill(0);
      this.raised.fill(0);
      this.shown = 0;
    }
    for (let k = this.shown; k < count; k += 1) {
      this.depth[this.of[k]] = ruts[5 * k + 3];
      this.raised[this.of[k]] = ruts[5 * k + 4];
    }
    this.shown = count;
    this.dig();
  }

  dig() {
    const { change, base, cells, share, beside, slope, mesh } = this;
    const [position, normal, rut] = ['position', 'normal', 'rut'].map((name) => mesh.geometry.getAttribute(name));
    const paint = (v) => (v / 255) ** 2.2;
    const heap = HEAP.map(paint);
    for (let k = 0; k < base.length; k += 1) {
      const [u, v] = [share[2 * k], share[2 * k + 1]];
      let [depth, raised] = [0, 0];
      for (let n = 0; n < 4; n += 1) {
        const cell = cells[4 * k + n];
        if (cell < 0) continue;
        const weight = (n & 1 ? u : 1 - u) * (n & 2 ? v : 1 - v);
        depth += weight * this.depth[cell];
        raised += weight * this.raised[cell];
      }
      change[k] = raised - depth;
      position.array[3 * k + 2] = base[k] + change[k];
      const own = 4 * k;
      if (depth > 1e-4 && depth >= raised) {
        const part = depth / this.most;
        const colour = mix(part);
        for (let i = 0; i < 3; i += 1) rut.array[own + i] = paint(colour[i]);
        rut.array[own + 3] = Math.min(0.85, 4 * part + 0.1);
      } else {
        for (let i = 0; i < 3; i += 1) rut.array[own + i] = heap[i];
        rut.array[own + 3] = Math.min(0.45, (2 * raised) / this.most);
      }
    }
    for (let k = 0; k < base.length; k += 1) {
      const [e, w, n, s] = beside.subarray(4 * k, 4 * k + 4);
      const gx = slope[2 * k] - (change[e] - change[w]) / (2 * this.apart[0]);
      const gy = slope[2 * k + 1] - (change[n] - change[s]) / (2 * this.apart[1]);
      const length = Math.hypot(gx, gy, 1);
      normal.array[3 * k] = gx / length;
      normal.array[3 * k + 1] = gy / length;
      normal.array[3 * k + 2] = 1 / length;
    }
    for (const attribute of [position, normal, rut]) attribute.needsUpdate = true;
  }

  // For tests: how many cells have yielded, and how far the mesh lies below the ground as it was at most, m.
  get state() {
    let cells = 0;
    for (let k = 0; k < this.depth.length; k += 1) if (this.depth[k] > 0 || this.raised[k] > 0) cells += 1;
    let sunk = 0;
    const z = this.mesh.geometry.getAttribute('position').array;
    for (let k = 0; k < this.base.length; k += 1) sunk = Math.max(sunk, this.base[k] - z[3 * k + 2]);
    return { cells, sunk };
  }
}
