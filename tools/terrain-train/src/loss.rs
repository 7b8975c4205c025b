//! What training makes small.

use candle_core::{D, Device, Result, Tensor};
use vb_math::rng::Stream;

use crate::ops::windows;

/// Side of the patches that are compared on each level of the pyramid.
const PATCH: usize = 5;
/// Random filters whose responses are compared.
const FILTERS: usize = 12;
/// Levels of the pyramid: samples, and three halvings.
const LEVELS: usize = 4;

/// Normal numbers of a stream as a tensor.
pub(crate) fn normal(shape: &[usize], rng: &mut Stream, device: &Device) -> Result<Tensor> {
    let values: Vec<f32> = (0..shape.iter().product()).map(|_| rng.normal(0.0, 1.0) as f32).collect();
    Tensor::from_vec(values, shape, device)
}

/// Random directions: `count` columns of length 1.
fn directions(size: usize, count: usize, rng: &mut Stream, device: &Device) -> Result<Tensor> {
    let d = normal(&[size, count], rng, device)?;
    let length = d.sqr()?.sum_keepdim(0)?.sqrt()?;
    d.broadcast_div(&length)
}

/// Mean squared distance between two sets of as many vectors (rows) along random directions, each sorted: the square of the
/// sliced Wasserstein distance of order 2 (Kolouri et al. 2018, eq. 8).
pub(crate) fn sliced(a: &Tensor, b: &Tensor, count: usize, rng: &mut Stream) -> Result<Tensor> {
    let d = directions(a.dim(1)?, count, rng, a.device())?;
    let sorted =
        |x: &Tensor| -> Result<Tensor> { Ok(x.matmul(&d)?.t()?.contiguous()?.sort_last_dim(true)?.0) };
    (sorted(a)? - sorted(b)?)?.sqr()?.mean_all()
}

/// Mean of absolute and squared error over the measured samples.
pub(crate) fn reconstruction(made: &Tensor, wanted: &Tensor, measured: &Tensor) -> Result<Tensor> {
    let error = ((made - wanted)? * measured)?;
    let count = measured.sum_all()?;
    (error.abs()?.sum_all()? + error.sqr()?.sum_all()?)?.div(&count)
}

/// Codes: the numbers of every square of `block` × `block` cells, half a block apart, as rows.
pub(crate) fn codes(latent: &Tensor, block: usize) -> Result<Tensor> {
    let all = windows(latent, block, false)?;
    let (b, h, w, c) = all.dims4()?;
    let step = block / 2;
    let pick = |n: usize| -> Vec<u32> { (0..n as u32).step_by(step).collect() };
    let (rows, cols) = (pick(h), pick(w));
    let (nr, nc) = (rows.len(), cols.len());
    let all = all.index_select(&Tensor::from_vec(rows, nr, latent.device())?, 1)?;
    let all = all.index_select(&Tensor::from_vec(cols, nc, latent.device())?, 2)?;
    all.reshape((b * nr * nc, c))
}

/// The levels of tiles' Laplacian pyramid, finest first, the last with all that is longer.
fn pyramid(tiles: &Tensor) -> Result<Vec<Tensor>> {
    let mut levels = Vec::with_capacity(LEVELS);
    let mut x = tiles.clone();
    for _ in 1..LEVELS {
        let (b, h, w, c) = x.dims4()?;
        let small = x.reshape((b, h / 2, 2, w / 2, 2, c))?.mean(4)?.mean(2)?;
        let back = small.reshape((b, h / 2, 1, w / 2, 1, c))?.broadcast_as((b, h / 2, 2, w / 2, 2, c))?;
        levels.push((&x - back.reshape((b, h, w, c))?)?);
        x = small;
    }
    levels.push(x);
    Ok(levels)
}

/// What made tiles are compared with: patches of real ones on each level of the pyramid, and patches of how strongly the level
/// responds to random filters, which tell smooth places from rough ones and ridges from furrows.
pub(crate) struct Patches {
    levels: Vec<Level>,
    /// What the encoder sees at each of its resolutions.
    features: Vec<Kind>,
}

/// One level of real tiles.
struct Level {
    /// Random filters of [`PATCH`]² samples, as columns.
    filters: Tensor,
    plain: Kind,
    /// None where the level is too small for it.
    responses: Option<Kind>,
}

/// Vectors of one kind, each entry shifted and scaled to mean 0 and standard deviation 1.
struct Kind {
    rows: Tensor,
    mean: Tensor,
    std: Tensor,
}

