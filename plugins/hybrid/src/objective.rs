//! Cost of a rollout.

use vb_sdk::mppi::{Cost, Field, LANES, Lanes};

use crate::kinodynamics::State;
use crate::traversability::Values;

/// Cost of a contact, as a multiple of the maximum cost of proximity.
const TOUCH: f32 = 10.0;

/// Weights of the cost terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Squared distance from the local goal, in look-ahead distances: mean over the steps, plus the same term for the
    /// final state.
    pub goal: f32,
    /// Obstacles and edges.
    pub obstacle: f32,
    /// Squared deviation from the target speed, as a fraction of it.
    pub pace: f32,
    /// Squared steering.
    pub effort: f32,
    /// Roll and pitch above their comfort limits.
    pub tilt: f32,
    /// Probability of getting stuck.
    pub stuck: f32,
    /// Probability of tipping over.
    pub over: f32,
    /// Factor of probabilities before they are clamped to 1: 1 / (1 − α), which turns the expected cost into the
    /// conditional value at risk at level α.
    pub caution: f32,
}

/// The cost of a rollout, as means over its steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    /// The local goal, m.
    pub goal: [f32; 2],
    /// 1 / look-ahead distance, 1/m.
    pub per_lookahead: f32,
    /// The target speed, m/s.
    pub target: f32,
    /// Steps per rollout.
    pub steps: f32,
    pub weights: Weights,
    /// Distance of an axle from the reference point, m.
    pub axle: f32,
    /// Radius of the circles around the axles that cover the vehicle's width, m.
    pub radius: f32,
    /// Distance outside the circles within which obstacles have a cost, m.
    pub margin: f32,
    /// Roll and pitch up to which they have no cost, rad; twice the limit costs one weight.
    pub comfort: [f32; 2],
    /// Distance to obstacles and edges, m.
    pub clearance: Field,
    /// The cost-to-go, which replaces the distance from the local goal.
    pub values: Option<Values>,
}

impl Objective {
    /// Squared distance from the local goal, or cost-to-go, in look-ahead distances, at positions (m) and headings.
    #[must_use]
    pub fn away(&self, [x, y]: [&Lanes; 2], direction: [&Lanes; 2]) -> Lanes {
        if let Some(values) = &self.values {
            let way = values.at([x, y], direction);
            return way.map(|v| v * self.per_lookahead);
        }
        std::array::from_fn(|l| {
            let (dx, dy) = (x[l] - self.goal[0], y[l] - self.goal[1]);
            (dx * dx + dy * dy) * self.per_lookahead * self.per_lookahead
        })
    }

    /// Proximity cost of a circle `axle` (m) ahead of these positions and headings.
    #[must_use]
    pub fn near(&self, [x, y]: [&Lanes; 2], [cos, sin]: [&Lanes; 2], axle: f32) -> Lanes {
        let x: Lanes = std::array::from_fn(|l| x[l] + axle * cos[l]);
        let y: Lanes = std::array::from_fn(|l| y[l] + axle * sin[l]);
        let clearance = self.clearance.at(&x, &y);
        std::array::from_fn(|l| {
            let gap = clearance[l] - self.radius;
            let near = (1.0 - gap / self.margin).clamp(0.0, 1.0);
            near * near + if gap < 0.0 { TOUCH } else { 0.0 }
        })
    }
}

/// The squared excess over a limit, in units of the limit.
#[must_use]
pub fn beyond(value: f32, limit: f32) -> f32 {
    let over = (value.abs() / limit - 1.0).max(0.0);
    over * over
}

/// The conditional value at risk of a loss of 1 with this probability: its mean over the worst fraction 1 − α of
/// outcomes, which is min(1, p / (1 − α)) (Rockafellar and Uryasev, "Optimization of conditional value-at-risk", 2000,
/// for two outcomes). `caution` is 1 / (1 − α); with α = 0 it is the expectation, p.
fn conditional_value_at_risk(probability: f32, caution: f32) -> f32 {
    (probability * caution).min(1.0)
}

impl Cost<State, 2> for Objective {
    fn running(&self, s: &State, [steering, _]: &[Lanes; 2], _: usize) -> Lanes {
        let w = self.weights;
        let (place, direction) = ([&s.x, &s.y], [&s.cos, &s.sin]);
        let away = self.away(place, direction);
        let (front, rear) = (self.near(place, direction, self.axle), self.near(place, direction, -self.axle));
        std::array::from_fn(|l| {
            let pace = s.speed[l] / self.target - 1.0;
            let tilt = beyond(s.roll[l], self.comfort[0]) + beyond(s.pitch[l], self.comfort[1]);
            let cost = w.goal * away[l]
                + w.obstacle * (front[l] + rear[l])
                + w.pace * pace * pace
                + w.effort * steering[l] * steering[l]
                + w.tilt * tilt
                + w.stuck * conditional_value_at_risk(s.stuck[l], w.caution)
                + w.over * conditional_value_at_risk(s.over[l], w.caution);
            cost / self.steps
        })
    }

    fn terminal(&self, s: &State) -> Lanes {
        let away = self.away([&s.x, &s.y], [&s.cos, &s.sin]);
        std::array::from_fn::<f32, LANES, _>(|l| self.weights.goal * away[l])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the definition: the mean of the largest losses that make up the fraction 1 − α of a hundred
    /// thousand outcomes.
    #[test]
    fn the_conditional_value_at_risk_is_the_mean_of_the_worst_outcomes() {
        const OUTCOMES: usize = 100_000;
        for probability in [0.0_f32, 0.01, 0.07, 0.1, 0.5, 1.0] {
            for level in [0.0_f32, 0.5, 0.9] {
                let come = (f64::from(probability) * OUTCOMES as f64).round() as usize;
                let worst = ((1.0 - f64::from(level)) * OUTCOMES as f64).round() as usize;
                let mean = come.min(worst) as f64 / worst as f64;
                let own = f64::from(conditional_value_at_risk(probability, 1.0 / (1.0 - level)));
                assert!((own - mean).abs() < 1e-4, "{probability}, {level}: {own} for {mean}");
            }
        }
    }
}
