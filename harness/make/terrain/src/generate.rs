//! Surfaces drawn from a model: any size, any resolution, no seams.
//!
//! The plane is covered by cells of the latent field, each with its own random stream, named by seed and place. The
//! decoder makes each sample from the cells about it, so a surface is a window on an endless terrain: a wider one with the
//! same seed holds the narrower one, bit for bit. What is longer than the decoder reaches, the swells, are smooth random fields
//! beside it; and the cells' lattice is warped by another. At last, octaves and steepness take the scans' distributions.

use std::sync::atomic::{AtomicUsize, Ordering};

use thiserror::Error;
use vb_math::rng::Stream;
use vb_world::{Elevation, Heightfield};

use crate::bands::{Plane, REACH};
use crate::model::Model;
use crate::shape::{CELL, CHANNELS, HALO, NUMBERS, SWELLS};
use crate::shaping::{self, Shaping};

/// Cells along a block that is decoded at a time.
const CHUNK: usize = 8;
/// Samples from one node of the warp to the next, its standard deviation in samples along rows and columns, and its bound. A
/// standard deviation of 2.5/8 of a cell takes away 85 % of a pattern with the cells' period (1 − exp(−(2π·2.5/8)²/2)), and more
/// of shorter ones.
const WARP: usize = 48;
const WARP_STD: f64 = 2.5;
const WARP_REACH: i64 = 12;
/// Most samples of the decoder that one surface may take.
const MAX_SAMPLES: f64 = (1u64 << 27) as f64;
/// Least and largest number of nodes along a side.
const NODES: [usize; 2] = [2, 8193];
/// Finest resolution as a share of the model's own.
const FINEST: f64 = 1.0 / 64.0;

/// Share of the full relief for each level: 30, 60 and 100 %.
#[must_use]
pub fn fraction(level: Elevation) -> f64 {
    match level {
        Elevation::Low => 0.3,
        Elevation::Medium => 0.6,
        Elevation::High => 1.0,
    }
}

/// Which surface to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Names the terrain.
    pub seed: u64,
    /// Nodes south to north.
    pub rows: usize,
    /// Nodes west to east.
    pub cols: usize,
    /// Distance between nodes, m.
    pub resolution: f64,
    /// Share of the model's full relief.
    pub fraction: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum GenerateError {
    #[error("{0} nodes along a side: must be {min} to {max}", min = NODES[0], max = NODES[1])]
    Nodes(usize),
    #[error("a resolution of {resolution} m: must be at least {least} m, because the model has {own} m")]
    Resolution {
        /// The resolution asked for, m.
        resolution: f64,
        /// The finest, m.
        least: f64,
        /// The model's, m.
        own: f64,
    },
    #[error("a side of {extent_m} m at the model's resolution of {own} m has too many samples: reduce it")]
    Extent {
        /// The longer side, m.
        extent_m: f64,
        /// The model's resolution, m.
        own: f64,
    },
    #[error("a relief fraction of {0}: must be above 0 and at most 100")]
    Share(f64),
}

impl Model {
    /// Draws a surface about the origin. The same model and request give the same bits on any machine.
    ///
    /// Nodes at the model's own resolution are its samples; those between samples are interpolated by a cubic kernel (Keys 1981). A node's
    /// height is that of the ground at its place, whatever the resolution: nothing is averaged where the resolution is coarser, since that
    /// would flatten ledges, so a coarser surface holds every so many-th node of a finer one. Heights have mean 0 and the
    /// model's standard deviation times the share, over many surfaces.
    pub fn surface(&self, request: &Request) -> Result<Heightfield, GenerateError> {
        self.shaped(request, None)
    }

