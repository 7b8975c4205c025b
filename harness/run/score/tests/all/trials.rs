//! Outcomes and measures of trials whose course is known in closed form.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::f64::consts::{PI, TAU};

use vb_math::angle::radians;
use vb_math::{cos, sin};
use vb_record::Sample;
use vb_score::{Fault, Outcome, Rules, Scorer, TaskGeometry, TaskScore, ThreeWay};

/// Time between samples, s.
const DT: f64 = 0.01;

fn geometry() -> TaskGeometry {
    TaskGeometry { goal: [60.0, 0.0], goal_z: 0.0, half_extent: [64.0, 64.0], scale: 1.0, max_speed: 30.0 }
}

/// Plays a trajectory until the rules decide or `end` (s) has come.
fn play(rules: &Rules, geometry: &TaskGeometry, end: f64, at: impl Fn(f64) -> Sample) -> Option<TaskScore> {
    let mut scorer = Scorer::new(rules, geometry);
    let mut k = 0;
    while f64::from(k) * DT <= end + 1e-9 {
        let time = f64::from(k) * DT;
        if scorer.push(&Sample { time, ..at(time) }).is_some() {
            break;
        }
        k += 1;
    }
    scorer.finish()
}

fn paper(end: f64, at: impl Fn(f64) -> Sample) -> TaskScore {
    play(&Rules::paper(), &geometry(), end, at).unwrap()
}

fn profile(name: &str) -> Rules {
    Rules::resolve(name).unwrap()
}

/// From (-60, 0) along x at a speed.
fn line(speed: f64) -> impl Fn(f64) -> Sample {
    move |t| Sample { x: -60.0 + speed * t, vx: speed, throttle: 0.5, ..Sample::default() }
}

/// Around (0, 0) at radius 20 m and 5 m/s: never near the goal, never slow.
fn circle(t: f64) -> Sample {
    let phase = 5.0 / 20.0 * t;
    Sample { x: 20.0 * cos(phase), y: 20.0 * sin(phase), vx: 5.0, ..Sample::default() }
}

fn close(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance, "{got} is not {want} ± {tolerance}");
}

#[test]
fn a_straight_drive_succeeds_when_it_comes_within_the_radius() {
    // 110 m to the 10 m circle at 5 m/s take 22 s; "within" is strict, so the next sample decides.
    let score = paper(60.0, line(5.0));
    assert_eq!((score.outcome, score.three_way), (Outcome::Success, ThreeWay::Success));
    close(score.time_s, 22.0, DT + 1e-9);
    let m = score.metrics.unwrap();
    close(m.distance_m, 5.0 * score.time_s, 1e-9);
    close(m.speed_mean_m_per_s, 5.0, 1e-9);
    close(m.speed_max_m_per_s, 5.0, 0.0);
    close(m.throttle_effort_s, 0.5 * score.time_s, 1e-9);
    close(m.goal_distance_min_m, 10.0, 5.0 * DT + 1e-9);
    assert_eq!(
        (m.roll_mean_deg, m.pitch_max_deg, m.steering_effort_s, m.brake_effort_s),
        (0.0, 0.0, 0.0, 0.0)
    );
    assert_eq!(m.samples, 2202);
}

#[test]
fn the_marker_of_the_released_rules_is_two_metres_up() {
    // Reference point 0.5 m above the ground: 8² = planar² + 1.5², planar = 7.858 m, at 5 m/s after 22.428 s.
    let at = |t| Sample { z: 0.5, ..line(5.0)(t) };
    let score = play(&profile("release"), &geometry(), 60.0, at).unwrap();
    assert_eq!(score.outcome, Outcome::Success);
    close(score.time_s, (120.0 - (64.0f64 - 2.25).sqrt()) / 5.0, DT);
}

#[test]
fn a_slow_vehicle_has_time_in_proportion_to_its_speed() {
    // 60 s are for 5 m/s; at a quarter 30 s for 2.5 m/s.
    let at = |t: f64| Sample { x: -60.0 + t, ..Sample::default() };
    let limit = |scale: f64, max_speed: f64| {
        let geometry =
            TaskGeometry { goal: [1e6, 0.0], half_extent: [1e6, 1e6], scale, max_speed, ..geometry() };
        play(&Rules::paper(), &geometry, 700.0, at).unwrap().time_s
    };
    for (scale, max_speed, expected) in [
        (1.0, 30.0, 60.0),
        (1.0, 5.0, 60.0),
        (1.0, 2.0, 150.0),
        (0.25, 2.5, 30.0),
        (0.25, 1.0, 75.0),
        (1.0, 0.01, 600.0),
    ] {
        close(limit(scale, max_speed), expected, DT);
    }
}

