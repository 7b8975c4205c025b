//! Cost of a rollout.

use vb_sdk::mppi::{BicycleState, Cost, Field, LANES, Lanes};

/// Cost of a contact, as a multiple of the maximum cost of proximity.
const TOUCH: f32 = 10.0;

/// Weights of the cost terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weights {
    pub(crate) goal: f32,
    pub(crate) obstacle: f32,
    pub(crate) pace: f32,
    pub(crate) effort: f32,
}

/// Cost of a rollout; the crate's description has the formula.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Objective {
    /// The local goal, m.
    pub(crate) goal: [f32; 2],
    /// 1 / look-ahead, 1/m.
    pub(crate) per_lookahead: f32,
    /// Target speed, m/s.
    pub(crate) target: f32,
    /// Steps per rollout.
    pub(crate) steps: f32,
    pub(crate) weights: Weights,
    /// Distance of an axle from the reference point, m.
    pub(crate) axle: f32,
    /// Radius of the circles about the axles, m.
    pub(crate) radius: f32,
    /// Distance outside the circles within which obstacles have a cost, m.
    pub(crate) margin: f32,
    /// Distance to obstacles and edges, m.
    pub(crate) clearance: Field,
}

impl Objective {
    /// Squared distance from the local goal, in look-ahead distances.
    fn away(&self, s: &BicycleState) -> Lanes {
        std::array::from_fn(|l| {
            let (dx, dy) = (s.x[l] - self.goal[0], s.y[l] - self.goal[1]);
            (dx * dx + dy * dy) * self.per_lookahead * self.per_lookahead
        })
    }

    /// Proximity cost of a circle `axle` ahead of the reference point.
    fn near(&self, s: &BicycleState, axle: f32) -> Lanes {
        let x: Lanes = std::array::from_fn(|l| s.x[l] + axle * s.cos[l]);
        let y: Lanes = std::array::from_fn(|l| s.y[l] + axle * s.sin[l]);
        let clearance = self.clearance.at(&x, &y);
        std::array::from_fn(|l| {
            let gap = clearance[l] - self.radius;
            let near = (1.0 - gap / self.margin).clamp(0.0, 1.0);
            near * near + if gap < 0.0 { TOUCH } else { 0.0 }
        })
    }
}

impl Cost<BicycleState, 2> for Objective {
    fn running(&self, s: &BicycleState, [steering, _]: &[Lanes; 2], _: usize) -> Lanes {
        let w = self.weights;
        let (away, front, rear) = (self.away(s), self.near(s, self.axle), self.near(s, -self.axle));
        std::array::from_fn(|l| {
            let pace = s.speed[l] / self.target - 1.0;
            let cost = w.goal * away[l]
                + w.obstacle * (front[l] + rear[l])
                + w.pace * pace * pace
                + w.effort * steering[l] * steering[l];
            cost / self.steps
        })
    }

    fn terminal(&self, s: &BicycleState) -> Lanes {
        let away = self.away(s);
        std::array::from_fn::<f32, LANES, _>(|l| self.weights.goal * away[l])
    }
}
