//! What the suspension does to the wheels, from its tables.

use crate::bench::Bench;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Series, Vehicles};
use vb_math::angle::degrees;
use vb_math::{asin, atan, tan};
use vb_sim::SimError;

pub(super) const SUSPENSION: Event = Event {
    name: "suspension",
    title: "Suspension and steering",
    about: "Toe, camber and motion ratio over wheel travel, and the angles of the steered wheels over the command, compared \
            with the angles at which all wheels roll about one centre.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: suspension,
};

/// Travel up to which tables are drawn, m: beyond, stops hold the wheels of any vehicle of this size.
const TRAVEL: f64 = 0.12;
const POINTS: i32 = 48;

fn suspension(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let axis = "travel, mm (compression positive)";
    let mut toe = Plot::new("Toe over travel", axis, "toe-in, °");
    let mut camber = Plot::new("Camber over travel", axis, "camber, °");
    let mut ratio = Plot::new("Motion ratio over travel", axis, "spring compression / travel");
    let lefts: Vec<usize> = (0..g.corners.len()).step_by(2).collect();
    let most = bench.pace.length(TRAVEL);
    let travels: Vec<f64> = (-POINTS..=POINTS).map(|k| most * f64::from(k) / f64::from(POINTS)).collect();
    let mut columns = vec![("travel".to_owned(), "m")];
    for &i in &lefts {
        let name = &g.corners[i].name;
        columns.extend([(format!("toe-in {name}"), "°"), (format!("camber {name}"), "°")]);
        columns.push((format!("motion ratio {name}"), ""));
    }
    let row = |&q: &f64| {
        let of = |&i: &usize| {
            let p = g.upright(i, q, 0.0);
            // Toe-in of a left wheel turns it to the right; camber is positive with the top outwards.
            [-degrees(g.wheel_angle(i, q, 0.0)), degrees(asin(-p.axis.z)), -p.strut_rates[0]]
        };
        std::iter::once(q).chain(lefts.iter().flat_map(of)).collect::<Vec<f64>>()
    };
    let table = Series { name: "travel".to_owned(), columns, rows: travels.iter().map(row).collect() };
    for (k, &i) in lefts.iter().enumerate() {
        let column = |c: usize| table.rows.iter().map(|r| [1e3 * r[0], r[1 + 3 * k + c]]).collect::<Vec<_>>();
        let name = &g.corners[i].name;
        toe.ours(name.clone(), column(0));
        camber.ours(name.clone(), column(1));
        ratio.ours(name.clone(), column(2));
        o.figure(format!("motion ratio, {name}, design height"), -g.upright(i, 0.0, 0.0).strut_rates[0], "");
    }
    o.series.push(table);
    o.plots.extend([toe, camber, ratio]);

    let Some(left) = (0..g.corners.len()).find(|&i| g.is_steered(i)) else {
        o.note("No axle is steered.");
        return Ok(o);
    };
    let right = left + 1;
    let mut steer = Plot::new(
        "Wheel angles over the steering command",
        "command (left positive)",
        "angle, ° (left positive)",
    );
    let commands: Vec<f64> = (-20..=20).map(|k| f64::from(k) / 20.0).collect();
    let angle = |i: usize, c: f64| degrees(g.wheel_angle(i, 0.0, c));
    let rows = commands.iter().map(|&c| {
        let (l, r) = (angle(left, c), angle(right, c));
        let (ideal_l, ideal_r) = ackermann(0.5 * (l + r), g.wheelbase(), g.track());
        vec![c, l, r, ideal_l, ideal_r]
    });
    let columns = ["command", "left", "right", "ideal left", "ideal right"].into_iter();
    let columns = columns.map(|n| (n.to_owned(), if n == "command" { "" } else { "°" })).collect();
    let table = Series { name: "steering".to_owned(), columns, rows: rows.collect() };
    for (case, side) in ["left", "right"].into_iter().enumerate() {
        steer.line(LineKind::Ours, case, format!("{side} wheel"), table.pairs("command", side));
        steer.line(
            LineKind::Theory,
            case,
            format!("{side}, Ackermann"),
            table.pairs("command", &format!("ideal {side}")),
        );
    }
    o.plots.push(steer);
    o.series.push(table);
    let (l, r) = (angle(left, 1.0), angle(right, 1.0));
    o.figure("angle of the inner wheel at full lock", l, "°");
    o.figure("angle of the outer wheel at full lock", r, "°");
    let (ideal_l, ideal_r) = ackermann(0.5 * (l + r), g.wheelbase(), g.track());
    o.figure("Ackermann share at full lock", (l - r) / (ideal_l - ideal_r), "");
    let mut gears = bench.spec.axles.iter().filter_map(|a| a.steering.as_ref());
    if gears.all(|gear| gear.position(1.0) == -gear.position(-1.0)) {
        o.expect(
            "sum of the angles at opposite locks, left and right wheel",
            (angle(left, 1.0) + angle(right, -1.0)).abs(),
            "°",
            crate::Expected::AtMost(1e-6),
            "symmetry: left and right are mirror images",
        );
    }
    Ok(o)
}

/// Angles (°) of the left and right wheel about one centre on the rear axle's line, with a mean of `mean` (°).
fn ackermann(mean: f64, wheelbase: f64, track: f64) -> (f64, f64) {
    if mean == 0.0 {
        return (0.0, 0.0);
    }
    let radius = wheelbase / tan(mean.to_radians());
    let at = |offset: f64| degrees(atan(wheelbase / (radius + offset)));
    // The centre lies to the left for a positive angle: the left wheel is nearer to it.
    (at(-0.5 * track), at(0.5 * track))
}