impl Kind {
    fn new(all: &Tensor, whole: &[f32], most: usize, rng: &mut Stream) -> Result<Self> {
        let mut places: Vec<u32> = (0..whole.len() as u32).filter(|i| whole[*i as usize] > 0.5).collect();
        rng.shuffle(&mut places);
        places.truncate(most);
        let rows = chosen(all, places)?;
        let mean = rows.mean_keepdim(0)?;
        let rows = rows.broadcast_sub(&mean)?;
        // An entry that never changes counts for nothing.
        let std = (rows.sqr()?.mean_keepdim(0)?.sqrt()? + 1e-3)?;
        Ok(Self { rows: rows.broadcast_div(&std)?, mean, std })
    }

    fn distance(&self, made: &Tensor, slices: usize, rng: &mut Stream) -> Result<Tensor> {
        let mut places: Vec<u32> = (0..made.dim(0)? as u32).collect();
        let n = self.rows.dim(0)?.min(places.len());
        rng.shuffle(&mut places);
        places.truncate(n);
        let made = chosen(made, places)?.broadcast_sub(&self.mean)?.broadcast_div(&self.std)?;
        sliced(&made, &self.rows.narrow(0, 0, n)?, slices, rng)
    }
}

fn chosen(rows: &Tensor, places: Vec<u32>) -> Result<Tensor> {
    let n = places.len();
    rows.index_select(&Tensor::from_vec(places, n, rows.device())?, 0)
}

impl Patches {
    /// Up to `most` patches a level of real tiles (batch, row, column, 1) and of what of them was measured.
    pub(crate) fn real(
        tiles: &Tensor,
        measured: &Tensor,
        features: &[Tensor],
        most: usize,
        rng: &mut Stream,
    ) -> Result<Self> {
        let mut of_features = Vec::new();
        for f in features {
            let mut mask = measured.clone();
            while mask.dim(1)? > f.dim(1)? {
                mask = least(&mask)?;
            }
            of_features.push(Kind::new(&rows(f)?, &mask.flatten_all()?.to_vec1::<f32>()?, most, rng)?);
        }
        let mut levels = Vec::new();
        let mut mask = measured.clone();
        for (i, level) in pyramid(tiles)?.iter().enumerate() {
            // What the mean over a square misses is missing on its own level too.
            if i > 0 {
                mask = least(&mask)?;
            }
            let whole =
                |mask: &Tensor| windows(mask, PATCH, false)?.min(D::Minus1)?.flatten_all()?.to_vec1::<f32>();
            let filters = directions(PATCH * PATCH, FILTERS, rng, tiles.device())?;
            let places = whole(&mask)?;
            let plain = Kind::new(&patches(level)?, &places, most, rng)?;
            let responses = match responses(level, &filters)? {
                Some(rows) => {
                    let of = least(&windows(&mask, PATCH, false)?.min_keepdim(D::Minus1)?)?;
                    Some(Kind::new(&rows, &whole(&of)?, most, rng)?)
                }
                None => None,
            };
            levels.push(Level { filters, plain, responses });
        }
        Ok(Self { levels, features: of_features })
    }

    /// How far made tiles are from the real ones: the sliced distances between patches and between responses, each in units of
    /// its own spread, averaged over the levels (after Karras et al. 2018, §5).
    pub(crate) fn distance(
        &self,
        made: &Tensor,
        features: &[Tensor],
        slices: usize,
        rng: &mut Stream,
    ) -> Result<[Tensor; 3]> {
        let mut plain = Tensor::zeros((), made.dtype(), made.device())?;
        let mut second = plain.clone();
        let (mut n, mut m) = (0.0, 0.0);
        for (real, level) in self.levels.iter().zip(pyramid(made)?) {
            if real.plain.rows.dim(0)? > 0 {
                plain = (plain + real.plain.distance(&patches(&level)?, slices, rng)?)?;
                n += 1.0;
            }
            if let Some(kind) = &real.responses
                && kind.rows.dim(0)? > 0
                && let Some(rows) = responses(&level, &real.filters)?
            {
                second = (second + kind.distance(&rows, slices, rng)?)?;
                m += 1.0;
            }
        }
        let mut third = Tensor::zeros((), made.dtype(), made.device())?;
        for (real, made) in self.features.iter().zip(features) {
            third = (third + real.distance(&rows(made)?, slices, rng)?)?;
        }
        Ok([
            (plain / f64::max(n, 1.0))?,
            (second / f64::max(m, 1.0))?,
            (third / self.features.len().max(1) as f64)?,
        ])
    }
}

/// Means or least values over squares of 2 × 2.
fn least(x: &Tensor) -> Result<Tensor> {
    let (b, h, w, c) = x.dims4()?;
    x.narrow(1, 0, h / 2 * 2)?.narrow(2, 0, w / 2 * 2)?.reshape((b, h / 2, 2, w / 2, 2, c))?.min(4)?.min(2)
}

/// All places' channels as rows.
fn rows(x: &Tensor) -> Result<Tensor> {
    let (b, h, w, c) = x.dims4()?;
    x.reshape((b * h * w, c))
}

