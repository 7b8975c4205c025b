// Granular beds: pits, and the grains of a run in them.
import * as THREE from 'three';

const PIT = 0.45; // brightness of a pit's floor and walls over that of its grains
const SPREAD = 0.35; // how much the brightness of grains differs from one to the next

const colour = (rgb) => new THREE.Color().setRGB(...rgb.map((v) => v / 255), THREE.SRGBColorSpace);

// The cells of the ground that lie within a bed: what is seen there are grains.
export function pitCells(beds, { rows, cols, resolution, half }) {
  const open = new Uint8Array((rows - 1) * (cols - 1));
  for (const { corners: [[west, south], [east, north]] } of beds) {
    for (let r = 0; r + 1 < rows; r += 1) {
      for (let c = 0; c + 1 < cols; c += 1) {
        const [x, y] = [(c + 0.5) * resolution[0] - half[0], (r + 0.5) * resolution[1] - half[1]];
        if (x > west && x < east && y > south && y < north) open[r * (cols - 1) + c] = 1;
      }
    }
  }
  return open;
}

export class Grains {
  constructor(run, beds) {
    Object.assign(this, { told: run.grains, next: 0 });
    this.group = new THREE.Group();
    for (const { corners: [[west, south], [east, north]], heights: [floor, top], colour: rgb } of beds) {
      // Seen from within.
      const material = new THREE.MeshLambertMaterial({ color: colour(rgb).multiplyScalar(PIT), side: THREE.BackSide });
      const pit = new THREE.Mesh(new THREE.BoxGeometry(east - west, north - south, top - floor), material);
      pit.position.set((west + east) / 2, (south + north) / 2, (floor + top) / 2);
      this.group.add(pit);
    }
    const { radii, start } = this.told;
    this.mesh = new THREE.InstancedMesh(new THREE.IcosahedronGeometry(1, 0), new THREE.MeshLambertMaterial({ flatShading: true }), radii.length);
    this.mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    const own = new THREE.Color();
    for (let k = 0; k < radii.length; k += 1) {
      const [x, y] = [start[3 * k], start[3 * k + 1]];
      const bed = beds.find(({ corners: [a, b] }) => x >= a[0] && x <= b[0] && y >= a[1] && y <= b[1]) ?? beds[0];
      const shade = 1 - SPREAD * ((Math.imul(k, 2654435761) >>> 24) / 255);
      this.mesh.setColorAt(k, own.copy(colour(bed.colour)).multiplyScalar(shade));
    }
    this.reset();
    this.group.add(this.mesh);
  }

  put(k, x, y, z) {
    const r = this.told.radii[k];
    // A fixed turn for each, so that faces of equal bodies don't flash alike.
    this.matrix ??= new THREE.Matrix4();
    this.turn ??= new THREE.Quaternion();
    this.turn.setFromAxisAngle(new THREE.Vector3(Math.sin(k), Math.cos(k), Math.sin(3 * k)).normalize(), k);
    this.matrix.compose(new THREE.Vector3(x, y, z), this.turn, new THREE.Vector3(r, r, r));
    this.mesh.setMatrixAt(k, this.matrix);
  }

  reset() {
    const { radii, start } = this.told;
    for (let k = 0; k < radii.length; k += 1) this.put(k, start[3 * k], start[3 * k + 1], start[3 * k + 2]);
    this.next = 0;
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  // The grains as they lay at a time.
  show(time) {
    const { times, moves } = this.told;
    if (this.next > 0 && times[this.next - 1] > time) this.reset();
    const from = this.next;
    while (this.next < times.length && times[this.next] <= time) {
      const k = 4 * this.next;
      this.put(moves[k], moves[k + 1], moves[k + 2], moves[k + 3]);
      this.next += 1;
    }
    if (this.next !== from) this.mesh.instanceMatrix.needsUpdate = true;
  }
}
