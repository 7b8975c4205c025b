// Numbers as `packed` of the harness writes them (src/packed.rs): rows of columns, each value less what was to be expected.
import { inflateSync } from 'three/examples/jsm/libs/fflate.module.js';

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

// The rows one behind the other, `stride` numbers from one to the next, from `from` on in `into`.
export function unpack([rows, order, units, text], into, from = 0, stride = units.length) {
  const values = into ?? new Float32Array(rows * units.length);
  const all = inflateSync(bytes(text));
  let at = 0;
  units.forEach((unit, column) => {
    let [last, before] = [0, 0];
    for (let row = 0; row < rows; row += 1) {
      let [code, weight, byte] = [0, 1, 0];
      do {
        byte = all[at];
        at += 1;
        code += (byte & 127) * weight;
        weight *= 128;
      } while (byte > 127);
      const difference = code % 2 ? -(code + 1) / 2 : code / 2;
      const value = difference + [0, last, 2 * last - before][order];
      values[from + row * stride + column] = value * unit;
      [before, last] = [last, value];
    }
  });
  return values;
}

// Convex bodies as lists of points and of triangles' corners, each in a row: `counts` says how many points and triangles each has.
export function unpackMeshes({ counts, points, triangles }) {
  const [numbers, all, corners] = [counts, points, triangles].map((told) => unpack(told));
  let [point, corner] = [0, 0];
  return Array.from({ length: counts[0] }, (_, k) => [
    all.subarray(point, point += 3 * numbers[2 * k]),
    corners.subarray(corner, corner += 3 * numbers[2 * k + 1]),
  ]);
}

// Several series of as many rows, interleaved row by row.
export function unpackEach(series) {
  const [first] = series;
  if (!first) return new Float32Array(0);
  const [rows, , units] = first;
  const stride = series.length * units.length;
  const values = new Float32Array(rows * stride);
  series.forEach((one, k) => unpack(one, values, k * units.length, stride));
  return values;
}
