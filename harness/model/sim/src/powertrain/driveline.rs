//! Shafts, differentials and brakes: the spins of all wheels in one step.
//!
//! An axle's wheels turn at σ ± δ. A differential's box turns at σ, the axle's drive shaft at σ over the final drive,
//! the gearbox' output at Σ Uₐ σₐ with Uₐ = share / final drive: so an open centre differential splits the torque by
//! the shares, as a planetary gear does. In these coordinates the driveline's inertia is diagonal but for one matrix
//! of rank one, c U Uᵀ, from all that turns with the output shaft; its inverse is in closed form (Sherman and
//! Morrison 1950).
//!
//! Clutches of differentials, brakes and the engine's drag are Coulomb friction: each takes the torque that ends
//! its slip within the step, as far as its limit reaches. With the symmetric inertia this is a convex quadratic
//! programme with bounds, solved by projected Gauss–Seidel sweeps in a fixed order (Cryer 1971), which converge from
//! any start and never add energy. Without brakes the constraints of up to two axles don't interact, so that one
//! sweep is exact; with brakes that can hold all wheels the start is already the solution.

use super::Pair;

use vb_vehicle::powertrain::{self, Differential};

const MAX_AXLES: usize = vb_vehicle::MAX_WHEELS / 2;
/// Sweeps end when none of them changes a slip by more than this, rad/s.
const CONVERGED: f64 = 1e-9;
const MAX_SWEEPS: usize = 100;

/// All wheels' spins (rad/s) and what acts on them; the torques are the result.
pub(crate) struct Wheels<'a> {
    pub(crate) spins: &'a mut [f64],
    /// Moments of the tyres about the axles, N m.
    pub(crate) moments: &'a [f64],
    /// Greatest torques of the brakes, N m.
    pub(crate) brakes: &'a [f64],
    /// Torques of driveline and brake together on the wheels, N m.
    pub(crate) torques: &'a mut [f64],
}

/// What acts at the output shaft of the gearbox in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Input {
    /// N m.
    pub(super) torque: f64,
    /// Greatest torque of friction, N m.
    pub(super) friction: f64,
    /// Fall of the torque with speed, N m s.
    pub(super) drag: f64,
    /// kg m².
    pub(super) inertia: f64,
}

#[derive(Clone, Debug)]
struct Axle {
    /// Index of its left wheel; the right one follows.
    left: usize,
    /// Inertia of σ without the output shaft's, kg m², and its inverse.
    inertia: f64,
    ease: f64,
    /// Of one wheel.
    wheel_inertia: f64,
    wheel_ease: f64,
    /// Speed of the drive shaft over σ.
    gain: f64,
    /// Share times gain.
    pull: f64,
    /// Pull over inertia.
    lean: f64,
    differential: Differential,
}

#[derive(Clone, Debug)]
pub(super) struct Driveline {
    axles: Vec<Axle>,
    centre: Differential,
    shaft_inertia: f64,
    wheel_inertias: Vec<f64>,
    driven: Vec<bool>,
}

/// Bound of a differential's clutch with the torque that passes through it, N m.
fn limit(differential: Differential, torque: f64) -> f64 {
    match differential {
        Differential::Open {} => 0.0,
        Differential::Clutch { torque } => torque,
        // Slower over faster output: (T/2 + t) / (T/2 − t) = bias.
        Differential::LimitedSlip { bias, preload } => {
            preload + 0.5 * torque.abs() * (bias - 1.0) / (bias + 1.0)
        }
        Differential::Locked {} => f64::INFINITY,
    }
}

/// Speeds in the driveline's coordinates, and the answer to impulses.
struct Motion<'a> {
    axles: &'a [Axle],
    sum: [f64; MAX_AXLES],
    half: [f64; MAX_AXLES],
    /// c, kg m².
    shaft_inertia: f64,
    /// c / (1 + c Σ U²/A).
    common: f64,
    /// Σ U²/A.
    ease: f64,
    before: Before,
}

