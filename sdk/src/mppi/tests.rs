//! Compares the implementation with closed forms.

use super::*;
use crate::{GridFrame, Map, Task};

/// A point on a line whose command is its velocity.
struct Point;

impl Model<1> for Point {
    type State = Lanes;

    fn step(&self, x: &mut Lanes, command: &[Lanes; 1], dt: f32) {
        for l in 0..LANES {
            x[l] += dt * command[0][l];
        }
    }
}

/// Squares of the distance from a target at the end and of the commands on the way.
struct Quadratic {
    target: f32,
    effort: f32,
}

impl Cost<Lanes, 1> for Quadratic {
    fn running(&self, _: &Lanes, command: &[Lanes; 1], _: usize) -> Lanes {
        command[0].map(|u| self.effort * u * u)
    }

    fn terminal(&self, x: &Lanes) -> Lanes {
        x.map(|x| (x - self.target) * (x - self.target))
    }
}

fn settings() -> Settings<1> {
    Settings {
        samples: 1000,
        horizon: 20,
        dt: 0.1,
        spacing: 5,
        spread: [0.5],
        low: [-5.0],
        high: [5.0],
        effective: 0.1,
    }
}

#[test]
fn a_good_proposal_is_taken_and_a_bad_one_is_not() {
    // Samples are so close to the plan that the target, 1 m/s for 2 s away, is out of their range.
    let near = Settings { spread: [0.01], ..settings() };
    let cost = Quadratic { target: 2.0, effort: 0.01 };
    let after = |proposal: f32| {
        let mut mppi = Mppi::new(near.clone(), [0.0], 1);
        mppi.propose(&vec![[proposal]; mppi.knots()], 0.3);
        mppi.improve(&Point, &cost, &[0.0; LANES]);
        mppi.command(0.0)[0]
    };
    assert!((after(1.0) - 1.0).abs() < 0.02, "{}", after(1.0));
    assert!(after(-3.0).abs() < 0.02, "{}", after(-3.0));
}

#[test]
fn a_plan_is_unfolded_by_its_own_commands() {
    let mut mppi = Mppi::new(settings(), [1.5], 1);
    let mut seen = Vec::new();
    mppi.unfold(&Point, &[2.0; LANES], |x| seen.push(x[0]));
    assert_eq!(seen.len(), 21);
    for (k, x) in seen.iter().enumerate() {
        assert!((x - (2.0 + 0.15 * k as f32)).abs() < 1e-5, "{k}: {x}");
    }
    // A varying plan: commands are linear between knots.
    mppi.improve(&Point, &Quadratic { target: 0.0, effort: 0.0 }, &[2.0; LANES]);
    let way: f64 = (0..20).map(|k| 0.1 * mppi.command(0.1 * f64::from(k))[0]).sum();
    let mut end = 0.0;
    mppi.unfold(&Point, &[2.0; LANES], |x| end = f64::from(x[0]));
    assert!((end - 2.0 - way).abs() < 1e-4, "{end} {way}");
}

#[test]
fn a_quadratic_problem_is_solved() {
    // The minimum of Σ e u² + (Δt Σ u − t)² over n equal steps has all u = t Δt / (e + n Δt²).
    let (n, dt, e, t) = (20.0, 0.1, 0.01, 3.0);
    let expected = t * dt / (e + n * dt * dt);
    let mut mppi = Mppi::new(settings(), [0.0], 1);
    let cost = Quadratic { target: t as f32, effort: e as f32 };
    for _ in 0..200 {
        mppi.improve(&Point, &cost, &[0.0; LANES]);
    }
    // The mean over the horizon is well determined; single knots vary with the sampling noise.
    let mean = (0..20).map(|k| mppi.command(0.1 * f64::from(k))[0]).sum::<f64>() / 20.0;
    assert!((mean / expected - 1.0).abs() < 0.03, "{mean} {expected}");
    assert!((0..20).all(|k| (mppi.command(0.1 * f64::from(k))[0] / expected - 1.0).abs() < 0.25));
}

#[test]
fn the_effective_number_of_draws_follows_its_share_whatever_the_scale_of_costs() {
    for scale in [1e-6, 1.0, 1e6] {
        let mut mppi = Mppi::new(settings(), [0.0], 2);
        let cost = Quadratic { target: 3.0 * scale, effort: 0.0 };
        let mut tail = Vec::new();
        for i in 0..100 {
            let w = mppi.improve(&Point, &cost, &[0.0; LANES]);
            if i >= 50 {
                tail.push(w.effective);
            }
        }
        let mean = tail.iter().sum::<f64>() / tail.len() as f64;
        assert!((50.0..200.0).contains(&mean), "scale {scale}: {mean} of 1000, 100 are wanted");
        assert!(tail.iter().all(|e| *e > 10.0), "{tail:?}");
    }
}

#[test]
fn commands_keep_their_bounds() {
    let mut mppi = Mppi::new(Settings { high: [0.7], ..settings() }, [0.0], 3);
    let cost = Quadratic { target: 100.0, effort: 0.0 };
    for _ in 0..50 {
        mppi.improve(&Point, &cost, &[0.0; LANES]);
    }
    let u = mppi.command(0.0)[0];
    assert!(u <= 0.700_001 && u > 0.5, "{u}");
}

