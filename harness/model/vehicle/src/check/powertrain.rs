//! Engine, converter, gearbox and driveline.

use crate::field::{Check, LARGEST, SMALLEST};
use crate::table::interpolate;
use crate::{
    VehicleSpec,
    powertrain::{Converter, Differential, Driveline, Engine, Gearbox},
};
use vb_files::Flaw;

/// What no engine idles at, rad/s; the squares of much higher speeds make torques that nothing can compute with.
const FASTEST_IDLE: f64 = 1000.0;

impl Check {
    pub(super) fn powertrain(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        let p = &v.powertrain;
        self.engine(&p.engine)?;
        if let Some(c) = &p.converter {
            self.converter(c)?;
            let inertia = p.engine.inertia();
            if inertia <= 0.0 {
                let reason =
                    format!("{inertia} must be positive, since a converter lets the engine turn freely");
                return self.fail("powertrain.engine.inertia", reason);
            }
        }
        if let Some(g) = p.governor {
            self.positive("powertrain.governor.speed", g.speed)?;
            self.positive("powertrain.governor.band", g.band)?;
        }
        self.gearbox(&p.gearbox)?;
        self.driveline(&p.driveline, v.axles.iter().filter(|a| a.driven).count())
    }

    /// A table of finite numbers over increasing speeds or ratios.
    pub(super) fn table(&self, field: &str, points: &[[f64; 2]]) -> Result<(), Flaw> {
        if points.is_empty() || points.iter().flatten().any(|x| !x.is_finite()) {
            return self.fail(field, "needs at least one point of two finite numbers".to_owned());
        }
        match points.windows(2).find(|w| w[0][0] >= w[1][0]) {
            None => Ok(()),
            Some(w) => {
                self.fail(field, format!("first numbers must increase, but {} follows {}", w[1][0], w[0][0]))
            }
        }
    }

    /// Checks a table of output over command that may be absent: it goes from the first command of `range` to the last, rises
    /// or is level, stays within the range, and gives 0 at 0 and at one end of the range that end itself.
    pub(super) fn characteristic(
        &self,
        field: &str,
        points: &[[f64; 2]],
        [low, high]: [f64; 2],
    ) -> Result<(), Flaw> {
        if points.is_empty() {
            return Ok(());
        }
        self.table(field, points)?;
        let (first, last) = (points[0], points[points.len() - 1]);
        if first[0] != low || last[0] != high {
            let reason = format!("goes from {} to {}; must go from {low} to {high}", first[0], last[0]);
            return self.fail(field, reason);
        }
        if let Some(w) = points.windows(2).find(|w| w[0][1] > w[1][1]) {
            let reason = format!("second numbers must not fall, but {} follows {}", w[1][1], w[0][1]);
            return self.fail(field, reason);
        }
        let zero = interpolate(points, 0.0).0;
        if zero != 0.0 {
            return self.fail(field, format!("gives {zero} at 0; must give 0"));
        }
        let reach = last[1].max(-first[1]);
        if reach != high {
            let reason = format!("reaches {reach}; must reach {high} at one end and no more at the other");
            return self.fail(field, reason);
        }
        Ok(())
    }

    fn engine(&self, engine: &Engine) -> Result<(), Flaw> {
        self.not_negative("powertrain.engine.inertia", engine.inertia())?;
        match engine {
            Engine::Map { full_throttle, closed_throttle, .. } => {
                self.table("powertrain.engine.full_throttle", full_throttle)?;
                self.table("powertrain.engine.closed_throttle", closed_throttle)
            }
            Engine::Simple { torque, power, max_speed, .. } => {
                self.positive("powertrain.engine.torque", *torque)?;
                self.positive("powertrain.engine.power", *power)?;
                self.positive("powertrain.engine.max_speed", *max_speed)
            }
            Engine::Electric { torque, regeneration, friction, voltage, .. } => {
                self.not_negative("powertrain.engine.friction", *friction)?;
                let field = "powertrain.engine.torque";
                self.table(field, torque)?;
                let (first, last) = (torque[0], torque[torque.len() - 1]);
                if first[0] != 0.0 || first[1] <= 0.0 || last[0] <= 0.0 || last[1] != 0.0 {
                    let reason = format!(
                        "goes from [{}, {}] to [{}, {}]; must go from [0, stall torque] to [no-load speed, 0]",
                        first[0], first[1], last[0], last[1]
                    );
                    return self.fail(field, reason);
                }
                if torque.iter().any(|p| p[1] < 0.0) {
                    return self.fail(field, "must not be negative; see regeneration".to_owned());
                }
                self.fraction("powertrain.engine.regeneration", *regeneration)?;
                self.characteristic("powertrain.engine.voltage", voltage, [0.0, 1.0])
            }
        }
    }

