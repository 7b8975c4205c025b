//! A sampling planner with a small network as the vehicle model, as a template and for benchmarks: 1000 rollouts of 20
//! steps each through a network of 6-64-64-6 units (`cargo bench -p vb-host --bench planners`).
//!
//! It uses model predictive path integral control (Williams et al., "Information theoretic MPC for model-based
//! reinforcement learning", ICRA 2017). A kinematic bicycle predicts the motion, and the network a correction.
//! The network is untrained: its weights are random and its correction is small.
//!
//! It is fast in deterministic WASM because all arithmetic is on blocks of samples in arrays of fixed size, which the
//! compiler vectorises, the inner loops call no library functions, and the network uses 16-bit integers
//! (`vb_sdk::nn::FixedNetwork`).

use std::cell::RefCell;

use vb_sdk::nn::{FixedNetwork, FixedScratch, LANES, Lanes, Layer, Network, Pair, Scratch, from_fixed};
use vb_sdk::path::{Follower, Path};
use vb_sdk::rng::Rng;
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, Observation, Planner, PlannerError, Task, Vehicle, math};

vb_sdk::export_planner! {
    planner: Rollouts,
    name: "rollouts",
    about: "MPPI with a small untrained network, for benchmarks",
    control_period: 0.1,
    params: {
        arithmetic: "fixed" => "arithmetic of the network: fixed (16-bit integers) or float",
        samples: 1000 => "rollouts per control period; a multiple of 8",
        horizon: 20 => "steps per rollout, 0.1 s each",
        speed: 4.0 => "target speed, m/s",
        spread: 0.3 => "standard deviation of sampled steering, fraction of full lock",
        temperature: 0.1 => "temperature, in units of the mean cost above the minimum",
    }
}

/// Step length of rollouts, s.
const STEP: f32 = 0.1;
/// Weight of the network's output in the motion.
const SHARE: f32 = 0.01;
/// Look-ahead distance of the point that rollouts approach, m at full scale.
const AHEAD: f64 = 8.0;

/// Inputs, outputs and hidden units of the network.
const WIDTH: usize = 6;
const HIDDEN: usize = 64;

/// The correction of the bicycle's motion.
enum Model {
    Float(Network, RefCell<Scratch>),
    Fixed(FixedNetwork, RefCell<FixedScratch>),
}

impl Model {
    fn forward(&self, input: &[Lanes; WIDTH]) -> [Lanes; WIDTH] {
        match self {
            Self::Float(network, scratch) => {
                let mut output = [[0.0; LANES]; WIDTH];
                network.run(input, &mut output, &mut scratch.borrow_mut());
                output
            }
            Self::Fixed(network, scratch) => {
                let (mut pairs, mut output) = ([Pair::default(); WIDTH / 2], [[0; LANES]; WIDTH]);
                Pair::fill(&mut pairs, input);
                network.run(&pairs, &mut output, &mut scratch.borrow_mut());
                output.map(|values| values.map(from_fixed))
            }
        }
    }
}

/// A layer with random weights of variance 2 / inputs (He et al. 2015, *Delving deep into rectifiers*, eq. 10).
fn layer(inputs: usize, outputs: usize, rng: &mut Rng) -> Layer {
    let spread = (6.0 / inputs as f64).sqrt();
    let mut weight = || rng.uniform(-spread, spread) as f32;
    let weights = (0..inputs * outputs).map(|_| weight()).collect();
    let bias = (0..outputs).map(|_| 0.1 * weight()).collect();
    Layer::dense("", inputs, weights, bias)
}

struct Rollouts {
    vehicle: Vehicle,
    follower: Follower,
    model: Model,
    rng: Rng,
    blocks: usize,
    speed: f64,
    spread: f64,
    temperature: f64,
    /// Mean steering of every step of the horizon.
    plan: Vec<f32>,
    /// Sampled steering, by block, step and sample.
    noise: Vec<Lanes>,
}