/// All patches of a level as rows.
fn patches(level: &Tensor) -> Result<Tensor> {
    rows(&windows(level, PATCH, false)?)
}

/// All patches of a level's rectified responses to filters, averaged over squares of 2 × 2, as rows. None where they would be
/// smaller than a patch.
fn responses(level: &Tensor, filters: &Tensor) -> Result<Option<Tensor>> {
    let (b, h, w, _) = level.dims4()?;
    let (h, w) = (h + 1 - PATCH, w + 1 - PATCH);
    if h / 2 < PATCH + 2 {
        return Ok(None);
    }
    let r = patches(level)?.matmul(filters)?.relu()?.reshape((b, h, w, FILTERS))?;
    let (h, w) = (h / 2, w / 2);
    let r =
        r.narrow(1, 0, 2 * h)?.narrow(2, 0, 2 * w)?.reshape((b, h, 2, w, 2, FILTERS))?.mean(4)?.mean(2)?;
    Ok(Some(patches(&r)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(t: &Tensor) -> f64 {
        f64::from(t.to_scalar::<f32>().unwrap())
    }

    #[test]
    fn the_sliced_distance_of_a_shifted_set_is_the_shift_over_the_dimensions() {
        // Along a direction d all points move by d·v, and the mean of (d·v)² over directions is |v|²/n.
        let mut rng = Stream::new(1, &["test"]);
        let a = normal(&[300, 16], &mut rng, &Device::Cpu).unwrap();
        let v = normal(&[1, 16], &mut rng, &Device::Cpu).unwrap();
        let b = a.broadcast_add(&v).unwrap();
        let wanted = value(&v.sqr().unwrap().mean_all().unwrap());
        let got = value(&sliced(&a, &b, 4000, &mut rng).unwrap());
        // (d·v)² varies by about its own mean times √2: the mean of 4000 by 2.2 %.
        assert!((got / wanted - 1.0).abs() < 0.09, "{got} {wanted}");
        assert_eq!(value(&sliced(&a, &a, 10, &mut rng).unwrap()), 0.0);
    }

    #[test]
    fn errors_count_where_it_was_measured_only() {
        let t = |v: [f32; 4]| Tensor::from_vec(v.to_vec(), (1, 2, 2, 1), &Device::Cpu).unwrap();
        let loss = reconstruction(&t([1.0, 5.0, 3.0, 0.0]), &t([0.0; 4]), &t([1.0, 0.0, 1.0, 1.0])).unwrap();
        // (1 + 3 + 0)/3 + (1 + 9 + 0)/3.
        assert!((value(&loss) - 14.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn codes_are_the_squares_of_cells_half_a_block_apart() {
        let field: Vec<f32> = (0..64).map(|i| i as f32).collect();
        let codes = codes(&Tensor::from_vec(field, (1, 8, 8, 1), &Device::Cpu).unwrap(), 4).unwrap();
        assert_eq!(codes.dims(), [9, 16]);
        let all = codes.to_vec2::<f32>().unwrap();
        assert_eq!(all[0][..5], [0.0, 1.0, 2.0, 3.0, 8.0]);
        assert_eq!(all[4][0], 18.0);
    }

    #[test]
    fn rough_and_smooth_surfaces_are_far_apart_and_a_surface_is_near_itself() {
        let mut rng = Stream::new(2, &["test"]);
        let rough = normal(&[4, 64, 64, 1], &mut rng, &Device::Cpu).unwrap();
        let other = normal(&[4, 64, 64, 1], &mut rng, &Device::Cpu).unwrap();
        // Sums along rows and columns: a random walk both ways.
        let mut sums = rough.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        for i in 0..sums.len() {
            let (row, col) = (i / 64 % 64, i % 64);
            sums[i] += if col > 0 { sums[i - 1] } else { 0.0 };
            sums[i] += if row > 0 { sums[i - 64] } else { 0.0 };
            sums[i] -= if row > 0 && col > 0 { sums[i - 65] } else { 0.0 };
        }
        let smooth = Tensor::from_vec(sums, (4, 64, 64, 1), &Device::Cpu).unwrap();
        let smooth = (&smooth / value(&smooth.sqr().unwrap().mean_all().unwrap()).sqrt()).unwrap();
        let whole = rough.ones_like().unwrap();
        let real = Patches::real(&rough, &whole, &[], 500, &mut rng).unwrap();
        let near = real.distance(&other, &[], 40, &mut rng).unwrap();
        let far = real.distance(&smooth, &[], 40, &mut rng).unwrap();
        for (near, far) in near.iter().zip(&far).take(2) {
            assert!(value(far) > 5.0 * value(near), "{} {}", value(near), value(far));
        }
    }
}