    fn fraction(&self, field: &str, value: f64) -> Result<(), Flaw> {
        if (0.0..=1.0).contains(&value) {
            return Ok(());
        }
        self.fail(field, format!("{value} must lie between 0 and 1"))
    }

    fn converter(&self, c: &Converter) -> Result<(), Flaw> {
        let at = |f: &str| format!("powertrain.converter.{f}");
        self.positive(&at("idle_speed"), c.idle_speed)?;
        if c.idle_speed > FASTEST_IDLE {
            let reason = format!("{} must be {FASTEST_IDLE} rad/s at most", c.idle_speed);
            return self.fail(&at("idle_speed"), reason);
        }
        for (name, points) in [("capacity", &c.capacity), ("torque_ratio", &c.torque_ratio)] {
            self.table(&at(name), points)?;
            for (i, p) in points.iter().enumerate() {
                self.fraction(&at(&format!("{name}[{i}][0]")), p[0])?;
                self.positive(&at(&format!("{name}[{i}][1]")), p[1])?;
            }
        }
        for k in 0..=100 {
            let r = 0.01 * f64::from(k);
            let multiplied = crate::table::interpolate(&c.torque_ratio, r).0;
            if multiplied * r > 1.0 + 1e-9 {
                let reason = format!("{multiplied} at speed ratio {r} would give more power than it takes");
                return self.fail(&at("torque_ratio"), reason);
            }
        }
        let Some(l) = c.lock_up else { return Ok(()) };
        self.fraction(&at("lock_up.speed_ratio"), l.speed_ratio)?;
        self.positive(&at("lock_up.release_speed"), l.release_speed)?;
        self.positive(&at("lock_up.torque"), l.torque)
    }

    fn gearbox(&self, g: &Gearbox) -> Result<(), Flaw> {
        if g.ratios.is_empty() || g.ratios.len() != g.shift_up.len() || g.ratios.len() != g.shift_down.len() {
            let reason = format!(
                "{} ratios, {} shift_down, {} shift_up: there must be as many of each, and one at least",
                g.ratios.len(),
                g.shift_down.len(),
                g.shift_up.len()
            );
            return self.fail("powertrain.gearbox", reason);
        }
        for i in 0..g.ratios.len() {
            self.positive(&format!("powertrain.gearbox.ratios[{i}]"), g.ratios[i])?;
            if i > 0 && g.ratios[i] <= g.ratios[i - 1] {
                let reason =
                    format!("{} follows {}; the lowest gear comes first", g.ratios[i], g.ratios[i - 1]);
                return self.fail(&format!("powertrain.gearbox.ratios[{i}]"), reason);
            }
            if !(g.shift_down[i].is_finite() && g.shift_up[i] > g.shift_down[i]) {
                let reason =
                    format!("{} must be greater than shift_down[{i}] = {}", g.shift_up[i], g.shift_down[i]);
                return self.fail(&format!("powertrain.gearbox.shift_up[{i}]"), reason);
            }
        }
        if let Some(r) = g.reverse.filter(|r| !(r.is_finite() && *r < 0.0)) {
            return self.fail("powertrain.gearbox.reverse", format!("{r} must be a negative number"));
        }
        if let Some(r) = g.reverse.filter(|r| !(SMALLEST..=LARGEST).contains(&-r)) {
            return self.beyond("powertrain.gearbox.reverse", r);
        }
        self.positive("powertrain.gearbox.direction_change.speed", g.direction_change.speed)?;
        self.not_negative("powertrain.gearbox.direction_change.latency", g.direction_change.latency)?;
        self.not_negative("powertrain.gearbox.shift_time", g.shift_time)?;
        self.not_negative("powertrain.gearbox.latency", g.latency)
    }

