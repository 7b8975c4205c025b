//! Engine, converter, gearbox and driveline.

use super::Check;
use crate::error::SimError;
use crate::spec::{Converter, Differential, Driveline, Engine, Gearbox, VehicleSpec};

impl Check<'_> {
    pub(super) fn powertrain(&self, v: &VehicleSpec) -> Result<(), SimError> {
        let p = &v.powertrain;
        self.engine(&p.engine)?;
        if let Some(c) = &p.converter {
            self.converter(c)?;
            let inertia = p.engine.inertia();
            if inertia <= 0.0 {
                let reason = format!("{inertia} must be positive, since a converter lets the engine turn freely");
                return self.fail("powertrain.engine.inertia", reason);
            }
        }
        self.gearbox(&p.gearbox)?;
        self.driveline(&p.driveline, v.axles.iter().filter(|a| a.driven).count())
    }

    /// A table of finite numbers over increasing speeds or ratios.
    pub(super) fn table(&self, field: &str, points: &[[f64; 2]]) -> Result<(), SimError> {
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

    fn engine(&self, engine: &Engine) -> Result<(), SimError> {
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
            Engine::Electric { torque, regeneration, .. } => {
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
                self.fraction("powertrain.engine.regeneration", *regeneration)
            }
        }
    }

    fn fraction(&self, field: &str, value: f64) -> Result<(), SimError> {
        if (0.0..=1.0).contains(&value) {
            return Ok(());
        }
        self.fail(field, format!("{value} must lie between 0 and 1"))
    }

    fn converter(&self, c: &Converter) -> Result<(), SimError> {
        let at = |f: &str| format!("powertrain.converter.{f}");
        self.positive(&at("idle_speed"), c.idle_speed)?;
        for (name, points) in [("capacity", &c.capacity), ("torque_ratio", &c.torque_ratio)] {
            self.table(&at(name), points)?;
            for (i, p) in points.iter().enumerate() {
                self.fraction(&at(&format!("{name}[{i}][0]")), p[0])?;
                self.positive(&at(&format!("{name}[{i}][1]")), p[1])?;
            }
        }
        for k in 0..=100 {
            let r = 0.01 * f64::from(k);
            let multiplied = crate::powertrain::interpolate(&c.torque_ratio, r).0;
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

    fn gearbox(&self, g: &Gearbox) -> Result<(), SimError> {
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
        self.not_negative("powertrain.gearbox.shift_time", g.shift_time)?;
        self.not_negative("powertrain.gearbox.latency", g.latency)
    }

    fn driveline(&self, d: &Driveline, driven: usize) -> Result<(), SimError> {
        self.not_negative("powertrain.driveline.shaft_inertia", d.shaft_inertia)?;
        self.differential("powertrain.driveline.centre", d.centre)?;
        if d.axles.len() != driven {
            let reason = format!("{} given, but {driven} of the vehicle's axles are driven", d.axles.len());
            return self.fail("powertrain.driveline.axles", reason);
        }
        for (i, a) in d.axles.iter().enumerate() {
            let at = |f: &str| format!("powertrain.driveline.axles[{i}].{f}");
            self.positive(&at("share"), a.share)?;
            self.positive(&at("final_drive"), a.final_drive)?;
            self.not_negative(&at("shaft_inertia"), a.shaft_inertia)?;
            self.not_negative(&at("box_inertia"), a.box_inertia)?;
            self.differential(&at("differential"), a.differential)?;
        }
        let sum: f64 = d.axles.iter().map(|a| a.share).sum();
        if (sum - 1.0).abs() > 1e-6 {
            return self.fail("powertrain.driveline.axles", format!("the shares make {sum}; they must make 1"));
        }
        Ok(())
    }

    fn differential(&self, field: &str, d: Differential) -> Result<(), SimError> {
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
