//! Wheel sinkage, and its estimation.

use wide::f32x8;

use super::vector::{V3, all};
use super::{State, Twin, WHEELS, Wheel};

/// Time constants of increasing and decreasing sinkage, s at full scale, fitted on training worlds.
const SINKING: [f32; 2] = [0.1, 0.2];
/// Range of wheel loads, relative to the static load, at which sinkage is estimated.
const TELLING: [f32; 2] = [0.4, 2.0];
/// Gains of the estimate: while the vehicle stands at the start, and later.
const BELIEF: [f32; 2] = [0.3, 0.05];
/// Duration of standing at the start, s at full scale.
const START: f64 = 0.5;
/// Maximum ratio of observed to expected sinkage, and maximum load ratio.
const MOST: f32 = 4.0;

/// Sinkage ratio at a load ratio: in Bekker's law with the exponent 1.1, the load increases with the sinkage to the
/// power 1.6.
fn deeper(part: f32x8) -> f32x8 {
    let root = part.sqrt();
    root * root.sqrt().sqrt()
}

/// Sinkage of a wheel under a load ratio after a time step.
pub(super) fn sinks(w: &Wheel, part: f32x8, time: f32) -> f32x8 {
    if !w.depth.simd_gt(all(0.0)).any() {
        return all(0.0);
    }
    let depth = w.depth * deeper(part.min(all(MOST)));
    let [sinks, rises] = SINKING.map(|of| all((time / of).min(1.0)));
    w.sunk + (depth - w.sunk) * depth.simd_gt(w.sunk).select(sinks, rises)
}

impl Twin {
    /// Sinkage of a wheel (m) from its position, and its load ratio from its spring.
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

    /// Updates the depth estimates from the observed state at a time (s).
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