/// The state before the step, from which the torques through the differentials are computed.
#[derive(Default)]
struct Before {
    /// 2 I σ of the wheels of each axle, less the impulse of the tyres, N m s.
    momentum: [f64; MAX_AXLES],
    /// Speed of the output shaft, rad/s.
    shaft: f64,
}

impl Motion<'_> {
    /// Answer of σ of axle `a` to a unit impulse on it.
    fn mobility(&self, a: usize) -> f64 {
        let x = &self.axles[a];
        x.ease - self.common * x.lean * x.lean
    }

    /// An impulse on σ of one axle, N m s.
    fn push(&mut self, a: usize, impulse: f64) {
        let shared = self.common * self.axles[a].lean * impulse;
        self.sum[a] += self.axles[a].ease * impulse;
        for (sum, y) in self.sum.iter_mut().zip(self.axles) {
            *sum -= y.lean * shared;
        }
    }

    /// An impulse on the output shaft, N m s.
    fn turn(&mut self, impulse: f64) {
        let left = impulse * (1.0 - self.common * self.ease);
        for (sum, y) in self.sum.iter_mut().zip(self.axles) {
            *sum += y.lean * left;
        }
    }

    fn shaft(&self) -> f64 {
        self.axles.iter().zip(&self.sum).map(|(x, s)| x.pull * s).sum()
    }

    /// Impulse that the differential of axle `a` hands its wheels, without what balances their brakes, N m s. What spins up
    /// its box and shafts isn't in it.
    fn passed(&self, a: usize) -> f64 {
        2.0 * self.axles[a].wheel_inertia * self.sum[a] - self.before.momentum[a]
    }
}

/// Friction's impulse so far.
#[derive(Clone, Copy, Default)]
struct Friction(f64);

impl Friction {
    /// Adds what ends the slip, within the bound; returns what it added, to be taken from the faster side.
    fn hold(&mut self, slip: f64, mobility: f64, bound: f64) -> f64 {
        let before = self.0;
        self.0 = vb_math::clamp(before + slip / mobility, -bound, bound);
        self.0 - before
    }
}

impl Driveline {
    /// The shafts of `d` on these pairs of wheels, of which as many are driven as it has axles.
    pub(super) fn new(d: &powertrain::Driveline, pairs: &[Pair]) -> Self {
        let driven = pairs.iter().enumerate().filter(|(_, pair)| pair.driven);
        let axle = |((i, pair), x): ((usize, &Pair), &powertrain::DrivenAxle)| {
            let gain = 1.0 / x.final_drive;
            let inertia = 2.0 * pair.inertia + x.box_inertia + x.shaft_inertia * gain * gain;
            let pull = x.fraction * gain;
            Axle {
                left: 2 * i,
                inertia,
                ease: 1.0 / inertia,
                wheel_inertia: pair.inertia,
                wheel_ease: 1.0 / pair.inertia,
                gain,
                pull,
                lean: pull / inertia,
                differential: x.differential,
            }
        };
        let axles = driven.zip(&d.axles).map(axle).collect();
        Self {
            axles,
            centre: d.centre,
            shaft_inertia: d.shaft_inertia,
            wheel_inertias: pairs.iter().flat_map(|pair| [pair.inertia; 2]).collect(),
            driven: pairs.iter().flat_map(|pair| [pair.driven; 2]).collect(),
        }
    }

    /// Speed of the gearbox' output shaft, rad/s.
    pub(super) fn shaft_speed(&self, spins: &[f64]) -> f64 {
        self.axles.iter().map(|x| x.pull * 0.5 * (spins[x.left] + spins[x.left + 1])).sum()
    }

