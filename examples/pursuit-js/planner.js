// Pure pursuit: drive the circle that goes through a point ahead on the path.
//
// The same formulas in the same order as in the Rust SDK (`path`, `speed`, `math::turn`), so that commands are
// identical in both languages.

const clamp = (value, low, high) => (value < low ? low : value > high ? high : value);

/** The turn from direction `start` to direction `end`, rad in [-π, π), positive to the left. */
function turn(start, end) {
  const tau = 2 * Math.PI;
  let a = (end - start + Math.PI) % tau;
  if (a < 0) a += tau;
  // A tiny negative remainder plus 2π may round to 2π, the excluded end of the interval.
  return a >= tau ? -Math.PI : a - Math.PI;
}

/** x² as a rounded value and the rounding error (Dekker 1971). */
function square(x) {
  const c = x * 134217729; // 2^27 + 1
  const high = x - c + c;
  const low = x - high;
  const value = x * x;
  return [value, high * high - value + 2 * high * low + low * low];
}

/** Length of (x, y), of ordinary size. The rounding of `Math.hypot` is unspecified in JavaScript; this is that of the C library. */
function hypot(x, y) {
  x = Math.abs(x);
  y = Math.abs(y);
  if (x < y) [x, y] = [y, x];
  if (y === 0) return x;
  const [hx, lx] = square(x);
  const [hy, ly] = square(y);
  return Math.sqrt(ly + lx + hy + hx);
}

/** Throttle and brake, each in [0, 1], proportional to the speed error (m/s). */
function throttleAndBrake(target, speed) {
  const u = clamp(target - speed, -1, 1);
  return u >= 0 ? [u, 0] : [0, -u];
}

/** Index of the first number in ascending `list` for which `past` holds. */
function firstIndex(list, past) {
  let [low, high] = [0, list.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (past(list[middle])) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** A polyline of points {x, y}, measured by arc length (m) from its start. */
class Path {
  constructor(points) {
    this.points = points;
    this.arc = [0];
    for (let i = 1; i < points.length; i++) {
      const [a, b] = [points[i - 1], points[i]];
      this.arc.push(this.arc[i - 1] + hypot(b.x - a.x, b.y - a.y));
    }
  }

  get length() {
    return this.arc[this.arc.length - 1];
  }

  /** The point at an arc length, clamped to the start and the end. */
  pointAt(arc) {
    const i = firstIndex(this.arc, (a) => a >= arc);
    if (i === 0) return this.points[0];
    if (i === this.points.length) return this.points[i - 1];
    const [a, b] = [this.points[i - 1], this.points[i]];
    const t = (arc - this.arc[i - 1]) / (this.arc[i] - this.arc[i - 1]);
    return { x: a.x + (b.x - a.x) * t, y: a.y + (b.y - a.y) * t };
  }

  /** Arc length of the point closest to (x, y) among those from arc length `start` to `end`. */
  closestBetween(x, y, start, end) {
    start = clamp(start, 0, this.length);
    end = clamp(end, start, this.length);
    const distance = (arc) => {
      const point = this.pointAt(arc);
      return hypot(x - point.x, y - point.y);
    };
    let best = start;
    let nearest = distance(start);
    const first = Math.max(firstIndex(this.arc, (a) => a > start), 1);
    for (let i = first; i < this.points.length && this.arc[i - 1] <= end; i++) {
      const length = this.arc[i] - this.arc[i - 1];
      if (length === 0) continue;
      const [a, b] = [this.points[i - 1], this.points[i]];
      const along = ((x - a.x) * (b.x - a.x) + (y - a.y) * (b.y - a.y)) / length;
      const arc = clamp(this.arc[i - 1] + clamp(along, 0, length), start, end);
      const away = distance(arc);
      if (away < nearest) [best, nearest] = [arc, away];
    }
    return best;
  }
}

/** A parameter as a number; the harness gives every parameter that planner.yaml declares. */
function number(task, key) {
  const text = task.params.find((p) => p.key === key)?.value;
  const value = text === undefined || text.trim() === '' ? NaN : Number(text);
  // Exceptions abort the task, with the message as the reason.
  if (!Number.isFinite(value)) throw new Error(`parameter ${key} is ${text}; it must be a number`);
  return value;
}

/** Checks that `step` returned a command. Other values would end the task as a trap without a reason. */
function checked(command) {
  const wrong = (what) => {
    throw new Error(`step returned ${what}; return { steering, throttle, brake, gear, debug }`);
  };
  if (typeof command !== 'object' || command === null) wrong(`${command}`);
  for (const field of ['steering', 'throttle', 'brake']) {
    if (typeof command[field] !== 'number') wrong(`${field} = ${command[field]}, which is no number`);
  }
  const { gear, debug } = command;
  const gears = ['forward', 'neutral', 'reverse'];
  if (!gears.includes(gear)) wrong(`gear = ${gear}, which is none of ${gears.join(', ')}`);
  const isNumber = (value) => typeof value === 'number';
  const areNumbers = (list) => ArrayBuffer.isView(list) || (Array.isArray(list) && list.every(isNumber));
  const isSeries = (series) => typeof series?.name === 'string' && areNumbers(series.values);
  if (!Array.isArray(debug) || !debug.every(isSeries)) wrong('debug that is no array of { name, values }');
  return command;
}

/** One planner for one task. All state lives in this object. */
class Planner {
  static init(task) {
    const planner = new Planner();
    planner.wheelbase = task.vehicle.wheelbase;
    planner.maxSteerAngle = task.vehicle.maxSteerAngle;
    planner.speed = number(task, 'speed');
    planner.ahead = number(task, 'ahead') * task.vehicle.scale;
    if (task.path.length === 0) throw new Error('the global path has no points');
    planner.path = new Path(task.path);
    planner.arc = 0; // progress along the path, m
    return planner;
  }

  step(o) {
    if (!o.pose) throw new Error('there is no pose');
    const { yaw, linearVelocity } = o.pose;
    const { x, y } = o.pose.position;
    // Rejects implausible numbers. Comparisons with NaN are false, so NaN is rejected, too.
    const seen = [x, y, yaw, linearVelocity.x];
    if (!seen.every((value) => Math.abs(value) < 1e9)) {
      throw new Error(`invalid position, heading or speed: ${seen.join(', ')}`);
    }
    // Progress never decreases, and advances by at most a window: it cannot jump to a later section nearby.
    this.arc = this.path.closestBetween(x, y, this.arc, this.arc + 2 * this.ahead);
    const goal = this.path.pointAt(this.arc + this.ahead);
    const [dx, dy] = [goal.x - x, goal.y - y];
    const angle = turn(yaw, Math.atan2(dy, dx));
    const curvature = (2 * Math.sin(angle)) / Math.max(hypot(dx, dy), 0.1);
    const steering = Math.atan(this.wheelbase * curvature) / this.maxSteerAngle;
    const [throttle, brake] = throttleAndBrake(this.speed, linearVelocity.x);
    return { steering: clamp(steering, -1, 1), throttle, brake, gear: 'forward', debug: [] };
  }
}

const { step } = Planner.prototype;
Planner.prototype.step = function (o) {
  return checked(step.call(this, o));
};

export const guest = { Planner };
