// The world: ground with its classes, obstacles, global path, start and goal.
import * as THREE from 'three';
import { heightOf } from './data.js';
import { rutMaterial } from './dig.js';
import { unpackMeshes } from './packed.js';

const SHADING = 1.6; // heights are so much exaggerated in the shading, as on relief maps
const PIXELS = 1024;

function texture(semantics, coloured) {
  const { rows, cols, labels, classes } = semantics;
  const per = Math.max(1, Math.floor(PIXELS / Math.max(rows, cols)));
  const canvas = document.createElement('canvas');
  canvas.width = cols * per;
  canvas.height = rows * per;
  const context = canvas.getContext('2d');
  const image = context.createImageData(canvas.width, canvas.height);
  let seed = 7;
  for (let y = 0; y < canvas.height; y += 1) {
    // The canvas has its first row in the north.
    const r = rows - 1 - Math.floor(y / per);
    for (let x = 0; x < canvas.width; x += 1) {
      const label = Number(labels[r * cols + Math.floor(x / per)]);
      const colour = coloured ? classes[label].colour : [172, 166, 150];
      seed = (Math.imul(seed, 1664525) + 1013904223) | 0;
      // A little grain, so that the eye sees the ground move by.
      const grain = ((seed >>> 24) / 255 - 0.5) * 26;
      const k = 4 * (y * canvas.width + x);
      for (let i = 0; i < 3; i += 1) image.data[k + i] = colour[i] + grain;
      image.data[k + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  map.anisotropy = 8;
  return map;
}

// Where a place is on the texture.
function place(semantics) {
  const { rows, cols, patch } = semantics;
  return (x, y) => [x / (cols * patch) + 0.5, y / (rows * patch) + 0.5];
}

// The triangles of the ground's cells but those that are open.
function triangles(rows, cols, open) {
  const index = new Uint32Array(6 * (rows - 1) * (cols - 1));
  let i = 0;
  for (let r = 0; r + 1 < rows; r += 1) {
    for (let c = 0; c + 1 < cols; c += 1) {
      if (open?.[r * (cols - 1) + c]) continue;
      const k = r * cols + c;
      index.set([k, k + 1, k + cols + 1, k, k + cols + 1, k + cols], i);
      i += 6;
    }
  }
  return new THREE.BufferAttribute(index.subarray(0, i), 1);
}

function surface(data, onTexture) {
  const { rows, cols, resolution, half, z } = data.ground;
  const position = new Float32Array(3 * rows * cols);
  const normal = new Float32Array(3 * rows * cols);
  const uv = new Float32Array(2 * rows * cols);
  for (let r = 0; r < rows; r += 1) {
    for (let c = 0; c < cols; c += 1) {
      const k = r * cols + c;
      const [x, y] = [c * resolution[0] - half[0], r * resolution[1] - half[1]];
      position.set([x, y, z[k]], 3 * k);
      uv.set(onTexture(x, y), 2 * k);
      const [w, e] = [Math.max(0, c - 1), Math.min(cols - 1, c + 1)];
      const [s, n] = [Math.max(0, r - 1), Math.min(rows - 1, r + 1)];
      const gx = (SHADING * (z[r * cols + e] - z[r * cols + w])) / ((e - w) * resolution[0]);
      const gy = (SHADING * (z[n * cols + c] - z[s * cols + c])) / ((n - s) * resolution[1]);
      const length = Math.hypot(gx, gy, 1);
      normal.set([-gx / length, -gy / length, 1 / length], 3 * k);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(normal, 3));
  geometry.setAttribute('uv', new THREE.BufferAttribute(uv, 2));
  geometry.setIndex(triangles(rows, cols));
  return geometry;
}

// Walls around the ground, down to a level base: the world is a block that one looks at.
function skirt(data) {
  const { rows, cols, resolution, half, z } = data.ground;
  let low = Infinity;
  for (const v of z) low = Math.min(low, v);
  const base = low - 0.03 * half[0];
  const edge = [];
  for (let c = 0; c < cols; c += 1) edge.push([0, c]);
  for (let r = 1; r < rows; r += 1) edge.push([r, cols - 1]);
  for (let c = cols - 2; c >= 0; c -= 1) edge.push([rows - 1, c]);
  for (let r = rows - 2; r >= 0; r -= 1) edge.push([r, 0]);
  const position = [];
  for (let k = 0; k + 1 < edge.length; k += 1) {
    const [a, b] = [edge[k], edge[k + 1]].map(([r, c]) => [c * resolution[0] - half[0], r * resolution[1] - half[1], z[r * cols + c]]);
    const [al, bl] = [[a[0], a[1], base], [b[0], b[1], base]];
    position.push(...a, ...al, ...b, ...b, ...al, ...bl);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(position, 3));
  geometry.computeVertexNormals();
  return new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color: 0x7c7265, side: THREE.DoubleSide }));
}

// Convex bodies in one piece, with flat faces.
export function bodies(meshes, material) {
  const position = [];
  for (const [points, triangles] of meshes) {
    for (const k of triangles) position.push(points[3 * k], points[3 * k + 1], points[3 * k + 2]);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(position, 3));
  geometry.computeVertexNormals();
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  return mesh;
}

// A band on the ground along points [x, y]; colours are of the points. Returns mesh and triangles' indices a point.
export function band(points, width, lift, height, colours, options) {
  const position = new Float32Array(6 * points.length);
  const index = [];
  points.forEach(([x, y], k) => {
    const [ax, ay] = points[Math.max(0, k - 1)];
    const [bx, by] = points[Math.min(points.length - 1, k + 1)];
    const length = Math.hypot(bx - ax, by - ay) || 1;
    const [nx, ny] = [(-(by - ay) / length) * width * 0.5, ((bx - ax) / length) * width * 0.5];
    [[x + nx, y + ny], [x - nx, y - ny]].forEach(([u, v], side) => {
      position.set([u, v, Math.max(height(u, v), height(x, y)) + lift], 6 * k + 3 * side);
    });
    if (k > 0) index.push(2 * k - 2, 2 * k - 1, 2 * k, 2 * k, 2 * k - 1, 2 * k + 1);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
  if (colours) geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  geometry.setIndex(index);
  const material = new THREE.MeshBasicMaterial({
    side: THREE.DoubleSide, vertexColors: Boolean(colours), polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -4,
    // Of bands that lie on each other the one that is drawn last is seen.
    depthWrite: !options.transparent, ...options,
  });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}

// Points along a polyline at even steps, so that what lies on the ground follows it.
function dense(points, step) {
  const out = [points[0]];
  for (let k = 1; k < points.length; k += 1) {
    const [a, b] = [points[k - 1], points[k]];
    const n = Math.max(1, Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / step));
    for (let i = 1; i <= n; i += 1) out.push([a[0] + ((b[0] - a[0]) * i) / n, a[1] + ((b[1] - a[1]) * i) / n]);
  }
  return out;
}

export function world(data, unit) {
  const height = heightOf(data.ground);
  const group = new THREE.Group();
  let plain = null;
  const coloured = texture(data.semantics, true);
  const uv = place(data.semantics);
  const ground = new THREE.Mesh(surface(data, uv), new THREE.MeshLambertMaterial({ map: coloured }));
  const dugMaterial = rutMaterial(coloured);
  const showClasses = (on) => {
    // The one without classes when it is asked for.
    const map = on ? coloured : (plain ??= texture(data.semantics, false));
    for (const material of [ground.material, dugMaterial]) material.map = map;
  };
  // Leaves out the cells that a finer mesh has.
  const leaveOut = (open) => ground.geometry.setIndex(triangles(data.ground.rows, data.ground.cols, open));
  ground.receiveShadow = true;
  group.add(ground, skirt(data));

  const obstacles = new THREE.Group();
  const [stones, trunks] = [data.stones, data.trunks].map(unpackMeshes);
  obstacles.add(bodies(stones, new THREE.MeshLambertMaterial({ color: 0x66635f, flatShading: true })));
  obstacles.add(bodies(trunks, new THREE.MeshLambertMaterial({ color: 0x5d4630, flatShading: true })));
  group.add(obstacles);

  const path = new THREE.Group();
  const [sx, sy, yaw] = data.start;
  if (data.goal && data.path.length > 1) {
    path.add(band(dense(data.path, 0.5 * unit), 0.22 * unit, 0.1 * unit, height, null, { color: 0xffffff, transparent: true, opacity: 0.75 }));
  }
  const ring = (x, y, radius, width, colour) => {
    const points = Array.from({ length: 97 }, (_, k) => [x + radius * Math.cos((k * Math.PI) / 48), y + radius * Math.sin((k * Math.PI) / 48)]);
    return band(points, width, 0.06 * unit, height, null, { color: colour });
  };
  if (data.goal) {
    path.add(ring(data.goal[0], data.goal[1], data.radius ?? unit, 0.35 * unit, 0xffd23f));
    const wall = new THREE.Mesh(
      new THREE.CylinderGeometry(data.radius ?? unit, data.radius ?? unit, 4 * unit, 96, 1, true),
      new THREE.MeshBasicMaterial({ color: 0xffd23f, transparent: true, opacity: 0.13, side: THREE.DoubleSide, depthWrite: false }),
    );
    wall.rotation.x = Math.PI / 2;
    wall.position.set(data.goal[0], data.goal[1], height(...data.goal) + 1.4 * unit);
    path.add(wall);
  }
  path.add(ring(sx, sy, 1.2 * unit, 0.2 * unit, 0xffffff));
  const ahead = [1.2, 3.2].map((d) => [sx + d * unit * Math.cos(yaw), sy + d * unit * Math.sin(yaw)]);
  path.add(band(dense(ahead, 0.5 * unit), 0.3 * unit, 0.07 * unit, height, null, { color: 0xffffff }));
  group.add(path);
  return {
    group, ground, dugMaterial, showClasses, leaveOut, uv, obstacles, path, height, raster: data.ground,
  };
}