    /// Draws a surface whose wavelengths are shaped before nodes are taken. Heights have the standard deviation of the shaping
    /// times the fraction, over many surfaces.
    pub fn shaped(&self, request: &Request, shaping: Option<&Shaping>) -> Result<Heightfield, GenerateError> {
        let own = self.header.resolution;
        for n in [request.rows, request.cols] {
            if !(NODES[0]..=NODES[1]).contains(&n) {
                return Err(GenerateError::Nodes(n));
            }
        }
        if !(request.resolution.is_finite() && request.resolution >= own * FINEST) {
            return Err(GenerateError::Resolution {
                resolution: request.resolution,
                least: own * FINEST,
                own,
            });
        }
        if !(request.fraction > 0.0 && request.fraction <= 100.0) {
            return Err(GenerateError::Share(request.fraction));
        }
        let extent = |n: usize| (n - 1) as f64 * request.resolution / own + 4.0;
        if extent(request.rows) * extent(request.cols) > MAX_SAMPLES {
            let extent_m = (request.rows.max(request.cols) - 1) as f64 * request.resolution;
            return Err(GenerateError::Extent { extent_m, own });
        }
        let rows = taps(request.rows, request.resolution / own);
        let cols = taps(request.cols, request.resolution / own);
        let field = match shaping {
            None => self.field(request.seed, span(&rows), span(&cols)),
            Some(shaping) => self.shaped_field(request.seed, span(&rows), span(&cols), shaping),
        };
        let values = field.resampled(&rows, &cols);
        let scale = self.header.relief * request.fraction / self.header.std;
        let heights = values.into_iter().map(|v| (v - self.header.mean) * scale).collect();
        Ok(Heightfield::new(request.rows, request.cols, request.resolution, heights))
    }

    /// The samples whose row and column numbers lie in these spans (first, one after the last).
    fn field(&self, seed: u64, rows: [i64; 2], cols: [i64; 2]) -> Field {
        let wider = |span: [i64; 2], by: i64| [span[0] - by, span[1] + by];
        let reach = (REACH * self.passes.len()) as i64;
        let raw = self.raw(seed, wider(rows, reach), wider(cols, reach));
        let mut plane = Plane { cols: (raw.cols[1] - raw.cols[0]) as usize, values: raw.values };
        for pass in &self.passes {
            plane = plane.mapped(pass);
        }
        Field { rows, cols, values: plane.values }
    }

    /// A metre of height at full relief, in the decoder's unit.
    #[must_use]
    pub fn metre(&self) -> f64 {
        self.header.std / self.header.relief
    }

    /// The same after gains and curve, with swells.
    fn shaped_field(&self, seed: u64, rows: [i64; 2], cols: [i64; 2], shaping: &Shaping) -> Field {
        let reach = shaping::REACH as i64;
        let wider = |span: [i64; 2]| [span[0] - reach, span[1] + reach];
        self.shaped_again(&self.field(seed, wider(rows), wider(cols)), seed, shaping)
    }

    /// Samples after gains and curve, with swells: narrower by what the gains reach.
    fn shaped_again(&self, whole: &Field, seed: u64, shaping: &Shaping) -> Field {
        let reach = shaping::REACH as i64;
        let inner = |span: [i64; 2]| [span[0] + reach, span[1] - reach];
        let (rows, cols) = (inner(whole.rows), inner(whole.cols));
        let plane = Plane { cols: (whole.cols[1] - whole.cols[0]) as usize, values: whole.values.clone() };
        let mut values = shaping.applied(&plane).values;
        // Swells are given in metres at full relief, samples are in the decoder's unit.
        let unit = self.metre();
        for (k, (step, std)) in shaping.swells.iter().enumerate().filter(|(_, (_, std))| *std > 0.0) {
            let swell = Waves::new(seed, &format!("shape-{k}"), *step, std * unit, rows, cols).heights();
            for (value, swell) in values.iter_mut().zip(swell) {
                *value = (f64::from(*value) + swell) as f32;
            }
        }
        Field { rows, cols, values }
    }

