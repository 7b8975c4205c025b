//! The tyres' steady curves.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Series, Vehicles};
use vb_math::{atan, hypot, tan};
use vb_sim::{SimError, tyre::Tyre};
use vb_vehicle::{TyreSpec, tyre::FialaTyre};

pub(super) const TYRES: Event = Event {
    name: "tyres",
    title: "Tyre curves",
    about: "Steady forces at friction 0.9, sampled from the simulated tyre models: of the fitted tyre at four loads \
            and in combined slip, and of all the vehicle's tyres at the mean static load.",
    vehicles: Vehicles::Wheeled,
    place: Place::Rigid,
    run: tyres,
};

const FRICTION: f64 = 0.9;
/// Loads over the mean static load of a wheel.
const LOADS: [f64; 4] = [0.5, 1.0, 1.5, 2.0];
/// Points over a half range of slip (1) and of slip angle (25°).
const POINTS: i32 = 100;
const WIDEST: f64 = 25.0;
/// Slip angles of the plot of combined slip, °.
const ANGLES: [f64; 5] = [0.0, 2.0, 4.0, 8.0, 16.0];

/// Longitudinal slips from −1 to 1, closer together about zero.
fn slips() -> Vec<f64> {
    let t = |k: i32| f64::from(k) / f64::from(POINTS);
    (-POINTS..=POINTS).map(|k| t(k) * t(k).abs()).collect()
}

/// Slip angles, °.
fn angles() -> Vec<f64> {
    (-POINTS..=POINTS).map(|k| WIDEST * f64::from(k) / f64::from(POINTS)).collect()
}

fn tyres(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let load = g.weight() / g.corners.len() as f64;
    fitted(&mut o, &bench.spec.tyre, load);
    let mut along = Plot::new("Longitudinal force of all tyres", "slip κ", "force / load");
    let mut across = Plot::new("Lateral force of all tyres", "slip angle, °", "force / load");
    let mut twist = Plot::new("Aligning moment of all tyres", "slip angle, °", "moment, N m");
    let fitted = bench.spec.tyre.model();
    let others = bench.spec.tyres.iter().filter(|(name, _)| name.as_str() != fitted);
    let all = others.map(|(name, spec)| (name.as_str(), spec));
    for (name, spec) in std::iter::once((fitted, &bench.spec.tyre)).chain(all) {
        let (rolled, cornered) = curves(spec, load);
        let case = along.lines.iter().map(|l| l.case + 1).max().unwrap_or(0);
        let of = |s: &Series, column: &str, by: f64| -> Vec<[f64; 2]> {
            let x = s.columns[0].0.clone();
            s.pairs(&x, column).into_iter().map(|[x, y]| [x, y / by]).collect()
        };
        along.line(LineKind::Ours, case, name, of(&rolled, "Fx", load));
        across.line(LineKind::Ours, case, name, of(&cornered, "Fy", load));
        if cornered.pairs("slip angle", "Mz").iter().any(|p| p[1] != 0.0) {
            twist.line(LineKind::Ours, case, name, of(&cornered, "Mz", 1.0));
        }
        let peak = |points: Vec<[f64; 2]>| points.iter().map(|p| p[1].abs()).fold(0.0, f64::max) / load;
        o.figure(
            format!("{name}: greatest longitudinal force over load"),
            peak(rolled.pairs("slip", "Fx")),
            "",
        );
        o.figure(
            format!("{name}: greatest lateral force over load, up to 25°"),
            peak(cornered.pairs("slip angle", "Fy")),
            "",
        );
        if let TyreSpec::Fiala(t) = spec {
            let fx: Vec<_> = slips().into_iter().map(|k| [k, closed_form(t, load, k, 0.0)[0]]).collect();
            let fy: Vec<_> = angles().into_iter().map(|a| [a, closed_form(t, load, 0.0, a)[1]]).collect();
            let off = |ours: Vec<[f64; 2]>, theory: &[[f64; 2]]| {
                ours.iter().zip(theory).map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f64::max) / load
            };
            let worst =
                off(rolled.pairs("slip", "Fx"), &fx).max(off(cornered.pairs("slip angle", "Fy"), &fy));
            o.expect(
                &format!("{name}: greatest deviation from the closed form over load"),
                1e6 * worst,
                "ppm",
                Expected::AtMost(0.01),
                "Fiala's formulas (Adams/Tire), friction scaled by the ground",
            );
            let over = |v: Vec<[f64; 2]>| v.into_iter().map(|[x, y]| [x, y / load]).collect();
            along.line(LineKind::Theory, case, format!("{name}, closed form"), over(fx));
            across.line(LineKind::Theory, case, format!("{name}, closed form"), over(fy));
        }
        o.series.extend([
            Series { name: format!("{name}-slip"), ..rolled },
            Series { name: format!("{name}-slip-angle"), ..cornered },
        ]);
    }
    o.plots.extend([along, across, twist]);
    o.note(
        "Lateral forces are negative at positive slip angles: the wheel moves to its left, the ground pushes it right (ISO 8855).",
    );
    Ok(o)
}