#[test]
fn the_plan_moves_on_by_any_time_that_has_passed() {
    let mut mppi = Mppi::new(settings(), [0.0], 4);
    for (k, knot) in mppi.plan.iter_mut().enumerate() {
        *knot = [k as f32];
    }
    // Knots are 0.5 s apart: the plan rises by 2 a second, up to 4 after 2 s.
    let before: Vec<f64> = (0..4).map(|k| mppi.command(0.13 + 0.5 * f64::from(k))[0]).collect();
    mppi.advance(0.13);
    let after: Vec<f64> = (0..4).map(|k| mppi.command(0.5 * f64::from(k))[0]).collect();
    for (a, b) in before.iter().zip(&after) {
        assert!((a - b).abs() < 1e-6, "{before:?} {after:?}");
    }
    assert_eq!(mppi.command(9.0), [4.0], "the end stays");
}

#[test]
fn the_same_seed_gives_the_same_plan() {
    let plan = |seed| {
        let mut mppi = Mppi::new(settings(), [0.0], seed);
        mppi.improve(&Point, &Quadratic { target: 1.0, effort: 0.1 }, &[0.0; LANES]);
        mppi.plan
    };
    assert_eq!(plan(5), plan(5));
    assert_ne!(plan(5), plan(6));
}

#[test]
fn a_cost_that_is_no_number_has_no_say() {
    struct Cliff;
    impl Cost<Lanes, 1> for Cliff {
        fn running(&self, _: &Lanes, _: &[Lanes; 1], _: usize) -> Lanes {
            [0.0; LANES]
        }
        fn terminal(&self, x: &Lanes) -> Lanes {
            x.map(|x| if x < 0.0 { f32::NAN } else { x })
        }
    }
    let mut mppi = Mppi::new(settings(), [0.0], 7);
    mppi.improve(&Point, &Cliff, &[0.0; LANES]);
    assert!(mppi.command(0.0)[0].is_finite());
    let all = Mppi::new(settings(), [0.0], 7).improve(&Point, &Cliff, &[-100.0; LANES]);
    assert_eq!(all.effective, 0.0);
}

#[test]
fn drawn_noise_has_mean_nought_and_deviation_one() {
    let mut rng = Rng::new(8);
    let values: Vec<f64> = (0..100_000).map(|_| f64::from(normal(&mut rng))).collect();
    let mean = values.iter().sum::<f64>() / 1e5;
    let variance = values.iter().map(|v| v * v).sum::<f64>() / 1e5;
    // Standard errors: 0.003 of the mean, about 0.004 of the variance.
    assert!(mean.abs() < 0.015 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
}

#[test]
fn a_bicycle_at_full_lock_drives_its_circle() {
    let model =
        Bicycle { curvature: 0.125, turn_rate_in_place: 0.0, steer_rate: 100.0, lag: 0.5, acceleration: 3.0 };
    let all = |v: f32| [v; LANES];
    let mut s = BicycleState {
        x: all(0.0),
        y: all(0.0),
        cos: all(1.0),
        sin: all(0.0),
        speed: all(4.0),
        steering: all(1.0),
    };
    // A quarter of a circle of 8 m: π/2 · 8 m at 4 m/s.
    let steps = 100;
    let dt = std::f32::consts::PI / steps as f32;
    for _ in 0..steps {
        model.step(&mut s, &[all(1.0), all(4.0)], dt);
    }
    for l in 0..LANES {
        assert!((s.x[l] - 8.0).abs() < 0.01 && (s.y[l] - 8.0).abs() < 0.01, "{s:?}");
        assert!(s.cos[l].abs() < 1e-3 && (s.sin[l] - 1.0).abs() < 1e-3);
    }
}

#[test]
fn steering_and_speed_follow_at_their_rates() {
    let model =
        Bicycle { curvature: 0.1, turn_rate_in_place: 0.0, steer_rate: 2.0, lag: 0.5, acceleration: 3.0 };
    let all = |v: f32| [v; LANES];
    let mut s = BicycleState {
        x: all(0.0),
        y: all(0.0),
        cos: all(1.0),
        sin: all(0.0),
        speed: all(0.0),
        steering: all(0.0),
    };
    model.step(&mut s, &[all(-1.0), all(10.0)], 0.1);
    assert_eq!((s.steering[0], s.speed[0]), (-0.2, 0.3), "2/s and 3 m/s²");
    model.step(&mut s, &[all(-0.2), all(0.4)], 0.1);
    assert!(
        (s.steering[0] + 0.2).abs() < 1e-6 && (s.speed[0] - 0.32).abs() < 1e-6,
        "a fifth of what is missing"
    );
}

#[test]
fn clearance_is_the_distance_to_obstacles_and_to_the_edge() {
    let frame = GridFrame { rows: 20, cols: 20, resolution: 0.5, origin_x: -4.75, origin_y: -4.75 };
    let mut data = vec![0; 400];
    // The square about (0.25, 0.25).
    data[10 * 20 + 10] = 1;
    let ground = GridFrame { rows: 11, cols: 11, resolution: 1.0, origin_x: -5.0, origin_y: -5.0 };
    let task = Task {
        occupancy: Some(Map { frame, data }),
        elevation: Some(Map { frame: ground, data: vec![0.0; 121] }),
        ..Task::default()
    };
    let field = Field::clearance(&task, 3.0).unwrap();
    let at = |x: f32, y: f32| field.at(&[x; LANES], &[y; LANES])[0];
    assert_eq!(at(0.25, 0.25), 0.0);
    assert!((at(2.25, 0.25) - 1.75).abs() < 1e-6, "2 m less half a square");
    assert!((at(0.25, -1.25) - 1.25).abs() < 1e-6);
    assert!((at(-4.75, -3.75) - 0.25).abs() < 1e-6, "0.25 m from the western edge");
    assert!((at(-2.75, -2.75) - 2.25).abs() < 1e-6);
}
