// The belt of a track: pads along the taut way around its wheels, which move with them.
import * as THREE from 'three';

const PAD = 2.5; // length over thickness

export class Belt {
  constructor(run, side) {
    const { wheels, belt } = run.vehicle;
    this.numbers = Array.from({ length: run.wheel_count / 2 }, (_, j) => 2 * j + side);
    this.radii = this.numbers.map((w) => wheels[w][0] + 0.5 * belt);
    this.inner = wheels[this.numbers[1]][0];
    this.thickness = belt;
    const width = wheels[this.numbers[0]][1];
    const pad = new THREE.BoxGeometry(0.9 * PAD * belt, width, 0.8 * belt);
    const material = new THREE.MeshLambertMaterial({ color: 0x2c2e31 });
    this.mesh = new THREE.InstancedMesh(pad, material, 256);
    this.mesh.frustumCulled = false;
  }

  // Straight parts and arcs, one after the other: from the foremost wheel below the others to the rear, and back above.
  way(centres) {
    const n = centres.length;
    const out = centres.map(([x, z], j) => {
      const [u, v] = centres[(j + 1) % n];
      const apart = Math.hypot(u - x, v - z);
      const [dx, dz] = [(u - x) / apart, (v - z) / apart];
      const sin = (this.radii[j] - this.radii[(j + 1) % n]) / apart;
      const cos = Math.sqrt(Math.max(0, 1 - sin * sin));
      return { out: [dx * sin - dz * cos, dz * sin + dx * cos], length: apart * cos };
    });
    return centres.flatMap(([x, z], j) => {
      const [a, b] = [out[(j + n - 1) % n].out, out[j].out];
      const from = Math.atan2(a[1], a[0]);
      let turn = Math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
      if (turn > Math.PI / 2) turn -= 2 * Math.PI;
      const r = this.radii[j];
      const arc = {
        length: Math.max(0, -turn * r),
        at: (s) => {
          const angle = from - s / r;
          return [x + r * Math.cos(angle), z + r * Math.sin(angle), angle];
        },
      };
      const start = [x + r * b[0], z + r * b[1]];
      const line = {
        length: out[j].length,
        at: (s) => [start[0] + s * b[1], start[1] - s * b[0], Math.atan2(b[1], b[0])],
      };
      return [arc, line];
    });
  }

  show(wheels, angle) {
    const centres = this.numbers.map((w) => [wheels[w].position.x, wheels[w].position.z]);
    const y = wheels[this.numbers[0]].position.y;
    const parts = this.way(centres);
    const length = parts.reduce((sum, p) => sum + p.length, 0);
    const count = Math.min(256, Math.round(length / (PAD * this.thickness)));
    const pitch = length / count;
    // Driven forward, the lower run moves to the rear.
    const travel = angle(this.numbers[1]) * this.inner;
    const turn = new THREE.Quaternion();
    const matrix = new THREE.Matrix4();
    const one = new THREE.Vector3(1, 1, 1);
    const axis = new THREE.Vector3(0, 1, 0);
    let [part, before] = [0, 0];
    const phase = ((travel % pitch) + pitch) % pitch;
    for (let i = 0; i < count; i += 1) {
      const s = i * pitch + phase;
      while (part + 1 < parts.length && s > before + parts[part].length) {
        before += parts[part].length;
        part += 1;
      }
      const [x, z, out] = parts[part].at(s - before);
      // The pad's upper face looks out.
      turn.setFromAxisAngle(axis, Math.PI / 2 - out);
      this.mesh.setMatrixAt(i, matrix.compose(new THREE.Vector3(x, y, z), turn, one));
    }
    this.mesh.count = count;
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}
