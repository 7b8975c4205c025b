//! The outline that meets the ground: a wheel's circle, or a belt's under the wheels of a tracked vehicle.

use super::{FIRST, Row, TRACK, WHEEL};

/// The outermost stations of a wheel lie at this part of the radius, where the rim stands at 72 degrees.
const EXTENT: f64 = 0.95;
/// Spacing under the axle over the mean spacing: where the rim leaves the soil matters most there.
const CROWDING: f64 = 0.35;
/// A wheel keeps its footprint until it is this part of its radius above the ground.
const CLEARANCE: f64 = 0.5;
/// Steepest slope of a belt's outline that is told apart from steeper ones.
const STEEPEST: f64 = 3.0;

/// An outline and where its stations are.
#[derive(Clone, Debug)]
pub(super) struct Shape<const N: usize> {
    /// Of a wheel, m; 0 for a belt.
    pub(super) radius: f64,
    /// Distance from the hub within which all of the outline is, m.
    pub(super) reach: f64,
    /// Height of the hub above the ground, m, up to which the footprint is kept.
    pub(super) near: f64,
    /// Distance over which the soil under the outline becomes other soil, m: a wheel's radius, about the length of its
    /// contact when it sinks by an eighth of the diameter, and a belt's length.
    pub(super) renewal: f64,
    pub(super) width: f64,
    pub(super) strips: usize,
    /// Distance of each station from the hub along the heading, and the length it stands for.
    pub(super) xs: Row<N>,
    pub(super) lengths: Row<N>,
    pub(super) inverse_lengths: Row<N>,
    /// 1 / the shortest length.
    pub(super) finest: f64,
    /// How far the outline is below the hub at each station.
    pub(super) half: Row<N>,
    /// How fast it rises against the hub, m/s.
    pub(super) rates: Row<N>,
    /// Pressure normal to the outline and pressure normal to the ground.
    pub(super) radial: Directions<N>,
    pub(super) level: Directions<N>,
}

/// Directions of stresses on the outline in the wheel's frame, and the outline's length over each station, m.
#[derive(Clone, Debug)]
pub(super) struct Directions<const N: usize> {
    pub(super) normal: [Row<N>; 3],
    /// Along the heading and up.
    pub(super) tangent: [Row<N>; 2],
    pub(super) rim: Row<N>,
}

impl<const N: usize> Shape<N> {
    /// Place of the foremost station.
    const LAST: usize = N - 3;

    /// Stations at `at(place)`, ascending, of a level outline just below the hub, `width` (m) wide, over soil that is
    /// remembered at a resolution (m).
    fn stations(at: impl Fn(usize) -> f64, width: f64, resolution: f64) -> Self {
        let xs: Row<N> = std::array::from_fn(&at);
        let lengths: Row<N> = std::array::from_fn(|k| {
            let inside = (FIRST..=Self::LAST).contains(&k);
            if inside { 0.5 * (at(k + 1) - at(k - 1)) } else { 0.0 }
        });
        let inverse_lengths = lengths.map(|l| if l > 0.0 { 1.0 / l } else { 0.0 });
        let level = Directions {
            normal: [[0.0; N], [0.0; N], [1.0; N]],
            tangent: [[1.0; N], [0.0; N]],
            rim: lengths,
        };
        Self {
            radius: 0.0,
            reach: 0.0,
            near: 0.0,
            renewal: 1.0,
            width,
            strips: ((width / resolution) as usize).clamp(2, 16),
            xs,
            lengths,
            inverse_lengths,
            finest: inverse_lengths.iter().fold(0.0, |a, b| f64::max(a, *b)),
            half: [0.0; N],
            rates: [0.0; N],
            radial: level.clone(),
            level,
        }
    }

    pub(super) fn strip_width(&self) -> f64 {
        self.width / self.strips as f64
    }

    /// Distance of a strip's middle to the left of the wheel's.
    pub(super) fn offset(&self, strip: usize) -> f64 {
        self.width * ((strip as f64 + 0.5) / self.strips as f64 - 0.5)
    }
}

impl Shape<WHEEL> {
    pub(super) fn wheel(radius: f64, width: f64, resolution: f64) -> Self {
        let extent = EXTENT * radius;
        let side = ((Self::LAST - FIRST) / 2) as f64;
        let middle = FIRST as f64 + side;
        let at = |place: usize| {
            let u = (place.clamp(FIRST, Self::LAST) as f64 - middle) / side;
            extent * u * (CROWDING + (1.0 - CROWDING) * u * u)
        };
        let shape = Self::stations(at, width, resolution);
        let half = shape.xs.map(|x| (radius * radius - x * x).sqrt());
        let (sin, cos) = (shape.xs.map(|x| x / radius), half.map(|h| h / radius));
        let rim = std::array::from_fn(|k| shape.lengths[k] * radius / half[k]);
        let radial = Directions { normal: [sin.map(|s| -s), [0.0; WHEEL], cos], tangent: [cos, sin], rim };
        Self {
            radius,
            reach: vb_math::hypot(radius, width),
            near: (1.0 + CLEARANCE) * radius,
            renewal: radius,
            half,
            radial,
            ..shape
        }
    }
}

impl Shape<TRACK> {
    /// Evenly spaced stations from `rear` to `front` (m, relative to the hub); where the outline is, [`Self::set`] says.
    pub(super) fn track(rear: f64, front: f64, near: f64, width: f64, resolution: f64) -> Self {
        let spacing = (front - rear) / (Self::LAST - FIRST) as f64;
        let at = |place: usize| rear + spacing * (place as f64 - FIRST as f64);
        let shape = Self::stations(at, width, resolution);
        Self { reach: vb_math::hypot(front.max(-rear), width), near, renewal: front - rear, ..shape }
    }

    /// Sets the outline at a station: how far below the hub it is, m, its slope, rise over way forward, and how fast it
    /// rises, m/s.
    pub(super) fn set(&mut self, k: usize, below: f64, slope: f64, rate: f64) {
        self.rates[k] = rate;
        let slope = slope.clamp(-STEEPEST, STEEPEST);
        let longer = (1.0 + slope * slope).sqrt();
        let (sin, cos) = (slope / longer, 1.0 / longer);
        self.half[k] = below;
        self.radial.normal[0][k] = -sin;
        self.radial.normal[2][k] = cos;
        self.radial.tangent[0][k] = cos;
        self.radial.tangent[1][k] = sin;
        self.radial.rim[k] = self.lengths[k] * longer;
    }
}
