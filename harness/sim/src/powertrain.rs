//! Engine, gearbox, driveline: torque at the wheels from throttle and wheel speeds.

use crate::spec::{Engine, Powertrain, VehicleSpec};

/// Piecewise linear, constant beyond the ends.
fn interpolate(points: &[[f64; 2]], x: f64) -> f64 {
    let k = points.partition_point(|p| p[0] <= x);
    if k == 0 {
        return points[0][1];
    }
    if k == points.len() {
        return points[k - 1][1];
    }
    let ([x0, y0], [x1, y1]) = (points[k - 1], points[k]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

impl Engine {
    /// Torque at an engine speed (rad/s) and a throttle in [0, 1], N m: linear between the two maps.
    #[must_use]
    pub fn torque(&self, speed: f64, throttle: f64) -> f64 {
        let (closed, full) =
            (interpolate(&self.closed_throttle, speed), interpolate(&self.full_throttle, speed));
        closed + (full - closed) * throttle
    }
}

/// The driveline's state and the wheels it drives.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    spec: Powertrain,
    gear: usize,
    /// Index of the left wheel and clutch torque of each driven axle; the right wheel follows.
    axles: Vec<(usize, f64)>,
    /// Share of the shaft's inertia that each driven wheel carries in common motion, kg m².
    pub(crate) common_inertia: f64,
    /// Drive torque of each wheel in this step, N m.
    torque: Vec<f64>,
    spin_inertia: Vec<f64>,
}

impl Drive {
    pub(crate) fn new(v: &VehicleSpec) -> Self {
        let d = v.powertrain.differentials;
        let half = v.axles.len().div_ceil(2);
        let axles: Vec<_> = v
            .axles
            .iter()
            .enumerate()
            .filter(|(_, a)| a.driven)
            .map(|(i, _)| (2 * i, if i < half { d.front } else { d.rear }))
            .collect();
        let wheels = 2 * axles.len();
        let fd = v.powertrain.final_drive;
        Self {
            common_inertia: v.powertrain.shaft_inertia / (fd * fd * wheels as f64),
            spec: v.powertrain.clone(),
            gear: 0,
            axles,
            torque: vec![0.0; 2 * v.axles.len()],
            spin_inertia: v.axles.iter().flat_map(|a| [a.spin_inertia; 2]).collect(),
        }
    }

    pub(crate) fn gear(&self) -> usize {
        self.gear
    }

    pub(crate) fn is_driven(&self, wheel: usize) -> bool {
        self.axles.iter().any(|&(left, _)| left / 2 == wheel / 2)
    }

    /// Drive torque of every wheel, N m, from the wheels' spins (rad/s). Shifts the gearbox.
    pub(crate) fn torques(&mut self, spins: &[f64], throttle: f64, dt: f64) -> &[f64] {
        let g = &self.spec.gearbox;
        let count = 2.0 * self.axles.len() as f64;
        let mean = self.axles.iter().map(|&(l, _)| spins[l] + spins[l + 1]).sum::<f64>() / count;
        let shaft = mean / self.spec.final_drive;
        let ratio = g.ratios[self.gear];
        let engine = shaft.abs() / ratio;
        let torque = self.spec.engine.torque(engine, throttle);
        // Engine drag opposes the motion either way; engine drive pushes forward.
        let signed = if torque < 0.0 { torque * shaft.signum() } else { torque };
        let each = signed / ratio / self.spec.final_drive / count;
        if engine > g.shift_up[self.gear] && self.gear + 1 < g.ratios.len() {
            self.gear += 1;
        } else if engine < g.shift_down[self.gear] && self.gear > 0 {
            self.gear -= 1;
        }
        self.torque.fill(0.0);
        for &(left, limit) in &self.axles {
            let slower = clutch(spins[left] - spins[left + 1], self.spin_inertia[left] / 2.0, limit, dt);
            self.torque[left] = each - slower;
            self.torque[left + 1] = each + slower;
        }
        // Between neighbouring axles: the centre clutch acts on drive shafts, at shaft speed and torque.
        let fd = self.spec.final_drive;
        for pair in self.axles.windows(2) {
            let (a, b) = (pair[0].0, pair[1].0);
            let difference = 0.5 * (spins[a] + spins[a + 1] - spins[b] - spins[b + 1]) / fd;
            let inertia = (self.spin_inertia[a] + self.spin_inertia[b]) * 0.5 * fd * fd;
            let t = clutch(difference, inertia, self.spec.differentials.centre, dt) / fd / 2.0;
            for k in 0..2 {
                self.torque[a + k] -= t;
                self.torque[b + k] += t;
            }
        }
        &self.torque
    }
}

/// Torque of a clutch that works against a difference in speed: enough to end it within a few steps, up to the limit.
fn clutch(difference: f64, inertia: f64, limit: f64, dt: f64) -> f64 {
    (0.25 * inertia * difference / dt).clamp(-limit, limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hmmwv() -> VehicleSpec {
        VehicleSpec::parse(include_str!("../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").unwrap()
    }

    #[test]
    fn full_throttle_at_peak_gives_the_torque_of_the_map_through_the_ratios() {
        // Reference sheet: 1300.2 N m / 0.1708 / 0.2 = 38 062 N m at all wheels in first gear.
        let v = hmmwv();
        let mut d = Drive::new(&v);
        let spin = 150.0 * 0.1708 * 0.2;
        let total: f64 = d.torques(&[spin; 4], 1.0, 1e-3).iter().sum();
        assert!((total - 38_062.06).abs() < 0.1, "{total}");
    }

    #[test]
    fn a_closed_throttle_never_drives_and_does_nothing_at_rest() {
        let mut d = Drive::new(&hmmwv());
        assert!(d.torques(&[0.0; 4], 0.0, 1e-3).iter().all(|&t| t == 0.0));
        assert!(d.torques(&[5.0; 4], 0.0, 1e-3).iter().all(|&t| t < 0.0));
        assert!(d.torques(&[-5.0; 4], 0.0, 1e-3).iter().all(|&t| t > 0.0));
    }

    #[test]
    fn an_open_differential_splits_evenly_and_a_clutch_helps_the_slower_wheel_up_to_its_limit() {
        let mut v = hmmwv();
        v.powertrain.differentials = crate::Differentials { front: 0.0, rear: 0.0, centre: 0.0 };
        let spins = [9.0, 3.0, 4.0, 4.0];
        let t = Drive::new(&v).torques(&spins, 0.5, 1e-3).to_vec();
        assert!(t.iter().all(|x| (x - t[0]).abs() < 1e-9), "{t:?}");
        v.powertrain.differentials.front = 700.0;
        let t = Drive::new(&v).torques(&spins, 0.5, 1e-3).to_vec();
        assert!((t[1] - t[0] - 1400.0).abs() < 1e-9 && (t[2] - t[3]).abs() < 1e-9, "{t:?}");
    }

    #[test]
    fn the_gearbox_shifts_up_above_and_down_below_its_bands() {
        let mut d = Drive::new(&hmmwv());
        let spin =
            |engine: f64, gear: usize, d: &Drive| engine * d.spec.gearbox.ratios[gear] * d.spec.final_drive;
        let w = spin(240.0, 0, &d);
        d.torques(&[w; 4], 1.0, 1e-3);
        assert_eq!(d.gear(), 1);
        d.torques(&[w; 4], 1.0, 1e-3);
        assert_eq!(d.gear(), 1, "147 rad/s in second lies within its band");
        let w = spin(100.0, 1, &d);
        d.torques(&[w; 4], 0.0, 1e-3);
        assert_eq!(d.gear(), 0);
    }
}
