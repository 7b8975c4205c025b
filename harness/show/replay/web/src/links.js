// The bars of the suspension between chassis and wheels: rods, arms, beams, springs. They follow the wheels.
import * as THREE from 'three';

const UP = new THREE.Vector3(0, 1, 0);
const vector = (p) => new THREE.Vector3(...p);
const LOOKS = { rod: [0.024, 0xc3c9cc], spoke: [0.034, 0x8d9499], tie: [0.018, 0x8fb7ff], strut: [0.045, 0xe0a63a] };

export class Links {
  constructor(vehicle, unit) {
    this.unit = unit;
    this.carriers = (vehicle.carriers ?? []).map((c) => ({
      wheels: c.wheels,
      centre: vector(c.centre),
      rods: c.rods.map(([a, b]) => ({ from: vector(a), to: vector(b), squared: vector(a).distanceToSquared(vector(b)) })),
      tie: c.tie && c.tie.map(vector),
      pin: c.pin && vector(c.pin),
      kingpins: c.kingpins.map((bar) => bar.map(vector)),
      spokes: c.spokes.map((bar) => bar.map(vector)),
      struts: c.struts.map((bar) => bar.map(vector)),
      armStruts: c.arm_struts.map((bar) => bar.map(vector)),
      arm: c.arm && c.arm.map(vector),
    }));
    const count = this.carriers.reduce((n, c) => n + c.rods.length + c.spokes.length + c.struts.length + c.armStruts.length + (c.tie ? 1 : 0), 0);
    const material = new THREE.MeshLambertMaterial();
    this.mesh = new THREE.InstancedMesh(new THREE.CylinderGeometry(1, 1, 1, 10), material, Math.max(1, count));
    this.mesh.count = count;
    this.mesh.frustumCulled = false;
    this.bars = [];
  }

  // How the carrier has turned from the design position: the direction of its axle is known, and what it has turned about it
  // follows from the pin, or from the rods' lengths by Gauss and Newton's method.
  turn(c, centre, axis) {
    const least = new THREE.Quaternion().setFromUnitVectors(UP, axis);
    const arm = (p) => p.clone().sub(c.centre).applyQuaternion(least);
    let angle = 0;
    if (c.pin) {
      const across = (p) => p.addScaledVector(axis, -axis.dot(p));
      const [from, to] = [across(arm(c.pin)), across(c.pin.clone().sub(centre))];
      angle = Math.atan2(axis.dot(from.clone().cross(to)), from.dot(to));
    }
    for (let step = 0; step < 6 && c.rods.length; step += 1) {
      let [slope, error] = [0, 0];
      for (const rod of c.rods) {
        const p = arm(rod.to).applyAxisAngle(axis, angle);
        const along = p.clone().add(centre).sub(rod.from);
        const rate = 2 * along.dot(axis.clone().cross(p));
        slope += rate * rate;
        error += rate * (along.lengthSq() - rod.squared);
      }
      if (slope < 1e-12) break;
      angle -= error / slope;
    }
    return new THREE.Quaternion().setFromAxisAngle(axis, angle).multiply(least);
  }

  // Where the wheels of a beam with knuckles would be if they went straight ahead: the steering turns them about kingpins, and
  // their centres do not lie in these.
  straight(c, hubs, axes) {
    let ends = hubs;
    for (let step = 0; step < 3; step += 1) {
      const beam = ends[0].clone().sub(ends[1]).normalize();
      const turn = this.turn(c, ends[0].clone().lerp(ends[1], 0.5), beam);
      ends = c.kingpins.map(([low, top], i) => {
        const about = top.clone().sub(low).normalize().applyQuaternion(turn);
        const across = (v) => v.clone().addScaledVector(about, -about.dot(v));
        const [from, to] = [across(UP.clone().applyQuaternion(turn)), across(axes[c.wheels[i]])];
        const angle = Math.atan2(about.dot(from.clone().cross(to)), from.dot(to));
        const lever = c.spokes[0][i].clone().sub(low).applyQuaternion(turn);
        return hubs[i].clone().add(lever).sub(lever.clone().applyAxisAngle(about, angle));
      });
    }
    return ends;
  }

  // `wheels` are the meshes of the wheels; `axes` the directions of their axles.
  show(wheels, axes) {
    this.bars = [];
    for (const c of this.carriers) {
      const [first, last] = [c.wheels[0], c.wheels.at(-1)];
      let ends = [wheels[first].position, wheels[last].position];
      if (c.kingpins.length) ends = this.straight(c, ends, axes);
      const centre = ends[0].clone().lerp(ends[1], 0.5);
      const axis = first === last ? axes[first] : ends[0].clone().sub(ends[1]).normalize();
      const turn = this.turn(c, centre, axis);
      const moved = (p) => p.clone().sub(c.centre).applyQuaternion(turn).add(centre);
      for (const rod of c.rods) this.bars.push(['rod', rod.from, moved(rod.to), Math.sqrt(rod.squared)]);
      for (const [a, b] of c.spokes) this.bars.push(['spoke', moved(a), moved(b)]);
      for (const [a, b] of c.struts) this.bars.push(['strut', a, moved(b)]);
      if (c.tie) {
        // The steering moves the inner end sideways, until the rod has its length.
        const outer = moved(c.tie[1]);
        const inner = c.tie[0].clone();
        const rest = c.tie[0].distanceToSquared(c.tie[1]) - (outer.x - inner.x) ** 2 - (outer.z - inner.z) ** 2;
        if (rest > 0) inner.y = outer.y - Math.sign(c.tie[1].y - c.tie[0].y) * Math.sqrt(rest);
        this.bars.push(['tie', inner, outer]);
      }
      if (c.arm) {
        const [a, b, tip] = c.arm;
        const hinge = b.clone().sub(a).normalize();
        const across = (p) => { const d = p.clone().sub(a); return d.addScaledVector(hinge, -hinge.dot(d)); };
        const [from, to] = [across(tip), across(moved(tip))];
        const angle = Math.atan2(hinge.dot(from.clone().cross(to)), from.dot(to));
        for (const [top, end] of c.armStruts) {
          this.bars.push(['strut', top, end.clone().sub(a).applyAxisAngle(hinge, angle).add(a)]);
        }
      }
    }
    const matrix = new THREE.Matrix4();
    this.bars.forEach(([role, a, b], k) => {
      const along = b.clone().sub(a);
      const length = along.length();
      const radius = LOOKS[role][0] * this.unit;
      const turn = new THREE.Quaternion().setFromUnitVectors(UP, along.divideScalar(length || 1));
      this.mesh.setMatrixAt(k, matrix.compose(a.clone().lerp(b, 0.5), turn, new THREE.Vector3(radius, length, radius)));
      this.mesh.setColorAt(k, new THREE.Color(LOOKS[role][1]));
    });
    this.mesh.instanceMatrix.needsUpdate = true;
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }
}
