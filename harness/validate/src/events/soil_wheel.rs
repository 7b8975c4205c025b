//! Plates and single wheels on soil, against the closed forms of terramechanics.

use crate::check::Expected;
use crate::event::{Bench, Event, LineKind, Outcome, Plot, Series};
use vb_math::{exp, pow, tan};
use vb_sim::{PressureDirection, SimError, SoilLaw, WheelRig};

/// A soil as the closed forms know it: pressure normal to the rim, no damping, no heaps.
fn bare(law: &SoilLaw) -> SoilLaw {
    SoilLaw { pressure: PressureDirection::Radial, damping: 0.0, bulldozing: None, ..*law }
}

/// Every soil of every set, once, with a name and the name of its set.
fn soils<'a>(bench: &Bench<'a>) -> Vec<(String, &'a str, SoilLaw)> {
    let mut all: Vec<(String, &str, SoilLaw)> = Vec::new();
    for set in bench.soils {
        for (name, law) in &set.soils {
            let law = bare(law);
            if !all.iter().any(|(_, _, l)| *l == law) {
                all.push((format!("{name} ({})", set.name), &set.name, law));
            }
        }
    }
    all
}

pub(super) const PLATE: Event = Event {
    name: "plate",
    title: "Plate on soil",
    about: "Plates 0.1 and 0.3 m wide pressed into every soil: the law's pressure at ten depths against Bekker's formula.",
    run: plate,
};

fn plate(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::new("Pressure under a plate 0.3 m wide", "sinkage, mm", "pressure, kPa");
    for (name, _, law) in soils(bench) {
        let mut worst = 0.0_f64;
        for breadth in [0.1, 0.3] {
            for k in 1..=10 {
                let p = 20e3 * f64::from(k);
                let z = pow(p / (law.k_c / breadth + law.k_phi), 1.0 / law.n);
                worst = worst.max((law.pressure(z, breadth) / p - 1.0).abs());
            }
        }
        let source = "p = (kc/b + kφ) zⁿ at 20 to 200 kPa (Wong 2008, eq. 2.61)";
        o.expect(&format!("{name}: greatest deviation"), 100.0 * worst, "%", Expected::AtMost(1.0), source);
        if plot.lines.len() < 8 {
            let points =
                (0..=40).map(|k| 0.0025 * f64::from(k)).map(|z| [1e3 * z, 1e-3 * law.pressure(z, 0.3)]);
            plot.ours(name, points.filter(|p| p[1] <= 300.0).collect());
        }
    }
    o.plots.push(plot);
    Ok(o)
}

/// The wheel of the closed form: the HMMWV's, W = 6369 N, b = 0.3175 m, D = 0.934 m (Bekker 1956; Wong 2008, ch. 2).
const LOAD: f64 = 2597.0 * vb_sim::GRAVITY / 4.0;
const BREADTH: f64 = 0.3175;
const DIAMETER: f64 = 0.934;

/// Closed form of a rigid wheel.
struct ClosedForm<'a> {
    law: &'a SoilLaw,
    /// m.
    sinkage: f64,
    /// Compaction resistance, N.
    resistance: f64,
    /// Length of contact, m.
    length: f64,
}

impl<'a> ClosedForm<'a> {
    /// z = [3 W / (b (3 − n) k √D)]^(2 / (2 n + 1)), Rc = b k z^(n + 1) / (n + 1) (Wong 2008, eqs. 2.98, 2.97).
    fn new(law: &'a SoilLaw) -> Self {
        let k = law.k_c / BREADTH + law.k_phi;
        let n = law.n;
        let sinkage = pow(3.0 * LOAD / (BREADTH * (3.0 - n) * k * DIAMETER.sqrt()), 2.0 / (2.0 * n + 1.0));
        let resistance = BREADTH * k * pow(sinkage, n + 1.0) / (n + 1.0);
        let length =
            if sinkage < DIAMETER { (DIAMETER * sinkage - sinkage * sinkage).sqrt() } else { DIAMETER };
        Self { law, sinkage, resistance, length }
    }

    /// Greatest thrust: A c + W tan φ (Mohr and Coulomb), N.
    fn thrust(&self) -> f64 {
        BREADTH * self.length * self.law.cohesion + LOAD * tan(self.law.friction_angle_deg.to_radians())
    }

    /// Why the closed form says nothing of this soil, if it doesn't.
    fn unsound(&self) -> Option<&'static str> {
        if self.law.n > 1.3 || self.sinkage > 0.2 * DIAMETER {
            Some("the closed form is for n up to 1.3 and sinkages small beside the diameter")
        } else if self.sinkage < 0.005 {
            Some("soil this firm springs back by as much as it yields; the closed form has no elasticity")
        } else {
            None
        }
    }

    /// Drawbar pull over load at a slip (Janosi and Hanamoto 1961 over the contact's length).
    fn drawbar(&self, slip: f64) -> f64 {
        let x = slip * self.length / self.law.shear_modulus;
        let mobilised = if x > 1e-9 { 1.0 - (1.0 - exp(-x)) / x } else { 0.0 };
        (self.thrust() * mobilised - self.resistance) / LOAD
    }
}