#[test]
fn lengths_in_rules_scale_with_the_world_and_times_with_the_root_of_its_scale() {
    let scale = 0.1;
    let small =
        TaskGeometry { goal: [6.0, 0.0], goal_z: 0.0, half_extent: [6.4, 6.4], scale, max_speed: 30.0 };
    // 12 m apart, radius 1 m.
    let score = play(&Rules::paper(), &small, 60.0, |t| Sample { x: -6.0 + t, ..Sample::default() }).unwrap();
    assert_eq!(score.outcome, Outcome::Success);
    close(score.time_s, 11.0, DT + 1e-9);
    // Froude: at a tenth 60 s are 60 √0.1 = 18.97 s.
    let score =
        play(&Rules::paper(), &small, 60.0, |t| Sample { x: -6.0 + 0.5 * t, ..Sample::default() }).unwrap();
    assert_eq!(score.outcome, Outcome::Timeout);
    close(score.time_s, 60.0 * 0.1_f64.sqrt(), DT);
    // What has the same path over length and the same time over the root of the length is judged alike: 0.11 m/s and
    // 0.09 m/s of the full-size world, either side of the limit of 1 m in 10 s.
    for (speed, outcome) in [(0.11, Outcome::Timeout), (0.09, Outcome::Stuck)] {
        let slow = speed * 0.1_f64.sqrt();
        let crawl = |t| Sample { x: -6.0 + slow * t, ..Sample::default() };
        assert_eq!(play(&Rules::paper(), &small, 60.0, crawl).unwrap().outcome, outcome);
        let large = |t| Sample { x: -60.0 + speed * t, ..Sample::default() };
        assert_eq!(paper(60.0, large).outcome, outcome);
    }
    // Slower than 2 m/s for 10 s: 0.632 m/s for 3.16 s.
    let released = profile("release");
    let drive = |speed: f64| move |t: f64| Sample { x: -6.0 + speed * t, ..Sample::default() };
    let score = play(&released, &small, 60.0, drive(0.6)).unwrap();
    assert_eq!(score.outcome, Outcome::Stuck);
    close(score.time_s, 10.0 * 0.1_f64.sqrt(), 2.0 * DT);
    assert_ne!(play(&released, &small, 60.0, drive(0.66)).unwrap().outcome, Outcome::Stuck);
}

#[test]
fn standing_still_is_stuck_after_ten_seconds() {
    let score = paper(60.0, |_| Sample { x: -60.0, ..Sample::default() });
    assert_eq!((score.outcome, score.three_way), (Outcome::Stuck, ThreeWay::Stuck));
    close(score.time_s, 10.0, 1e-9);
}

#[test]
fn the_stuck_window_is_the_last_ten_seconds_of_net_motion() {
    // Drives 20 m in 4 s, then spins its wheels to and fro by 0.4 m: net displacement under 1 m once the window
    // holds only that, 10 s after t = 4 s less the time in which the last metre was driven.
    let at = |t: f64| {
        let (x, v) = if t < 4.0 { (5.0 * t, 5.0) } else { (20.0 + 0.4 * sin(TAU * (t - 4.0)), 2.0) };
        Sample { x: -60.0 + x, vx: v, ..Sample::default() }
    };
    let score = paper(60.0, at);
    assert_eq!(score.outcome, Outcome::Stuck);
    // A swing forward of up to 0.4 m brings the window's ends together earlier: not more than 1.4 m = 0.28 s.
    assert!(score.time_s > 13.6 && score.time_s <= 14.0, "{}", score.time_s);
    // Going round in a circle slowly is no net motion either when the circle closes within the window.
    let still_moving = paper(60.0, |t| circle(t * 0.9));
    assert_eq!(still_moving.outcome, Outcome::Timeout);
}

#[test]
fn crawling_is_stuck_by_the_released_rules_only() {
    // 1.9 m/s: slower than 0.01 m per 5 ms. 120 m − 10 m take 57.9 s.
    assert_eq!(paper(60.0, line(1.9)).outcome, Outcome::Success);
    let score = play(&profile("release"), &geometry(), 60.0, line(1.9)).unwrap();
    assert_eq!(score.outcome, Outcome::Stuck);
    close(score.time_s, 10.0, DT);
    // One sample at more than 2 m/s starts the count anew.
    let jerk =
        |t: f64| Sample { x: -60.0 + 1.9 * t + if t >= 7.0 { 0.05 } else { 0.0 }, ..Sample::default() };
    close(play(&profile("release"), &geometry(), 60.0, jerk).unwrap().time_s, 17.0, DT);
    close(play(&profile("dev"), &geometry(), 60.0, line(1.9)).unwrap().time_s, 5.0, DT);
}

