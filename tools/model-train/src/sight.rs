//! What of the ground the networks see, while they are trained: the same sums as [`hybrid::Sight`] has, on tensors.

use candle_core::{Device, Result, Tensor};
use hybrid::{CHANNELS, PATCH, PLACES, SEEN, TOLD, heading, heading_of, place};
use vb_sdk::mppi::{LANES, Lanes};

use crate::data::{Data, Window};
use crate::network::Dense;
use crate::repeatable::{column, numbers, widen};

/// Hidden values of the networks.
const GROUND: usize = 64;
const QUERY: usize = 12;

/// A way to look at the ground.
pub enum Sight {
    /// The patch about the vehicle.
    Patch(Dense),
    /// The same, and those at places that it may come to.
    Attention(Attention),
}

pub struct Attention {
    ground: Dense,
    query: Dense,
    key: Dense,
}

pub struct Ground {
    /// Roll and pitch of the plane through the wheels.
    pub plane: [Tensor; 2],
    /// The patches at the vehicle's own place and, if they are looked at, at the others.
    patches: Vec<Tensor>,
}

impl Sight {
    /// Patches, of which nothing is known yet.
    pub fn patch(seed: u64) -> Result<Self> {
        Ok(Self::Patch(Dense::new("ground", &[PATCH, GROUND, CHANNELS], seed)?))
    }

    /// Attention, of which nothing is known yet.
    pub fn attention(seed: u64) -> Result<Self> {
        Ok(Self::Attention(Attention {
            ground: Dense::new("ground", &[PATCH, GROUND, CHANNELS], seed)?,
            query: Dense::new("query", &[TOLD, QUERY, PLACES.len()], seed)?,
            key: Dense::new("key", &[CHANNELS, 1], seed)?,
        }))
    }

    /// The name by which weights say how they look at the ground.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Patch(_) => "patch",
            Self::Attention(_) => "attention",
        }
    }

    /// Numbers that are seen.
    #[must_use]
    pub fn seen(&self) -> usize {
        match self {
            Self::Patch(_) => CHANNELS,
            Self::Attention(_) => SEEN,
        }
    }

    #[must_use]
    pub fn networks(&self) -> Vec<&Dense> {
        match self {
            Self::Patch(ground) => vec![ground],
            Self::Attention(a) => vec![&a.ground, &a.query, &a.key],
        }
    }

    /// How many of [`PLACES`] are looked at.
    fn places(&self) -> usize {
        match self {
            Self::Patch(_) => 1,
            Self::Attention(_) => PLACES.len(),
        }
    }

    /// What vehicles see that are told this of themselves.
    pub fn see(&self, told: &Tensor, ground: &Ground) -> Result<Tensor> {
        match self {
            Self::Patch(network) => network.forward(&ground.patches[0]),
            Self::Attention(a) => a.see(told, ground),
        }
    }
}

impl Attention {
    fn see(&self, told: &Tensor, ground: &Ground) -> Result<Tensor> {
        let asked = self.query.forward(told)?;
        // All places at once, one after the other.
        let there = self.ground.forward(&Tensor::cat(&ground.patches, 0)?)?;
        let z = (Tensor::cat(
            &(0..PLACES.len()).map(|k| asked.narrow(1, k, 1)).collect::<Result<Vec<_>>>()?,
            0,
        )? + self.key.forward(&there)?)?;
        let weights = ((&z * 0.5)? + ((z.sqr()? * 0.25)? + 1.0)?.sqrt()?)?;
        let values = (&there * widen(&weights, CHANNELS)?)?;
        let rows = told.dim(0)?;
        let of = |all: &Tensor, k: usize| all.narrow(0, k * rows, rows);
        let (mut sum, mut total) = (of(&values, 0)?, of(&weights, 0)?);
        for k in 1..PLACES.len() {
            (sum, total) = ((sum + of(&values, k)?)?, (total + of(&weights, k)?)?);
        }
        Tensor::cat(&[of(&there, 0)?, (sum / widen(&total, CHANNELS)?)?], 1)
    }
}

/// Rows of values that come eight at a time.
struct Rows {
    width: usize,
    values: Vec<f32>,
}

impl Rows {
    fn new(rows: usize, width: usize) -> Self {
        Self { width, values: vec![0.0; rows * width] }
    }

    fn put(&mut self, first: usize, own: &[Lanes]) {
        for l in 0..LANES {
            for (k, values) in own.iter().enumerate() {
                self.values[(first + l) * self.width + k] = values[l];
            }
        }
    }

    fn tensor(self) -> Result<Tensor> {
        let rows = self.values.len() / self.width;
        Tensor::from_vec(self.values, (rows, self.width), &Device::Cpu)
    }
}

impl Ground {
    /// The ground under windows' vehicles at these x, y and yaw: the plane, and what a way to look is shown. It is computed eight at a
    /// time, each eight in one world.
    pub fn look(sight: Option<&Sight>, data: &Data, windows: &[&Window], at: [&Tensor; 3]) -> Result<Self> {
        let [x, y, yaw] = [numbers(at[0])?, numbers(at[1])?, numbers(at[2])?];
        let n = windows.len();
        let (mut bank, mut rise) = (vec![0.0; n], vec![0.0; n]);
        let places = sight.map_or(0, Sight::places);
        let mut patches: Vec<Rows> = (0..places).map(|_| Rows::new(n, PATCH)).collect();
        let mut patch = [[0.0; LANES]; PATCH];
        for first in (0..n).step_by(LANES) {
            let terrain = &data.places[windows[first].place].terrain;
            let of = |v: &[f32]| -> Lanes { std::array::from_fn(|l| v[first + l]) };
            let (px, py) = (of(&x), of(&y));
            let angles: [(f64, f64); LANES] = of(&yaw).map(|a| vb_math::sin_cos(f64::from(a)));
            let (cos, sin) = (angles.map(|a| a.1 as f32), angles.map(|a| a.0 as f32));
            let plane = terrain.plane([&px, &py], [&cos, &sin]);
            bank[first..first + LANES].copy_from_slice(&plane[1]);
            rise[first..first + LANES].copy_from_slice(&plane[2]);
            // Planners have patches at some headings only.
            let headings: [[f32; 2]; LANES] = std::array::from_fn(|l| heading(heading_of(cos[l], sin[l])));
            let (near_cos, near_sin) = (headings.map(|h| h[0]), headings.map(|h| h[1]));
            for (k, rows) in patches.iter_mut().enumerate() {
                let [x, y] = place(k, [&px, &py], [&cos, &sin], terrain.size().0);
                terrain.patch([&x, &y], [&near_cos, &near_sin], &mut patch);
                rows.put(first, &patch);
            }
        }
        Ok(Self {
            plane: [column(bank)?, column(rise)?],
            patches: patches.into_iter().map(Rows::tensor).collect::<Result<_>>()?,
        })
    }
}