fn rig(bench: &Bench<'_>) -> WheelRig {
    WheelRig {
        radius: 0.5 * DIAMETER,
        width: BREADTH,
        load: LOAD,
        speed: 1.0,
        step: bench.options.step,
        pitch: bench.options.soil_pitch,
    }
}

pub(super) const WHEEL: Event = Event {
    name: "wheel-on-soil",
    title: "Single wheel on soil",
    about: "A rigid wheel of the HMMWV's size in a soil bin on every soil: sinkage and compaction resistance of a smooth rim, \
            and drawbar pull of a rough one over slip, against Bekker's closed form. The form holds for n ≤ 1.3 and sinkages that are small \
            beside the diameter; beyond a fifth of it, it is shown and not judged.",
    run: wheel,
};

const SLIPS: [f64; 6] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8];

fn wheel(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let rig = rig(bench);
    let mut plots: Vec<Plot> = Vec::new();
    let mut columns = vec![("slip".to_owned(), "")];
    let mut rows: Vec<Vec<f64>> = SLIPS.iter().map(|s| vec![*s]).collect();
    for (name, set, law) in soils(bench) {
        let form = ClosedForm::new(&law);
        let runs: Vec<_> = SLIPS.iter().map(|&s| rig.run(&law, s, 1)).collect();
        // The form's sinkage and resistance leave shear on the rim out of the balance of forces.
        let smooth = rig.run(&SoilLaw { friction_angle_deg: 0.0, cohesion: 0.0, ..law }, 0.0, 1);
        let pull: Vec<f64> = runs.iter().map(|r| r.drawbar / LOAD).collect();
        let source = "Bekker's rigid wheel (Wong 2008, ch. 2)";
        let first = o.theory.len();
        let share = |v: f64| Expected::share(v, 0.15);
        let sinkage = format!("{name}: sinkage of a smooth wheel");
        o.expect(&sinkage, 1e3 * smooth.sinkage, "mm", share(1e3 * form.sinkage), source);
        o.expect(
            &format!("{name}: compaction resistance of a smooth wheel / load"),
            smooth.compaction / LOAD,
            "",
            share(form.resistance / LOAD),
            source,
        );
        let most = (form.thrust() - form.resistance) / LOAD;
        let greatest = pull.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let name_most = format!("{name}: greatest drawbar pull / load");
        o.expect(&name_most, greatest, "", share(most), "(A c + W tan φ − Rc) / W (Wong 2008, ch. 2)");
        o.theory(
            name_most,
            Expected::AtMost(form.thrust() / LOAD),
            "Mohr and Coulomb: no more than tan φ + A c / W at any slip",
        );
        if let Some(why) = form.unsound() {
            for e in &mut o.theory[first..] {
                e.unsound = Some(why.to_owned());
            }
        }
        columns.extend([(name.clone(), ""), (format!("{name}, closed form"), "")]);
        for (row, (p, s)) in rows.iter_mut().zip(pull.iter().zip(SLIPS)) {
            row.extend([*p, form.drawbar(s)]);
        }
        if form.unsound().is_some() {
            continue;
        }
        let title = format!("Drawbar pull over slip, soils of {set}");
        let at = plots.iter().position(|p| p.title == title).unwrap_or_else(|| {
            plots.push(Plot::new(&title, "slip", "drawbar pull / load"));
            plots.len() - 1
        });
        let measured = SLIPS.iter().zip(&pull).map(|(s, p)| [*s, *p]).collect();
        plots[at].ours(name.clone(), measured);
        let case = plots[at].lines.last().map_or(0, |l| l.case);
        let theory = (0..=40).map(|k| f64::from(k) / 50.0).map(|s| [s, form.drawbar(s)]).collect();
        plots[at].line(LineKind::Theory, case, format!("{name}, closed form"), theory);
    }
    o.series.push(Series { name: "drawbar".to_owned(), columns, rows });
    o.plots = plots;
    Ok(o)
}

pub(super) const SECOND_PASS: Event = Event {
    name: "second-pass",
    title: "Second pass",
    about: "The same wheel at 20 % slip over fresh soil and once more in its own rut: soil that was pressed once yields less.",
    run: second_pass,
};

fn second_pass(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let rig = rig(bench);
    for (name, _, law) in soils(bench) {
        let first = o.theory.len();
        let (one, two) = (rig.run(&law, 0.2, 1), rig.run(&law, 0.2, 2));
        o.figure(format!("{name}: rut after the first pass"), 1e3 * one.sinkage, "mm");
        o.expect(
            &format!("{name}: share of the first pass' sinkage that the second adds"),
            100.0 * (two.sinkage / one.sinkage - 1.0),
            "%",
            Expected::Between(0.0, 50.0),
            "repeated passes deepen a rut as z2 / z1 = 2^(1/a), a from 2 up (Abebe et al. 1989): up to 41 %, and a tenth",
        );
        o.expect(
            &format!("{name}: compaction resistance of the second pass / first"),
            if one.compaction > 0.0 { two.compaction / one.compaction } else { 0.0 },
            "",
            Expected::AtMost(1.0),
            "soil that was pressed is elastic up to its former pressure",
        );
        if let Some(why) = ClosedForm::new(&law).unsound() {
            for e in &mut o.theory[first..] {
                e.unsound = Some(why.to_owned());
            }
        }
    }
    Ok(o)
}