/// Plots of the fitted tyre.
fn fitted(o: &mut Outcome, spec: &TyreSpec, load: f64) {
    let name = spec.model();
    let mut along = Plot::new("Longitudinal force over slip and load", "slip κ", "force, kN");
    let mut across = Plot::new("Lateral force over slip angle and load", "slip angle, °", "force, kN");
    for fraction in LOADS {
        let (rolled, cornered) = curves(spec, fraction * load);
        let kilo = |points: Vec<[f64; 2]>| points.into_iter().map(|[x, y]| [x, 1e-3 * y]).collect();
        let label = format!("{name}, {:.1} kN", 1e-3 * fraction * load);
        along.ours(label.clone(), kilo(rolled.pairs("slip", "Fx")));
        across.ours(label, kilo(cornered.pairs("slip angle", "Fy")));
    }
    let mut both = Plot::new(
        "Combined slip, from locked to spinning",
        "longitudinal force / load",
        "lateral force / load",
    );
    let tyre = Tyre::new(spec);
    let mut widest = 0.0_f64;
    for angle in ANGLES {
        let points: Vec<_> = slips().into_iter().map(|k| (k, angle.to_radians())).collect();
        let forces = tyre.sample(&[load], &points, FRICTION).into_iter().flatten();
        let line: Vec<[f64; 2]> = forces.map(|f| [f.longitudinal / load, f.lateral / load]).collect();
        widest = line.iter().map(|p| hypot(p[0], p[1])).fold(widest, f64::max);
        both.ours(format!("{name}, {angle:.0}°"), line);
    }
    o.figure("greatest force over load in combined slip", widest, "");
    if let Some(friction) = spec.coulomb_friction() {
        let bound = FRICTION.min(friction);
        o.theory(
            "greatest force over load in combined slip",
            Expected::AtMost(bound * (1.0 + 1e-9)),
            "friction circle",
        );
    }
    o.plots.extend([along, across, both]);
}

/// Forces over slip, and forces and moment over slip angle, at one load.
fn curves(spec: &TyreSpec, load: f64) -> (Series, Series) {
    let tyre = Tyre::new(spec);
    let sample = |points: &[(f64, f64)]| tyre.sample(&[load], points, FRICTION).into_iter().flatten();
    let (slips, angles) = (slips(), angles());
    let rolled: Vec<_> = slips.iter().map(|&k| (k, 0.0)).collect();
    let cornered: Vec<_> = angles.iter().map(|&a| (0.0, a.to_radians())).collect();
    let column = |name: &str, unit| (name.to_owned(), unit);
    let rolled = Series {
        name: "slip".to_owned(),
        columns: vec![column("slip", ""), column("Fx", "N")],
        rows: slips.iter().zip(sample(&rolled)).map(|(&k, f)| vec![k, f.longitudinal]).collect(),
    };
    let cornered = Series {
        name: "slip-angle".to_owned(),
        columns: vec![column("slip angle", "°"), column("Fy", "N"), column("Mz", "N m")],
        rows: angles.iter().zip(sample(&cornered)).map(|(&a, f)| vec![a, f.lateral, f.aligning]).collect(),
    };
    (rolled, cornered)
}

/// F_x and F_y of Fiala's model in pure slip κ or pure slip angle (°), N: U = (µ_max − (µ_max − µ_min) S) µ/µ_0 with
/// S = min(1, √(κ² + tan² α)); up to S_c = U F_z/(2 C_s) F_x = C_s κ, beyond U F_z − (U F_z)²/(4 |κ| C_s); up to
/// tan α = 3 U F_z/C_α F_y = −U F_z (1 − H³) with H = 1 − C_α |tan α|/(3 U F_z), beyond −U F_z.
fn closed_form(t: &FialaTyre, load: f64, slip: f64, angle: f64) -> [f64; 2] {
    let (k, a) = (slip.abs(), tan(angle.to_radians().abs()));
    let s = hypot(k, a).min(1.0);
    let bears = (t.mu_max - (t.mu_max - t.mu_min) * s) * FRICTION / t.mu_0 * load;
    let x =
        if k < 0.5 * bears / t.c_slip { t.c_slip * k } else { bears - bears * bears / (4.0 * k * t.c_slip) };
    let y = if atan(a) <= atan(3.0 * bears / t.c_alpha) {
        let h = 1.0 - t.c_alpha * a / (3.0 * bears);
        bears * (1.0 - h * h * h)
    } else {
        bears
    };
    [x * sign(slip), -y * sign(angle)]
}

fn sign(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}
