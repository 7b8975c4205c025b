//! How deep wheels sink, and how deep they are found to have sunk.

use wide::f32x8;

use super::vector::{V3, all};
use super::{State, Twin, WHEELS, Wheel};

/// The times in which a wheel sinks under more load and rises under less, s at full scale, as they were found on training worlds.
const SINKING: [f32; 2] = [0.1, 0.2];
/// The parts of its share of the weight that a wheel must bear to tell how deep it sinks.
const TELLING: [f32; 2] = [0.4, 2.0];
/// How much of what a wheel tells is believed, while the vehicle stands at the start and later.
const BELIEF: [f32; 2] = [0.3, 0.05];
/// The time for which it stands, s at full scale.
const START: f64 = 0.5;
/// The most by which a wheel is found deeper than it was thought to be.
const MOST: f32 = 4.0;

/// How much deeper a wheel sinks under so many times its share of the weight: by Bekker's law with the exponent 1.1, the load rises with
/// the sinkage to the power of 1.6.
fn deeper(part: f32x8) -> f32x8 {
    let root = part.sqrt();
    root * root.sqrt().sqrt()
}

/// How deep a wheel is that bears so many times its share, a moment later.
pub(super) fn sinks(w: &Wheel, part: f32x8, time: f32) -> f32x8 {
    if !w.depth.simd_gt(all(0.0)).any() {
        return all(0.0);
    }
    let depth = w.depth * deeper(part.min(all(MOST)));
    let [sinks, rises] = SINKING.map(|of| all((time / of).min(1.0)));
    w.sunk + (depth - w.sunk) * depth.simd_gt(w.sunk).select(sinks, rises)
}

impl Twin {
    /// How deep a wheel has sunk, m, by where it is, and how many times its share it bears, by its spring.
    pub(super) fn sinkage(&self, i: usize, w: &Wheel, s: &State) -> (f32x8, f32x8) {
        let shape = &self.shape;
        let axes = s.axes();
        let hub = s.place + axes.out(shape.hub(i, w.travel));
        let depth = self.meet(hub, [axes.forward, axes.up, axes.left], all(0.0)).depth.max(all(0.0));
        let rear = usize::from(i >= 2);
        let load = all(shape.share[rear]) + all(shape.spring[rear]) * (w.travel - all(shape.rest[rear]));
        let load = load.max(all(0.0));
        ((depth - load * all(1.0 / shape.tyre)).max(all(0.0)), load * all(1.0 / shape.share[rear]))
    }

    /// Learns how deep wheels sink into what they stand on, by the state as observed at a time (s).
    pub fn learn(&mut self, s: &State, time: f64) {
        let belief = BELIEF[usize::from(time > START * f64::from(self.shape.root))];
        for i in 0..WHEELS {
            let w = &s.wheels[i];
            let (sunk, part) = self.sinkage(i, w, s);
            let [depth, sunk, part, more] = [w.depth, sunk, part, deeper(part)].map(|v| v.to_array()[0]);
            if depth > 0.0 && part > TELLING[0] && part < TELLING[1] {
                let ratio = (sunk / (depth * more)).min(MOST);
                let V3 { x, y, .. } = s.place + s.axes().out(self.shape.hub(i, w.travel));
                self.ground.deepen(x.to_array()[0], y.to_array()[0], 1.0 + belief * (ratio - 1.0));
            }
        }
    }
}