    /// Samples for a square of nodes, before they are shaped.
    pub(crate) fn unshaped(&self, seed: u64, nodes: usize, resolution: f64) -> Unshaped {
        let taps = taps(nodes, resolution / self.header.resolution);
        let reach = shaping::REACH as i64;
        let wide = [span(&taps)[0] - reach, span(&taps)[1] + reach];
        Unshaped { seed, field: self.field(seed, wide, wide), taps }
    }

    /// The heights of the nodes at full relief, m, row by row.
    pub(crate) fn heights(&self, unshaped: &Unshaped, shaping: &Shaping) -> Vec<f64> {
        let field = self.shaped_again(&unshaped.field, unshaped.seed, shaping);
        let scale = self.header.relief / self.header.std;
        let values = field.resampled(&unshaped.taps, &unshaped.taps);
        values.into_iter().map(|v| (v - self.header.mean) * scale).collect()
    }

    /// The samples before the passes.
    fn raw(&self, seed: u64, rows: [i64; 2], cols: [i64; 2]) -> Field {
        // Wider by what the warp may move a sample and by the kernel's reach.
        let wider = |span: [i64; 2]| [span[0] - WARP_REACH - 2, span[1] + WARP_REACH + 2];
        let mut field = self.decoded(seed, wider(rows), wider(cols)).warped(seed, rows, cols);
        for ((name, step), std) in ["swell", "long-swell"].into_iter().zip(SWELLS).zip(self.header.swell) {
            if std > 0.0 {
                let swell = Waves::new(seed, name, step, std, rows, cols).heights();
                for (value, swell) in field.values.iter_mut().zip(swell) {
                    *value = (f64::from(*value) + swell) as f32;
                }
            }
        }
        field
    }

    /// The samples as the decoder makes them.
    fn decoded(&self, seed: u64, rows: [i64; 2], cols: [i64; 2]) -> Field {
        let cell = CELL as i64;
        let first = [rows[0].div_euclid(cell), cols[0].div_euclid(cell)];
        let blocks = [(rows, first[0]), (cols, first[1])]
            .map(|(span, first)| (span[1] - first * cell).div_euclid(cell * CHUNK as i64) as usize + 1);
        let mut field = Field::new(rows, cols);
        let next = AtomicUsize::new(0);
        let work = || {
            let mut done = Vec::new();
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                if i >= blocks[0] * blocks[1] {
                    return done;
                }
                let corner =
                    [first[0] + (i / blocks[1] * CHUNK) as i64, first[1] + (i % blocks[1] * CHUNK) as i64];
                done.push((corner, self.decoder.run(&self.cells(seed, corner), CHUNK)));
            }
        };
        // Who makes a block changes none of its bits.
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(blocks[0] * blocks[1]);
        std::thread::scope(|scope| {
            let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
            let mut put = |done: Vec<([i64; 2], Vec<f32>)>| {
                for (corner, samples) in done {
                    field.put(corner.map(|c| c * cell), &samples, CELL * CHUNK);
                }
            };
            put(work());
            for other in others {
                match other.join() {
                    Ok(done) => put(done),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
        });
        field
    }

    /// The numbers of a block of [`CHUNK`]² cells and of its margin. They are normal, and each cell's depend on seed and place
    /// alone.
    fn cells(&self, seed: u64, corner: [i64; 2]) -> Vec<f32> {
        let side = CHUNK + 2 * HALO;
        let mut values = Vec::with_capacity(NUMBERS * side * side);
        for i in 0..side * side {
            let [row, col] = [i / side, i % side].map(|n| n as i64 - HALO as i64);
            let place = [corner[0] + row, corner[1] + col].map(|n| n.to_string());
            let mut stream = Stream::new(seed, &["terrain", "cell", &place[0], &place[1]]);
            for n in 0..NUMBERS {
                let fraction = if n < CHANNELS { 1.0 } else { self.header.detail };
                values.push((fraction * stream.normal(0.0, 1.0)) as f32);
            }
        }
        values
    }
}

/// Samples for a square of nodes, to be shaped in several ways.
pub(crate) struct Unshaped {
    seed: u64,
    field: Field,
    taps: Vec<Taps>,
}

/// A rectangle of the decoder's samples.
struct Field {
    rows: [i64; 2],
    cols: [i64; 2],
    values: Vec<f32>,
}

impl Field {
    fn new(rows: [i64; 2], cols: [i64; 2]) -> Self {
        let size = (rows[1] - rows[0]) * (cols[1] - cols[0]);
        Self { rows, cols, values: vec![0.0; size as usize] }
    }

