//! Which way our vehicle is to drive.

use vb_math::hypot;
use vb_world::Task;

/// The two comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Route {
    /// The path that the import plans: planners are compared with the physics.
    Planned,
    /// Where the recorded vehicle drove: the same ground under both, so that the physics is compared alone.
    Driven,
}

impl Route {
    pub(crate) const ALL: [Self; 2] = [Self::Planned, Self::Driven];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Planned => "planned",
            Self::Driven => "driven",
        }
    }

    /// How far ahead the planner aims, m: 10 m as the original, or less, as a driven path was already shortened by
    /// looking ahead.
    pub(crate) fn look_ahead(self) -> f64 {
        match self {
            Self::Planned => 10.0,
            Self::Driven => 5.0,
        }
    }
}

/// Least distance between two waypoints of a driven path, m.
const SPACING: f64 = 0.5;

/// The way that was driven, as a path for a task: from its start on through the recorded places, without those where
/// the vehicle stood, slid back or had left the world of half extents `half` (m); from its end on along the planned
/// path, from the point of it that is nearest, to the goal.
pub(crate) fn driven(task: &Task, places: &[[f64; 2]], half: [f64; 2]) -> Vec<[f64; 2]> {
    let distance = |a: [f64; 2], b: [f64; 2]| hypot(a[0] - b[0], a[1] - b[1]);
    let mut path = vec![[task.start.x, task.start.y]];
    for &p in places {
        let inside = p[0].abs() <= half[0] && p[1].abs() <= half[1];
        if inside && path.iter().all(|&q| distance(p, q) >= SPACING) {
            path.push(p);
        }
    }
    let last = path[path.len() - 1];
    let mut nearest = 0;
    for (k, &p) in task.path.iter().enumerate() {
        if distance(p, last) < distance(task.path[nearest], last) {
            nearest = k;
        }
    }
    // One further, so that the way on does not begin backwards; the goal stays.
    path.extend(&task.path[(nearest + 1).min(task.path.len() - 1)..]);
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_world::Pose2;

    fn task() -> Task {
        let path = (0..=10).map(|k| [f64::from(k), 0.0]).collect();
        Task { id: "t00".into(), start: Pose2 { x: 0.0, y: 0.0, yaw: 0.0 }, goal: [10.0, 0.0], path }
    }

    #[test]
    fn a_driven_path_leads_through_the_places_and_on_along_the_plan() {
        // Off the plan by 1 m, with a halt, a slide back, and a last place outside.
        let places =
            [[0.0, 0.0], [0.1, 0.0], [1.0, 1.0], [2.0, 1.0], [2.1, 1.0], [1.6, 1.0], [3.2, 1.0], [70.0, 0.0]];
        let path = driven(&task(), &places, [64.0, 64.0]);
        let expected: Vec<[f64; 2]> = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.2, 1.0]]
            .into_iter()
            .chain((4..=10).map(|k| [f64::from(k), 0.0]))
            .collect();
        assert_eq!(path, expected);
    }

    #[test]
    fn a_path_driven_to_the_end_still_ends_at_the_goal() {
        let path = driven(&task(), &[[5.0, 0.5], [9.9, 0.2]], [64.0, 64.0]);
        assert_eq!(path, [[0.0, 0.0], [5.0, 0.5], [9.9, 0.2], [10.0, 0.0]]);
    }
}
