//! Debug series of the planner, drawn by `vb-harness replay` (docs/planners.md#what-the-hybrid-planners-consider).

use std::collections::VecDeque;

use vb_sdk::mppi::{LANES, Lanes, Mppi, Weighing};
use vb_sdk::{GridFrame, Series, math};

use crate::kinodynamics::{DT, Kinodynamics, State};
use crate::objective::Objective;
use crate::table::{HEADINGS, heading};

/// Horizon at which predictions are compared with the motion, s at full scale.
const AHEAD: f32 = 1.0;

fn series(name: &str, values: Vec<f32>) -> Series {
    Series { name: name.into(), values }
}

/// The recorded series, and the state that they need.
pub(crate) struct Explanation {
    courses: usize,
    /// Control periods until [`AHEAD`].
    periods: usize,
    /// Predicted positions at [`AHEAD`] of the plans of the last second, m.
    predictions: VecDeque<[f32; 2]>,
    /// The traversability map, recorded once.
    map: Vec<Series>,
}

impl Explanation {
    /// Records `courses` rollouts of a planner with this control period, s at full scale.
    pub(crate) fn new(courses: usize, period: f64) -> Self {
        let periods = (f64::from(AHEAD) / period + 0.5) as usize;
        Self { courses, periods, predictions: VecDeque::new(), map: Vec::new() }
    }

    /// Records the traversability map with the next step: at every second node a stroke in the heading of minimum cost,
    /// with the binary logarithm of the mean cost over all headings.
    pub(crate) fn show(&mut self, frame: GridFrame, model: &Kinodynamics, costs: &[f32]) {
        let area = (frame.rows * frame.cols) as usize;
        let (mut strokes, mut prices) = (Vec::new(), Vec::new());
        let (half, above) = (0.6 * frame.resolution as f32, 0.05 * model.terrain().size().0);
        let every_second = |n: u32| (0..n).step_by(2);
        for (row, col) in every_second(frame.rows).flat_map(|r| every_second(frame.cols).map(move |c| (r, c)))
        {
            let own = |h: usize| costs[h * area + (row * frame.cols + col) as usize];
            let best = (0..HEADINGS).min_by(|a, b| own(*a).total_cmp(&own(*b))).unwrap_or(0);
            let ([cos, sin], (x, y)) = (heading(best), frame.position(row, col));
            for way in [-half, half] {
                let (x, y) = (x as f32 + way * cos, y as f32 + way * sin);
                strokes.extend([x, y, height(model, x, y) + above]);
            }
            strokes.extend([f32::NAN; 3]);
            let mean = (0..HEADINGS).map(own).sum::<f32>() / HEADINGS as f32;
            prices.push(math::ln(f64::from(mean)) as f32 / std::f32::consts::LN_2);
        }
        self.map = vec![series("traversability.xyz", strokes), series("traversability.cost", prices)];
    }

    /// The series of a step.
    pub(crate) fn tell(
        &mut self,
        (mppi, weighing): (&Mppi<2>, Weighing),
        model: &Kinodynamics,
        objective: &Objective,
        (start, command): (&State, [f32; 2]),
    ) -> Vec<Series> {
        let blocks = self.courses.div_ceil(LANES).min(mppi.costs().len() / LANES);
        let mut courses = Vec::new();
        for block in 0..blocks {
            let mut states = Vec::new();
            mppi.replay(block, model, start, |s| states.push((s.x, s.y)));
            for lane in 0..LANES {
                courses.extend(states.iter().flat_map(|(x, y)| [x[lane], y[lane]]));
            }
        }
        let (mut plan, mut stuck, mut over) = (Vec::new(), 0.0_f32, 0.0_f32);
        mppi.unfold(model, start, |s| {
            plan.extend([s.x[0], s.y[0], s.plane[0][0]]);
            (stuck, over) = (stuck.max(s.stuck[0]), over.max(s.over[0]));
        });
        let mut told = vec![
            series("trajectories", courses),
            series("trajectory_costs", mppi.costs()[..blocks * LANES].to_vec()),
            series("local_goal", objective.goal.to_vec()),
            series("effective_samples", vec![weighing.effective as f32]),
            series("stuck_foreseen", vec![stuck]),
            series("over_foreseen", vec![over]),
        ];
        if let Some(off) = self.missed_by(start, &plan) {
            told.push(series("prediction_error", vec![off]));
        }
        told.push(series("plan.xyz", plan));
        if let Some(values) = &objective.values {
            let way = values.at([&start.x, &start.y], [&start.cos, &start.sin]);
            told.push(series("way_left", vec![way[0]]));
        }
        if let Some(weights) = model.attention(start, &command.map(|c| [c; LANES])) {
            let place =
                |[x, y]: [Lanes; 2]| [x[0], y[0], height(model, x[0], y[0]), f32::NAN, f32::NAN, f32::NAN];
            let points = model.places(start).into_iter().flat_map(place).collect();
            let shares = weights.iter().map(|w| w[0]).collect();
            told.extend([series("attention.xyz", points), series("attention.cost", shares)]);
        }
        told.append(&mut self.map);
        told
    }

    /// Distance of the vehicle from the position that the plan of a second ago predicted for now, m.
    fn missed_by(&mut self, start: &State, plan: &[f32]) -> Option<f32> {
        let p = plan.chunks_exact(3).nth((AHEAD / DT) as usize)?;
        self.predictions.push_back([p[0], p[1]]);
        if self.predictions.len() <= self.periods {
            return None;
        }
        let [x, y] = self.predictions.pop_front()?;
        Some(math::hypot(f64::from(x - start.x[0]), f64::from(y - start.y[0])) as f32)
    }
}

/// The height of the terrain, m.
fn height(model: &Kinodynamics, x: f32, y: f32) -> f32 {
    model.terrain().heights(&[x; LANES], &[y; LANES])[0]
}