    /// Takes over that part of a block which lies within.
    fn put(&mut self, corner: [i64; 2], block: &[f32], side: usize) {
        let width = (self.cols[1] - self.cols[0]) as usize;
        let from = corner[1].max(self.cols[0]);
        let to = (corner[1] + side as i64).min(self.cols[1]);
        if from >= to {
            return;
        }
        for (i, line) in block.chunks_exact(side).enumerate() {
            let row = corner[0] + i as i64;
            if row >= self.rows[0] && row < self.rows[1] {
                let start = (row - self.rows[0]) as usize * width + (from - self.cols[0]) as usize;
                let line = &line[(from - corner[1]) as usize..(to - corner[1]) as usize];
                self.values[start..start + line.len()].copy_from_slice(line);
            }
        }
    }

    /// The samples of this rectangle, each taken from a place a little off, by a smooth random field: cells don't lie on a lattice
    /// any more, and what little differs between the places within a cell makes no pattern.
    fn warped(&self, seed: u64, rows: [i64; 2], cols: [i64; 2]) -> Self {
        let moved = |name| Waves::new(seed, name, WARP, WARP_STD, rows, cols).heights();
        let (down, along) = (moved("warp-rows"), moved("warp-cols"));
        let (width, own) = ((cols[1] - cols[0]) as usize, (self.cols[1] - self.cols[0]) as usize);
        let mut out = Self::new(rows, cols);
        for (i, value) in out.values.iter_mut().enumerate() {
            let at = |first: i64, n: usize, by: f64| {
                let place = (first + n as i64) as f64 + by.clamp(-(WARP_REACH as f64), WARP_REACH as f64);
                let floor = place.floor();
                let t = place - floor;
                (floor as i64 - 1, [cubic(t + 1.0), cubic(t), cubic(1.0 - t), cubic(2.0 - t)])
            };
            let (row, by_row) = at(rows[0], i / width, down[i]);
            let (col, by_col) = at(cols[0], i % width, along[i]);
            let start = (row - self.rows[0]) as usize * own + (col - self.cols[0]) as usize;
            let mut sum = 0.0;
            for (k, w) in by_row.iter().enumerate() {
                let line = &self.values[start + k * own..start + k * own + 4];
                let parts = line.iter().zip(&by_col).map(|(v, w)| w * f64::from(*v));
                sum += w * parts.sum::<f64>();
            }
            *value = sum as f32;
        }
        out
    }