impl Planner for Rollouts {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let samples: usize = task.param_as("samples")?;
        let horizon: usize = task.param_as("horizon")?;
        if samples == 0 || !samples.is_multiple_of(LANES) || horizon == 0 {
            return Err(PlannerError::new(format!("want samples in multiples of {LANES} and a horizon")));
        }
        let blocks = samples / LANES;
        let mut rng = Rng::new(task.seed);
        let layers = [(WIDTH, HIDDEN), (HIDDEN, HIDDEN), (HIDDEN, WIDTH)].map(|(i, o)| layer(i, o, &mut rng));
        let unfit = || PlannerError::new("the network does not match");
        let network = Network::new(layers.into()).ok_or_else(unfit)?;
        let model = match task.param_as::<String>("arithmetic")?.as_str() {
            "float" => Model::Float(network, RefCell::default()),
            "fixed" => Model::Fixed(network.fixed(&[WIDTH]).ok_or_else(unfit)?, RefCell::default()),
            other => return Err(PlannerError::new(format!("arithmetic is `{other}`; want fixed or float"))),
        };
        Ok(Self {
            vehicle: task.vehicle.clone(),
            follower: Follower::new(Path::new(&task.path)?, 2.0 * AHEAD * task.vehicle.scale),
            model,
            rng,
            blocks,
            speed: task.param_f64("speed")?,
            spread: task.param_f64("spread")?,
            temperature: task.param_f64("temperature")?,
            plan: vec![0.0; horizon],
            noise: vec![[0.0; LANES]; blocks * horizon],
        })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let pose = o.pose()?;
        self.follower.update(pose.position.x, pose.position.y);
        let goal = self.follower.look_ahead(AHEAD * self.vehicle.scale);
        let (sin, cos) = (math::sin(pose.yaw), math::cos(pose.yaw));
        let (dx, dy) = (goal.x - pose.position.x, goal.y - pose.position.y);
        // In the vehicle's frame.
        let goal = [(cos * dx + sin * dy) as f32, (cos * dy - sin * dx) as f32];
        self.sample();
        let horizon = self.plan.len();
        let mut costs = Vec::with_capacity(self.blocks * LANES);
        for block in 0..self.blocks {
            let noise = &self.noise[block * horizon..(block + 1) * horizon];
            costs.extend(self.roll_out(noise, pose.linear_velocity.x as f32, goal));
        }
        self.update(&costs);
        let steering = f64::from(self.plan[0]);
        // The next step begins where this one ends.
        self.plan.rotate_left(1);
        if let [.., before, last] = &mut self.plan[..] {
            *last = *before;
        }
        let (throttle, brake) =
            SpeedController::new(1.0, 0.0).update(self.speed, pose.linear_velocity.x, 0.1);
        Ok(Command { steering, throttle, brake, ..Command::default() })
    }
}

impl Rollouts {
    /// Samples the steering of all rollouts around the plan.
    fn sample(&mut self) {
        for block in self.noise.chunks_exact_mut(self.plan.len()) {
            for (samples, mean) in block.iter_mut().zip(&self.plan) {
                for sample in samples {
                    // The sum of three uniform numbers is approximately normal, without a logarithm; its variance is 1.
                    let sum: f64 = (0..3).map(|_| self.rng.uniform(-1.0, 1.0)).sum();
                    *sample = (mean + (self.spread * sum) as f32).clamp(-1.0, 1.0);
                }
            }
        }
    }

    /// Costs of a block of rollouts: squared distances from the goal, over the horizon.
    fn roll_out(&self, steering: &[Lanes], speed: f32, goal: [f32; 2]) -> Lanes {
        let turn = (self.vehicle.max_steer_angle / self.vehicle.wheelbase) as f32;
        let target = self.speed as f32;
        let (mut x, mut y, mut along, mut across) = ([0.0; LANES], [0.0; LANES], [1.0; LANES], [0.0; LANES]);
        let mut v = [speed; LANES];
        let mut rate = [0.0; LANES];
        let mut cost = [0.0; LANES];
        for command in steering {
            let change = self.model.forward(&[*command, v, rate, along, across, [1.0; LANES]]);
            for k in 0..LANES {
                rate[k] = v[k] * turn * command[k] + SHARE * change[0][k];
                // The heading as a vector, rotated by a small angle and normalised by one Newton step.
                let angle = rate[k] * STEP;
                let (a, b) = (along[k] - angle * across[k], across[k] + angle * along[k]);
                let length = 1.5 - 0.5 * (a * a + b * b);
                (along[k], across[k]) = (a * length, b * length);
                v[k] += (0.5 * (target - v[k]) + SHARE * change[1][k]) * STEP;
                x[k] += (v[k] * along[k] + SHARE * change[2][k]) * STEP;
                y[k] += (v[k] * across[k] + SHARE * change[3][k]) * STEP;
                let (ex, ey) = (x[k] - goal[0], y[k] - goal[1]);
                cost[k] += ex * ex + ey * ey;
            }
        }
        cost
    }

    /// Moves the plan to the mean of the samples, weighted by their costs.
    fn update(&mut self, costs: &[f32]) {
        let least = costs.iter().copied().fold(f32::INFINITY, f32::min);
        let mean = costs.iter().map(|c| f64::from(c - least)).sum::<f64>() / costs.len() as f64;
        let scale = 1.0 / (self.temperature * mean).max(1e-9);
        let weights: Vec<f32> =
            costs.iter().map(|c| math::exp(-f64::from(c - least) * scale) as f32).collect();
        let total: f32 = weights.iter().sum();
        let horizon = self.plan.len();
        for (i, mean) in self.plan.iter_mut().enumerate() {
            let mut sum = 0.0;
            for (block, weights) in weights.chunks_exact(LANES).enumerate() {
                let samples = &self.noise[block * horizon + i];
                sum += weights.iter().zip(samples).map(|(w, s)| w * s).sum::<f32>();
            }
            *mean = sum / total;
        }
    }
}
