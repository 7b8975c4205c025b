//! Commands that descend the cost-to-go step by step, with the motion of the model.

use vb_sdk::mppi::{Cost, LANES, Lanes, Model};

use crate::kinodynamics::{Kinodynamics, State};
use crate::objective::Objective;

/// Commands of steering and speed at knots `spacing` steps of `dt` s apart. For each interval, the minimum-cost
/// steering of [`LANES`] candidates.
#[must_use]
pub fn descend(
    model: &Kinodynamics,
    objective: &Objective,
    start: &State,
    (knots, spacing, dt): (usize, usize, f32),
) -> Vec<[f32; 2]> {
    let command: [Lanes; 2] =
        [std::array::from_fn(|l| 2.0 * l as f32 / (LANES - 1) as f32 - 1.0), [objective.target; LANES]];
    let mut state = start.clone();
    let mut plan = Vec::with_capacity(knots);
    for _ in 0..knots {
        let mut ahead = state.clone();
        let mut costs = [0.0; LANES];
        for index in 0..spacing {
            model.step(&mut ahead, &command, dt);
            let running = objective.running(&ahead, &command, index);
            costs.iter_mut().zip(running).for_each(|(cost, own)| *cost += own);
        }
        costs.iter_mut().zip(objective.terminal(&ahead)).for_each(|(cost, own)| *cost += own);
        let best = (0..LANES).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
        plan.push([command[0][best], command[1][best]]);
        state = ahead.all_as(best);
    }
    plan
}
