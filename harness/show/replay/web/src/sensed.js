// What the sensors measured: the lidar's points, the local map, the depth camera's image, the estimated way.
import * as THREE from 'three';
import { floats, locate, scale } from './data.js';

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const words = (text) => new Int16Array(bytes(text).buffer);
const UNSEEN = -32768;

// The last entry at or before a time; none before the first.
function last(entries, time) {
  let found = null;
  for (const entry of entries) {
    if (entry[0] > time + 1e-6) break;
    found = entry;
  }
  return found;
}

function colourOf(classes, label) {
  if (label === 10) return [192, 65, 43];
  return classes[label]?.colour ?? [120, 126, 130];
}

export class Sensed {
  constructor(data, classes, unit) {
    Object.assign(this, { data, classes, unit });
    this.group = new THREE.Group();
    this.lidar = this.makeLidar();
    this.map = new THREE.Group();
    this.estimate = this.makeEstimate();
    this.group.add(this.lidar, this.map, this.estimate);
    this.shown = {};
    this.labels = true;
  }

  get has() {
    const { scans, maps, images } = this.data;
    return {
      lidar: scans.length > 0, map: maps.length > 0, depth: images.length > 0, estimate: this.estimate.children.length > 0,
    };
  }

  makeLidar() {
    const material = new THREE.PointsMaterial({ size: 3, sizeAttenuation: false, vertexColors: true });
    const points = new THREE.Points(new THREE.BufferGeometry(), material);
    points.frustumCulled = false;
    return points;
  }

  // The way as it was estimated, and the positions from satellites.
  makeEstimate() {
    const group = new THREE.Group();
    const poses = floats(this.data.poses);
    const lift = 0.35 * this.unit;
    this.poseTimes = [];
    const way = [];
    for (let k = 0; k < poses.length; k += 5) {
      this.poseTimes.push(poses[k]);
      way.push(new THREE.Vector3(poses[k + 1], poses[k + 2], poses[k + 3] + lift));
    }
    this.poses = poses;
    if (way.length > 1) {
      const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(way), new THREE.LineDashedMaterial({ color: 0xff5ad1, dashSize: 0.6 * this.unit, gapSize: 0.3 * this.unit }));
      line.computeLineDistances();
      this.cursor = new THREE.Mesh(new THREE.ConeGeometry(0.35 * this.unit, 1.2 * this.unit, 12), new THREE.MeshBasicMaterial({ color: 0xff5ad1 }));
      group.add(line, this.cursor);
    }
    const fixes = floats(this.data.fixes);
    if (fixes.length) {
      const places = [];
      for (let k = 0; k < fixes.length; k += 4) places.push(fixes[k + 1], fixes[k + 2], fixes[k + 3] + lift);
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.Float32BufferAttribute(places, 3));
      group.add(new THREE.Points(geometry, new THREE.PointsMaterial({ color: 0xffe14d, size: 3, sizeAttenuation: false })));
    }
    return group;
  }

  showLidar(entry) {
    this.lidar.visible = Boolean(entry);
    if (!entry || this.shown.lidar === entry) return;
    this.shown.lidar = entry;
    const [, centre, text] = entry;
    const cm = words(text);
    const position = new Float32Array(cm.length);
    const colour = new Float32Array(cm.length);
    for (let k = 0; k < cm.length; k += 3) {
      for (let i = 0; i < 3; i += 1) position[k + i] = centre[i] + cm[k + i] / 100;
      // So that half of them do not hide in the ground that they lie on.
      position[k + 2] += 0.05 * this.unit;
      // By the height over and under the vehicle.
      colour.set(scale(0.5 + cm[k + 2] / 100 / (5 * this.unit)), k);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(colour, 3));
    this.lidar.geometry.dispose();
    this.lidar.geometry = geometry;
  }

  showMap(entry) {
    this.map.visible = Boolean(entry);
    if (!entry || this.shown.map === entry) return;
    this.shown.map = entry;
    const [, [rows, cols, resolution, x, y], text, classText, occupiedText] = entry;
    const [heights, classes, occupied] = [words(text), bytes(classText), bytes(occupiedText)];
    const places = [];
    const colours = [];
    const lift = 0.06 * this.unit;
    // A small plate for each cell that was seen.
    const half = 0.42 * resolution;
    for (let k = 0; k < rows * cols; k += 1) {
      const isObstacle = occupied[k] === 1;
      if (heights[k] === UNSEEN && !isObstacle) continue;
      const z = (heights[k] === UNSEEN ? this.ground ?? 0 : heights[k] / 100) + (isObstacle ? 5 * lift : lift);
      const [cx, cy] = [x + (k % cols) * resolution, y + Math.floor(k / cols) * resolution];
      const [w, e, s, n] = [cx - half, cx + half, cy - half, cy + half];
      places.push(w, s, z, e, s, z, e, n, z, w, s, z, e, n, z, w, n, z);
      const colour = (isObstacle ? [214, 48, 36] : colourOf(this.classes, classes[k])).map((v) => v / 255);
      for (let i = 0; i < 6; i += 1) colours.push(...colour);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(places, 3));
    geometry.setAttribute('color', new THREE.Float32BufferAttribute(colours, 3));
    const material = new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide, transparent: true, opacity: 0.85 });
    this.map.children.forEach((child) => child.geometry.dispose());
    this.map.clear();
    this.map.add(new THREE.Mesh(geometry, material));
  }

  // The depth camera's image on a canvas: kinds of ground, darker the farther away, or depths alone.
  drawDepth(canvas, time) {
    const entry = last(this.data.images, time);
    canvas.parentElement.hidden = !entry;
    if (!entry) return;
    const [rows, cols] = this.data.image;
    const key = [entry, this.labels];
    if (this.shown.depth?.[0] === key[0] && this.shown.depth[1] === key[1]) return;
    this.shown.depth = key;
    const [depths, labels] = [bytes(entry[1]), bytes(entry[2])];
    canvas.width = cols;
    canvas.height = rows;
    const context = canvas.getContext('2d');
    const image = context.createImageData(cols, rows);
    for (let k = 0; k < rows * cols; k += 1) {
      const far = depths[k] / 255;
      let colour = [18, 22, 26];
      if (depths[k] > 0) {
        colour = this.labels && labels.length
          ? colourOf(this.classes, labels[k]).map((v) => v * (1 - 0.65 * far))
          : scale(1 - far).map((v) => 255 * v);
      }
      image.data.set([...colour, 255], 4 * k);
    }
    context.putImageData(image, 0, 0);
  }

  show(time, ground) {
    this.ground = ground;
    this.showLidar(this.hidden?.lidar ? null : last(this.data.scans, time));
    this.showMap(this.hidden?.map ? null : last(this.data.maps, time));
    if (this.cursor) {
      const [k] = locate(this.poseTimes, time);
      const [, x, y, z, yaw] = this.poses.subarray(5 * k, 5 * k + 5);
      this.cursor.position.set(x, y, z + 0.5 * this.unit);
      // A cone points along its y axis.
      this.cursor.rotation.set(0, 0, yaw - Math.PI / 2);
    }
  }
}