#[test]
fn a_vehicle_on_its_side_is_a_rollover_when_it_has_come_to_rest() {
    let at = |t: f64| {
        let (x, roll) = if t < 3.0 { (4.0 * t, 0.0) } else { (12.0, radians(-95.0)) };
        Sample { x: -60.0 + x, roll, ..Sample::default() }
    };
    let score = paper(60.0, at);
    assert_eq!((score.outcome, score.three_way), (Outcome::Rollover, ThreeWay::Rollover));
    // Less than a metre from the end of the window's beginning: 0.25 s before the stop at 4 m/s.
    close(score.time_s, 12.75, 2.0 * DT);
    close(score.metrics.unwrap().roll_end_deg, -95.0, 1e-9);
    assert!(score.reason.contains("roll -95.0°"), "{}", score.reason);
}

#[test]
fn the_limit_of_roll_is_thirty_degrees_at_the_end() {
    let tilted =
        |degrees: f64| paper(60.0, move |_| Sample { roll: radians(degrees), ..Sample::default() }).outcome;
    assert_eq!(tilted(29.99), Outcome::Stuck);
    assert_eq!(tilted(30.01), Outcome::Rollover);
    assert_eq!(tilted(-30.01), Outcome::Rollover);
    // Pitch doesn't matter to the paper, nor does a roll that it recovers from.
    let pitched = paper(60.0, |_| Sample { pitch: radians(80.0), ..Sample::default() });
    assert_eq!(pitched.outcome, Outcome::Stuck);
    let recovered =
        |t: f64| Sample { roll: if t < 1.0 { 0.6 } else { 0.0 }, pitch: 0.1, ..Sample::default() };
    assert_eq!(paper(60.0, recovered).outcome, Outcome::Stuck);
    // The evaluation scripts take the greatest angle of the trial, pitch included.
    assert_eq!(play(&profile("dev"), &geometry(), 60.0, recovered).unwrap().outcome, Outcome::Rollover);
    let nose = |t: f64| Sample { pitch: if t < 1.0 { 0.6 } else { 0.0 }, ..Sample::default() };
    let score = play(&profile("dev"), &geometry(), 60.0, nose).unwrap();
    assert!(score.outcome == Outcome::Rollover && score.reason.contains("pitch"), "{}", score.reason);
}

#[test]
fn exploration_has_no_goal_and_ends_where_the_vehicle_tips_over() {
    let rules = profile("exploration");
    // Through the place where others have their goal.
    let score = play(&rules, &geometry(), 61.0, line(2.0)).unwrap();
    assert_eq!(score.outcome, Outcome::Timeout);
    // It tips at 30° a second and is past 60° just after 2 s.
    let tips = |t: f64| Sample { roll: radians(30.0 * t), ..circle(t) };
    let score = play(&rules, &geometry(), 60.0, tips).unwrap();
    assert_eq!(score.outcome, Outcome::Rollover);
    close(score.time_s, 2.0, DT + 1e-9);
    assert!(
        score.reason.starts_with("tipped over by 60.") && score.reason.ends_with(" s"),
        "{}",
        score.reason
    );
    // Both angles count: the upward axis of 50° of pitch and 40° of roll is acos(cos 50° · cos 40°) = 60.5° from the
    // vertical, that of 50° and 38° is 59.6°.
    let both = |pitch: f64, roll: f64| {
        let at = move |t: f64| Sample { pitch: radians(pitch), roll: radians(roll), ..circle(t) };
        play(&rules, &geometry(), 60.0, at).unwrap().outcome
    };
    assert_eq!(both(50.0, 40.0), Outcome::Rollover);
    assert_eq!(both(50.0, 38.0), Outcome::Timeout);
    // The paper's trial goes on: the vehicle may come back onto its wheels.
    close(paper(60.0, |t| Sample { roll: tips(t).roll.min(2.0), ..circle(t) }).time_s, 60.0, 1e-9);
}

#[test]
fn success_does_not_ask_for_the_angles() {
    let score = paper(60.0, |t| Sample { roll: 1.0, ..line(5.0)(t) });
    assert_eq!((score.outcome, score.three_way), (Outcome::Success, ThreeWay::Success));
}

#[test]
fn time_runs_out_at_sixty_seconds_and_success_must_come_before() {
    let score = paper(61.0, circle);
    assert_eq!((score.outcome, score.three_way), (Outcome::Timeout, ThreeWay::Stuck));
    close(score.time_s, 60.0, 1e-9);
    let rolled = paper(61.0, |t| Sample { roll: -0.6, ..circle(t) });
    assert_eq!((rolled.outcome, rolled.three_way), (Outcome::Timeout, ThreeWay::Rollover));
    // The circle of the goal is entered with the sample at 59.99 s, or with that at 60.00 s.
    let jump =
        |at: f64| move |t: f64| Sample { x: if t > at - 1e-6 { 59.0 } else { circle(t).x }, ..circle(t) };
    let near = |at: f64| {
        let f = jump(at);
        paper(61.0, move |t| Sample { y: if t > at - 1e-6 { 0.0 } else { circle(t).y }, ..f(t) }).outcome
    };
    assert_eq!(near(59.99), Outcome::Success);
    assert_eq!(near(60.0), Outcome::Timeout);
}