    fn driveline(&self, d: &Driveline, driven: usize) -> Result<(), Flaw> {
        self.not_negative("powertrain.driveline.shaft_inertia", d.shaft_inertia)?;
        self.differential("powertrain.driveline.centre", d.centre)?;
        if d.axles.len() != driven {
            let reason = format!("{} given, but {driven} of the vehicle's axles are driven", d.axles.len());
            return self.fail("powertrain.driveline.axles", reason);
        }
        for (i, a) in d.axles.iter().enumerate() {
            let at = |f: &str| format!("powertrain.driveline.axles[{i}].{f}");
            self.positive(&at("share"), a.fraction)?;
            self.positive(&at("final_drive"), a.final_drive)?;
            self.not_negative(&at("shaft_inertia"), a.shaft_inertia)?;
            self.not_negative(&at("box_inertia"), a.box_inertia)?;
            self.differential(&at("differential"), a.differential)?;
        }
        let sum: f64 = d.axles.iter().map(|a| a.fraction).sum();
        if (sum - 1.0).abs() > 1e-6 {
            return self
                .fail("powertrain.driveline.axles", format!("the shares make {sum}; they must make 1"));
        }
        Ok(())
    }

    fn differential(&self, field: &str, d: Differential) -> Result<(), Flaw> {
        match d {
            Differential::Open {} | Differential::Locked {} => Ok(()),
            Differential::Clutch { torque } => self.not_negative(&format!("{field}.torque"), torque),
            Differential::LimitedSlip { bias, preload } => {
                if !(bias.is_finite() && bias >= 1.0) {
                    return self.fail(&format!("{field}.bias"), format!("{bias} must be 1 or more"));
                }
                self.not_negative(&format!("{field}.preload"), preload)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        VehicleSpec,
        powertrain::{Differential, DirectionChange, Engine},
    };

    const HMMWV: &str = include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml");

    /// The HMMWV's file with another engine, and lines added below it.
    fn with_engine(engine: &str) -> Result<VehicleSpec, String> {
        let (head, rest) = HMMWV.split_once("  engine:\n").unwrap();
        let (_, tail) = rest.split_once("  gearbox:\n").unwrap();
        let text = format!("{head}  engine: {engine}\n  gearbox:\n{tail}");
        VehicleSpec::parse(&text, "car.yaml").map_err(|e| e.to_string())
    }

    fn replaced(from: &str, to: &str) -> Result<VehicleSpec, String> {
        assert!(HMMWV.contains(from), "{from}");
        VehicleSpec::parse(&HMMWV.replacen(from, to, 1), "car.yaml").map_err(|e| e.to_string())
    }

    #[test]
    fn every_kind_of_engine_and_differential_can_be_written() {
        let v = with_engine("{type: simple, torque: 200.0, power: 14000.0, max_speed: 366.5}").unwrap();
        assert_eq!(v.powertrain.engine.inertia(), 0.0);
        let v =
            with_engine("{type: electric, torque: [[0.0, 160.0], [503.7, 0.0]], inertia: 1.0e-4}").unwrap();
        assert!(matches!(v.powertrain.engine, Engine::Electric { regeneration: 0.0, .. }));
        let motor = |voltage: &str| {
            with_engine(&format!(
                "{{type: electric, torque: [[0.0, 160.0], [503.7, 0.0]], voltage: {voltage}}}"
            ))
        };
        assert!(motor("[[0.0, 0.0], [0.1, 0.0], [1.0, 1.0]]").is_ok());
        let e = motor("[[0.0, 0.0], [1.0, 12.0]]").unwrap_err();
        assert_eq!(
            e,
            "car.yaml: powertrain.engine.voltage: reaches 12; must reach 1 at one end and no more at the other"
        );
        for (text, expected) in [
            ("{type: open}", Differential::Open {}),
            ("{type: locked}", Differential::Locked {}),
            ("{type: limited_slip, bias: 2.0}", Differential::LimitedSlip { bias: 2.0, preload: 0.0 }),
        ] {
            let v = replaced("centre: {type: clutch, torque: 100.0}", &format!("centre: {text}")).unwrap();
            assert_eq!(v.powertrain.driveline.centre, expected);
        }
    }

    #[test]
    fn a_converter_asks_for_an_engine_with_inertia_and_for_a_torque_ratio_that_gives_no_power() {
        let engine = "{type: simple, torque: 800.0, power: 1.0e5, max_speed: 300.0, inertia: INERTIA}\n  \
                      converter: {idle_speed: 80.0, capacity: [[0.0, 15.0], [1.0, 35.0]], \
                      torque_ratio: [[0.0, 2.0], [0.9, RATIO], [1.0, 1.0]]}";
        let of = |inertia: &str, ratio: &str| {
            with_engine(&engine.replace("INERTIA", inertia).replace("RATIO", ratio))
        };
        assert!(of("1.6", "1.05").is_ok());
        let fast = engine.replace("idle_speed: 80.0", "idle_speed: 1.0e9");
        let e = with_engine(&fast.replace("INERTIA", "1.6").replace("RATIO", "1.05")).unwrap_err();
        assert!(
            e.starts_with("car.yaml: powertrain.converter.idle_speed: 1000000000 must be 1000 rad/s"),
            "{e}"
        );
        let e = of("0.0", "1.05").unwrap_err();
        assert!(e.starts_with("car.yaml: powertrain.engine.inertia: 0 must be positive"), "{e}");
        let e = of("1.6", "1.3").unwrap_err();
        assert!(
            e.starts_with("car.yaml: powertrain.converter.torque_ratio: ") && e.contains("more power"),
            "{e}"
        );
    }

    #[test]
    fn a_gearbox_without_reverse_and_one_that_says_nothing_of_changing_the_direction_can_be_written() {
        assert_eq!(replaced("    reverse: -0.2\n", "").unwrap().powertrain.gearbox.reverse, None);
        let line = HMMWV.lines().find(|l| l.contains("direction_change:")).unwrap();
        let v = replaced(&format!("{line}\n"), "").unwrap();
        assert_eq!(v.powertrain.gearbox.direction_change, DirectionChange { speed: 0.5, latency: 0.5 });
    }

    #[test]
    fn messages_name_the_field_the_value_and_what_to_do() {
        for (from, to, expected) in [
            (
                "share: 0.5",
                "share: 0.6",
                "car.yaml: powertrain.driveline.axles: the shares make 1.1; they must make 1",
            ),
            (
                "position: [-1.68656, 0.0, 0.0263906]\n    driven: true",
                "position: [-1.68656, 0.0, 0.0263906]\n    driven: false",
                "car.yaml: powertrain.driveline.axles: 2 given, but 1 of the vehicle's axles are driven",
            ),
            (
                "centre: {type: clutch, torque: 100.0}",
                "centre: {type: limited_slip, bias: 0.5}",
                "car.yaml: powertrain.driveline.centre.bias: 0.5 must be 1 or more",
            ),
            (
                "[0.1708, 0.2791,",
                "[0.1708, 0.1,",
                "car.yaml: powertrain.gearbox.ratios[1]: 0.1 follows 0.1708; the lowest gear comes first",
            ),
            (
                "reverse: -0.2",
                "reverse: 0.2",
                "car.yaml: powertrain.gearbox.reverse: 0.2 must be a negative number",
            ),
            (
                "reverse: -0.2",
                "reverse: -1.0e-12",
                "car.yaml: powertrain.gearbox.reverse: -1e-12 is what no vehicle has (give a size from 1e-9 to 1e9, \
                 in SI units)",
            ),
            (
                "direction_change: {speed: 0.5, latency: 0.6}",
                "direction_change: {speed: 0.0, latency: 0.6}",
                "car.yaml: powertrain.gearbox.direction_change.speed: 0 must be a positive number",
            ),
            (
                "direction_change: {speed: 0.5, latency: 0.6}",
                "direction_change: {speed: 0.5, latency: -0.1}",
                "car.yaml: powertrain.gearbox.direction_change.latency: -0.1 must be zero or a positive number",
            ),
            (
                "- [104.72, 926.0]",
                "- [64.72, 926.0]",
                "car.yaml: powertrain.engine.full_throttle: first numbers must increase, but 64.72 follows 83.776",
            ),
        ] {
            assert_eq!(replaced(from, to).unwrap_err(), expected);
        }
        let e = with_engine("{type: electric, torque: [[0.0, 1.6], [503.7, 0.2]]}").unwrap_err();
        assert!(e.contains("must go from [0, stall torque] to [no-load speed, 0]"), "{e}");
        let e = with_engine("{type: steam, torque: 3.0}").unwrap_err();
        assert!(e.starts_with("car.yaml: powertrain.engine") && e.contains("steam"), "{e}");
    }
}