    /// Energy of all that turns with the wheels, up to the gearbox' output shaft, J.
    pub(super) fn energy(&self, spin: impl Fn(usize) -> f64) -> f64 {
        let (mut energy, mut shaft) = (0.0, 0.0);
        for x in &self.axles {
            let (left, right) = (spin(x.left), spin(x.left + 1));
            let (sum, half) = (0.5 * (left + right), 0.5 * (left - right));
            energy += 0.5 * x.inertia * sum * sum + x.wheel_inertia * half * half;
            shaft += x.pull * sum;
        }
        for (i, inertia) in self.wheel_inertias.iter().enumerate().filter(|(i, _)| !self.driven[*i]) {
            energy += 0.5 * inertia * spin(i) * spin(i);
        }
        energy + 0.5 * self.shaft_inertia * shaft * shaft
    }

    /// Speed of the output shaft over the spin of wheels that all turn alike.
    pub(super) fn reduction(&self) -> f64 {
        self.axles.iter().map(|x| x.pull).sum()
    }

    /// Advances the spins by `dt`; returns the friction's torque at the output shaft, N m.
    pub(super) fn advance(&self, input: Input, wheels: &mut Wheels<'_>, dt: f64) -> f64 {
        let mut m = self.free(&input, wheels, dt);
        let drag = self.friction(&mut m, &input, wheels.brakes, dt);
        for (i, spin) in wheels.spins.iter_mut().enumerate().filter(|(i, _)| !self.driven[*i]) {
            let momentum = *spin * self.wheel_inertias[i] + dt * wheels.moments[i];
            let held = vb_math::clamp(momentum, -dt * wheels.brakes[i], dt * wheels.brakes[i]);
            wheels.torques[i] = -held / dt;
            *spin = (momentum - held) / self.wheel_inertias[i];
        }
        for (a, x) in self.axles.iter().enumerate() {
            for (i, after) in [(x.left, m.sum[a] + m.half[a]), (x.left + 1, m.sum[a] - m.half[a])] {
                let gained = x.wheel_inertia * (after - wheels.spins[i]) / dt;
                wheels.torques[i] = gained - wheels.moments[i];
                wheels.spins[i] = after;
            }
        }
        drag / dt
    }

