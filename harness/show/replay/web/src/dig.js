// The ground where it yielded: its mesh is refined there, and sinks where wheels have passed.
import * as THREE from 'three';

const STEPS = 16; // parts of a ground cell's side at most
const RAMP = [[250, 196, 236], [206, 92, 190], [124, 32, 134], [44, 6, 66]]; // from shallow to deep, unlike any ground or trail
const HEAP = [250, 244, 230];

const mix = (share) => {
  const at = Math.min(1, Math.max(0, share)) * (RAMP.length - 1);
  const k = Math.min(RAMP.length - 2, Math.floor(at));
  return RAMP[k].map((v, i) => v + (at - k) * (RAMP[k + 1][i] - v));
};
export const rutGradient = () => `linear-gradient(90deg,${RAMP.map((s) => `rgb(${s})`).join(',')})`;

// The end of the scale of depths: the deepest rut of all, on a round number of centimetres (millimetres in small worlds).
export function deepest(runs) {
  const most = Math.max(...runs.map((run) => run.ruts.deepest));
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
    const { count, side, x, y } = this.run.ruts;
    this.wide = Math.ceil((2 * this.world.raster.half[0]) / side) + 2;
    this.known = new Map();
    this.of = new Int32Array(count);
    for (let k = 0; k < count; k += 1) {
      const key = y[k] * this.wide + x[k];
      if (!this.known.has(key)) this.known.set(key, this.known.size);
      this.of[k] = this.known.get(key);
    }
    this.yielded = new Float32Array(this.known.size);
  }

  // The cells of the ground that are refined: those with a rut in them or just beside.
  openCells() {
    const { rows, cols, resolution } = this.world.raster;
    const { side } = this.run.ruts;
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
    return open;
  }

  makeMesh() {
    const { open, world } = this;
    const { rows, cols, resolution, half, z } = world.raster;
    const { side } = this.run.ruts;
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
    const closed = open.slice(); // what the ground's own mesh leaves out: these, and those beside them
    const at = (r, c) => r >= 0 && c >= 0 && r < rows - 1 && c < cols - 1 && open[r * (cols - 1) + c] === 1;
    for (let r = 0; r + 1 < rows; r += 1) {
      for (let c = 0; c + 1 < cols; c += 1) {
        const [i, j] = [c * nx, r * ny];
        if (at(r, c)) {
          for (let v = 0; v < ny; v += 1) {
            for (let u = 0; u < nx; u += 1) {
              const [a, b, d, e] = [[0, 0], [1, 0], [0, 1], [1, 1]].map(([p, q]) => vertex(i + u + p, j + v + q));
              index.push(a, b, e, a, e, d);
            }
          }
          continue;
        }
        const beside = { south: at(r - 1, c), north: at(r + 1, c), west: at(r, c - 1), east: at(r, c + 1) };
        if (!Object.values(beside).some(Boolean)) continue;
        // Between fine and coarse: each of the two triangles takes in all points on its sides, so that no gap is left.
        closed[r * (cols - 1) + c] = 1;
        const points = (n, isFine, along) => Array.from({ length: (isFine ? n : 1) + 1 }, (_, k) => vertex(...along(isFine ? k : k * n)));
        const south = points(nx, beside.south, (k) => [i + k, j]);
        const east = points(ny, beside.east, (k) => [i + nx, j + k]);
        const north = points(nx, beside.north, (k) => [i + nx - k, j + ny]);
        const west = points(ny, beside.west, (k) => [i, j + ny - k]);
        for (const [first, second] of [[south, east], [north, west]]) {
          const far = second.at(-1);
          for (let k = 0; k + 2 < first.length; k += 1) index.push(first[k], first[k + 1], far);
          const near = first.at(-2);
          for (let k = 0; k + 1 < second.length; k += 1) index.push(near, second[k], second[k + 1]);
        }
      }
    }
    this.closed = closed;
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
      // By the same sums as the ground's own nodes, to the last bit.
      const [column, row] = [Math.floor(i / nx), Math.floor(j / ny)];
      const isNode = i % nx === 0 && j % ny === 0;
      const x = (column + (i % nx) / nx) * resolution[0] - half[0];
      const y = (row + (j % ny) / ny) * resolution[1] - half[1];
      this.base[k] = isNode ? z[row * cols + column] : world.height(x, y);
      position.set([x, y, this.base[k]], 3 * k);
      uv.set(world.uv(x, y), 2 * k);
      const [c, r] = [Math.min(cols - 2, column), Math.min(rows - 2, row)];
      const [u, v] = [i / nx - c, j / ny - r];
      for (let axis = 0; axis < 2; axis += 1) {
        const tilt = (south, west) => { const n = 3 * (south * cols + west); return normals[n + axis] / normals[n + 2]; };
        const low = tilt(r, c) * (1 - u) + tilt(r, c + 1) * u;
        const high = tilt(r + 1, c) * (1 - u) + tilt(r + 1, c + 1) * u;
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
    this.group.add(this.mesh);
  }

  // The ground as it is at a time; before all of them, untouched.
  show(time) {
    const { times, change } = this.run.ruts;
    let [count, high] = [0, times.length];
    while (count < high) {
      const middle = (count + high) >> 1;
      if (times[middle] <= time) count = middle + 1;
      else high = middle;
    }
    if (count === this.shown) return;
    if (count < this.shown) {
      this.yielded.fill(0);
      this.shown = 0;
    }
    for (let k = this.shown; k < count; k += 1) this.yielded[this.of[k]] = change[k];
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
      change[k] = 0;
      for (let n = 0; n < 4; n += 1) {
        const cell = cells[4 * k + n];
        if (cell >= 0) change[k] += (n & 1 ? u : 1 - u) * (n & 2 ? v : 1 - v) * this.yielded[cell];
      }
      position.array[3 * k + 2] = base[k] + change[k];
      const part = -change[k] / this.most;
      const colour = part > 0 ? mix(part).map(paint) : heap;
      for (let i = 0; i < 3; i += 1) rut.array[4 * k + i] = colour[i];
      rut.array[4 * k + 3] = part > 0 ? Math.min(0.85, 6 * part) : Math.min(0.45, -2 * part);
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
    const cells = this.yielded.reduce((n, v) => n + (v !== 0), 0);
    let sunk = 0;
    const z = this.mesh.geometry.getAttribute('position').array;
    for (let k = 0; k < this.base.length; k += 1) sunk = Math.max(sunk, this.base[k] - z[3 * k + 2]);
    return { cells, sunk };
  }
}