    /// The field at nodes that each take these samples along rows and columns.
    fn resampled(&self, rows: &[Taps], cols: &[Taps]) -> Vec<f64> {
        let width = (self.cols[1] - self.cols[0]) as usize;
        let mut out = Vec::with_capacity(rows.len() * cols.len());
        let mut line = vec![0.0; width];
        for taps in rows {
            line.fill(0.0);
            for (k, w) in taps.weights.iter().enumerate() {
                let start = (taps.first + k as i64 - self.rows[0]) as usize * width;
                for (sum, v) in line.iter_mut().zip(&self.values[start..start + width]) {
                    *sum += w * f64::from(*v);
                }
            }
            for taps in cols {
                let start = (taps.first - self.cols[0]) as usize;
                let parts = line[start..start + taps.weights.len()].iter().zip(&taps.weights);
                out.push(parts.map(|(v, w)| v * w).sum());
            }
        }
        out
    }
}

/// A smooth normal random field over a rectangle of samples: a cubic B-spline over nodes of independent normal height. Each node's
/// depends on seed, name and place alone.
struct Waves {
    /// Heights of the nodes that reach the rectangle, row by row.
    nodes: Vec<f64>,
    /// Nodes in a row.
    width: usize,
    /// For each row and column of samples, the first of its four nodes, counted from the first of all, and their weights.
    lines: [Vec<(usize, [f64; 4])>; 2],
}

impl Waves {
    /// With nodes every `step` samples, and this standard deviation.
    fn new(seed: u64, name: &str, step: usize, std: f64, rows: [i64; 2], cols: [i64; 2]) -> Self {
        let step = step as i64;
        let reach = |span: [i64; 2]| span[0].div_euclid(step) - 1..(span[1] - 1).div_euclid(step) + 3;
        let [by_row, by_col] = [reach(rows), reach(cols)];
        let mut nodes = Vec::new();
        for row in by_row.clone() {
            for col in by_col.clone() {
                let labels = ["terrain", name, &row.to_string(), &col.to_string()];
                nodes.push(Stream::new(seed, &labels).normal(0.0, std));
            }
        }
        let line = |span: [i64; 2], first: i64| {
            let sample =
                |s: i64| ((s.div_euclid(step) - 1 - first) as usize, spline(s.rem_euclid(step), step));
            (span[0]..span[1]).map(sample).collect()
        };
        let lines = [line(rows, by_row.start), line(cols, by_col.start)];
        Self { nodes, width: (by_col.end - by_col.start) as usize, lines }
    }

    /// The field's heights, row by row.
    fn heights(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.lines[0].len() * self.lines[1].len());
        for (row, by_row) in &self.lines[0] {
            // Along the columns first: one height for each column of nodes.
            let column = |c: usize| -> f64 {
                by_row.iter().enumerate().map(|(k, w)| w * self.nodes[(row + k) * self.width + c]).sum()
            };
            let down: Vec<f64> = (0..self.width).map(column).collect();
            for (col, by_col) in &self.lines[1] {
                out.push(by_col.iter().zip(&down[*col..]).map(|(w, z)| w * z).sum());
            }
        }
        out
    }
}

/// The weights of the four nodes about a sample: those of a cubic B-spline, scaled so that independent normal nodes give samples
/// of their standard deviation everywhere.
fn spline(sample: i64, step: i64) -> [f64; 4] {
    let t = sample as f64 / step as f64;
    let u = 1.0 - t;
    let weights =
        [u * u * u, 3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * u * u * u - 6.0 * u * u + 4.0, t * t * t];
    let length = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.map(|w| w / length)
}

/// The samples along a line that a node takes, and their weights.
struct Taps {
    first: i64,
    weights: [f64; 4],
}

/// The taps of `n` nodes, `ratio` samples apart, of which the middle one, or the first of the two, lies on the origin's sample: at
/// the model's own resolution and its multiples nodes are samples, whatever their number.
fn taps(n: usize, ratio: f64) -> Vec<Taps> {
    (0..n)
        .map(|i| {
            let at = (i as f64 - ((n - 1) / 2) as f64) * ratio;
            let floor = at.floor();
            let t = at - floor;
            Taps {
                first: floor as i64 - 1,
                weights: [cubic(t + 1.0), cubic(t), cubic(1.0 - t), cubic(2.0 - t)],
            }
        })
        .collect()
}

/// The kernel of cubic convolution with a = −1/2 (Keys 1981, eq. 15).
fn cubic(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (1.5 * x - 2.5) * x * x + 1.0
    } else if x < 2.0 {
        ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0
    } else {
        0.0
    }
}

/// The samples that any of these takes: first, one after the last.
fn span(taps: &[Taps]) -> [i64; 2] {
    let first = taps.iter().map(|t| t.first).min().unwrap_or(0);
    let end = taps.iter().map(|t| t.first + t.weights.len() as i64).max().unwrap_or(0);
    [first, end]
}