    /// The motion that there would be without friction.
    fn free(&self, input: &Input, wheels: &Wheels<'_>, dt: f64) -> Motion<'_> {
        let c = self.shaft_inertia + input.inertia + dt * input.drag;
        let ease: f64 = self.axles.iter().map(|x| x.pull * x.lean).sum();
        let mut m = Motion {
            axles: &self.axles,
            sum: [0.0; MAX_AXLES],
            half: [0.0; MAX_AXLES],
            shaft_inertia: c,
            common: c / (1.0 + c * ease),
            ease,
            before: Before::default(),
        };
        let mut gained = [0.0; MAX_AXLES];
        let mut shaft = 0.0;
        for (a, x) in self.axles.iter().enumerate() {
            let (l, r) = (x.left, x.left + 1);
            m.sum[a] = 0.5 * (wheels.spins[l] + wheels.spins[r]);
            m.half[a] = 0.5 * (wheels.spins[l] - wheels.spins[r]);
            m.half[a] += 0.5 * dt * (wheels.moments[l] - wheels.moments[r]) * x.wheel_ease;
            let tyres = dt * (wheels.moments[l] + wheels.moments[r]);
            m.before.momentum[a] = 2.0 * x.wheel_inertia * m.sum[a] + tyres;
            m.before.shaft += x.pull * m.sum[a];
            let impulse = tyres + dt * input.torque * x.pull;
            gained[a] = impulse * x.ease;
            shaft += x.pull * gained[a];
        }
        for (a, x) in self.axles.iter().enumerate() {
            m.sum[a] += gained[a] - x.lean * m.common * shaft;
        }
        m
    }

    /// Lets clutches, brakes and the engine's drag act on the motion; returns the impulse of the last, N m s.
    fn friction(&self, m: &mut Motion<'_>, input: &Input, brakes: &[f64], dt: f64) -> f64 {
        let mut engine = Friction::default();
        let mut centre = [Friction::default(); MAX_AXLES];
        let mut axle = [Friction::default(); MAX_AXLES];
        let mut brake = [Friction::default(); 2 * MAX_AXLES];
        let braking = brakes.iter().any(|&b| b > 0.0);
        if braking {
            self.brake_all(m, input, brakes, &mut brake, dt);
        }
        for _ in 0..MAX_SWEEPS {
            let mut change: f64 = 0.0;
            if input.friction > 0.0 {
                let mobility = m.ease * (1.0 - m.common * m.ease);
                let p = engine.hold(m.shaft(), mobility, dt * input.friction);
                m.turn(-p);
                change = change.max(p.abs() * mobility);
            }
            for (a, pair) in self.axles.windows(2).enumerate() {
                let turned = m.shaft_inertia * (m.shaft() - m.before.shaft);
                let torque = input.torque - (engine.0 + turned) / dt;
                let through = torque * (pair[0].pull / pair[0].gain + pair[1].pull / pair[1].gain);
                let bound = dt * limit(self.centre, through);
                // An open centre; or, in a state that has diverged, a bound that isn't a number.
                if bound.is_nan() || bound <= 0.0 {
                    continue;
                }
                let (e, f) = (pair[0].gain, pair[1].gain);
                let lean = e * pair[0].lean - f * pair[1].lean;
                let mobility = e * e * pair[0].ease + f * f * pair[1].ease - m.common * lean * lean;
                let p = centre[a].hold(m.sum[a] * e - m.sum[a + 1] * f, mobility, bound);
                m.push(a, -p * e);
                m.push(a + 1, p * f);
                change = change.max(p.abs() * mobility);
            }
            for (a, x) in self.axles.iter().enumerate() {
                let through = (m.passed(a) + brake[2 * a].0 + brake[2 * a + 1].0) / dt;
                let bound = dt * limit(x.differential, through);
                if bound > 0.0 {
                    let p = axle[a].hold(2.0 * m.half[a], 2.0 * x.wheel_ease, bound);
                    m.half[a] -= p * x.wheel_ease;
                    change = change.max(p.abs() * 2.0 * x.wheel_ease);
                }
                for (side, sign) in [(0, 1.0), (1, -1.0)] {
                    let bound = dt * brakes[x.left + side];
                    if bound > 0.0 {
                        let mobility = m.mobility(a) + 0.5 * x.wheel_ease;
                        let p = brake[2 * a + side].hold(m.sum[a] + sign * m.half[a], mobility, bound);
                        m.push(a, -p);
                        m.half[a] -= sign * p * 0.5 * x.wheel_ease;
                        change = change.max(p.abs() * mobility);
                    }
                }
            }
            // Nothing interacts: the first sweep is exact.
            let by_torque = matches!(self.centre, Differential::LimitedSlip { .. });
            let alone = !braking && self.axles.len() <= 2 && input.friction <= 0.0 && !by_torque;
            if change < CONVERGED || alone {
                break;
            }
        }
        engine.0
    }

    /// Lets each brake take the impulse that ends all motion, within its bound: if all can, nothing is left to do;
    /// else it is a start from which the sweeps go on.
    fn brake_all(&self, m: &mut Motion<'_>, input: &Input, brakes: &[f64], brake: &mut [Friction], dt: f64) {
        let common = (self.shaft_inertia + input.inertia + dt * input.drag) * m.shaft();
        let mut pushed = [0.0; MAX_AXLES];
        for (a, x) in self.axles.iter().enumerate() {
            let both = x.inertia * m.sum[a] + x.pull * common;
            let across = 2.0 * x.wheel_inertia * m.half[a];
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let bound = dt * brakes[x.left + side];
                let p = vb_math::clamp(0.5 * (both + sign * across), -bound, bound);
                brake[2 * a + side].0 = p;
                m.half[a] -= sign * p * 0.5 * x.wheel_ease;
                pushed[a] += p;
            }
        }
        for (a, p) in pushed.into_iter().enumerate().take(self.axles.len()) {
            m.push(a, -p);
        }
    }
}