#[test]
fn leaving_the_world_is_a_class_of_its_own_that_the_paper_counts_as_stuck() {
    let away = |t: f64| Sample { y: 5.0 * t, z: -t, roll: 2.0, ..Sample::default() };
    let score = paper(60.0, away);
    assert_eq!((score.outcome, score.three_way), (Outcome::OutOfBounds, ThreeWay::Stuck));
    close(score.time_s, 64.0 / 5.0, DT + 1e-9);
    // The released rules know no bounds: it falls until time runs out.
    assert_eq!(play(&profile("release"), &geometry(), 61.0, away).unwrap().outcome, Outcome::Timeout);
}

#[test]
fn a_fault_ends_the_trial_with_what_was_measured_until_then() {
    let mut scorer = Scorer::new(&Rules::paper(), &geometry());
    for k in 0..=100 {
        let time = f64::from(k) * DT;
        assert!(scorer.push(&Sample { time, ..line(5.0)(time) }).is_none());
    }
    let score = scorer.clone().fail(Fault::Planner, "out of fuel");
    assert_eq!((score.outcome, score.reason.as_str()), (Outcome::PlannerError, "out of fuel"));
    close(score.time_s, 1.0, 1e-12);
    close(score.metrics.unwrap().distance_m, 5.0, 1e-9);
    assert_eq!(scorer.clone().fail(Fault::Simulation, "x").outcome, Outcome::SimError);
    assert_eq!(scorer.finish(), None);
    let score = Scorer::new(&Rules::paper(), &geometry()).fail(Fault::Planner, "panicked in init");
    assert_eq!((score.time_s, score.metrics), (0.0, None));
}

#[test]
fn a_state_that_is_no_number_is_a_simulation_error_and_spoils_no_figure() {
    let score = paper(60.0, |t| Sample { wz: if t > 1.0 { f64::NAN } else { 0.0 }, ..line(5.0)(t) });
    assert_eq!(score.outcome, Outcome::SimError);
    close(score.metrics.unwrap().distance_m, 5.0, 1e-9);
}

#[test]
fn a_sine_has_the_moments_of_a_sine() {
    // |A sin| over whole periods: mean 2A/π, mean square A²/2, hence variance A² (1/2 − 4/π²).
    // Samples k = 0…6000 at 10 ms, period 4 s. The extra zero at the end adds mean²/6001 = 0.007 to the variance.
    let (roll, pitch) = (radians(10.0), radians(4.0));
    let at = move |t: f64| Sample {
        roll: roll * sin(TAU * t / 4.0),
        pitch: -pitch * sin(TAU * t / 4.0),
        steering: sin(TAU * t / 4.0),
        throttle: 0.25,
        brake: 0.125,
        ..circle(t)
    };
    let m = paper(60.0, at).metrics.unwrap();
    assert_eq!(m.samples, 6001);
    // After 15 rad of a circle with a radius of 20 m.
    let [x, y] = m.end();
    close(x, 20.0 * cos(15.0), 1e-6);
    close(y, 20.0 * sin(15.0), 1e-6);
    close(m.roll_mean_deg, 20.0 / PI, 2e-3);
    close(m.roll_variance_deg2, 100.0 * (0.5 - 4.0 / (PI * PI)), 1e-2);
    close(m.roll_max_deg, 10.0, 1e-9);
    close(m.pitch_mean_deg, 8.0 / PI, 1e-3);
    close(m.pitch_variance_deg2, 16.0 * (0.5 - 4.0 / (PI * PI)), 2e-3);
    close(m.pitch_max_deg, 4.0, 1e-9);
    // Integral of |sin| over 60 s: 60 · 2/π; its travel: 4 a period, so 1 a second.
    close(m.steering_effort_s, 120.0 / PI, 1e-2);
    close(m.steering_rate_per_s, 1.0, 1e-6);
    close(m.throttle_effort_s, 15.0, 1e-9);
    close(m.brake_effort_s, 7.5, 1e-9);
}

#[test]
fn distance_is_measured_along_the_way_in_space() {
    // A helix: radius 20 m at 5 m/s, climbing at 1 m/s. Chords are shorter than arcs by 1 − (Δφ)²/24.
    let m = paper(60.0, |t| Sample { z: t, ..circle(t) }).metrics.unwrap();
    close(m.distance_m, 60.0 * 26.0f64.sqrt(), 1e-3);
    close(m.speed_mean_m_per_s, 26.0f64.sqrt(), 1e-4);
    close(m.goal_distance_min_m, 40.0, 1e-2);
}
