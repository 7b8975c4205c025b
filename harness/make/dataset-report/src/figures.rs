//! What a dataset has, in figures.

use std::collections::{BTreeMap, BTreeSet};

use vb_dataset::{Episode, Feature, View};
use vb_world::{TerrainClass, World};

/// A frame as quantities are measured on it.
struct Frame<'a> {
    view: &'a View<'a>,
    index: usize,
    state: Vec<f64>,
    world: &'a World,
}

/// Something that is measured on each frame.
pub struct Quantity {
    pub name: &'static str,
    /// Its unit, as axes have it.
    pub unit: &'static str,
    /// The width of the bins of its distribution.
    pub bin: f64,
    value: fn(&Frame<'_>) -> f64,
}

fn action(frame: &Frame<'_>, entry: usize) -> f64 {
    frame.view.row("action", frame.index).get(entry).copied().unwrap_or(0.0)
}

/// The quantities whose distributions are shown.
pub const QUANTITIES: [Quantity; 8] = [
    Quantity { name: "forward speed", unit: "m/s", bin: 0.25, value: |f| f.state[6] },
    Quantity {
        name: "terrain slope under the vehicle",
        unit: "degrees",
        bin: 1.0,
        value: |f| {
            let [x, y] = f.world.heightfield.facet(f.state[0], f.state[1]).gradient;
            vb_math::atan(vb_math::hypot(x, y)).to_degrees()
        },
    },
    Quantity { name: "roll", unit: "degrees", bin: 1.0, value: |f| f.state[3].to_degrees() },
    Quantity { name: "pitch", unit: "degrees", bin: 1.0, value: |f| f.state[4].to_degrees() },
    Quantity {
        name: "steering command",
        unit: "fraction fraction of full lock, left positive",
        bin: 0.05,
        value: |f| action(f, 0),
    },
    Quantity {
        name: "throttle command",
        unit: "fraction of full throttle",
        bin: 0.05,
        value: |f| action(f, 1),
    },
    Quantity { name: "brake command", unit: "fraction of full brakes", bin: 0.05, value: |f| action(f, 2) },
    Quantity {
        name: "gear command",
        unit: "−1 reverse, 0 neutral, 1 forward",
        bin: 1.0,
        value: |f| action(f, 3),
    },
];

/// The outermost bin on either side: it has all that lies beyond.
const OUTERMOST: f64 = 1000.0;

/// A distribution: the number of values in each bin, by the place of the bin; bin 0 is centred at 0, and those beyond bin ±1000
/// are in that one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Histogram(pub BTreeMap<i64, u64>);

impl Histogram {
    fn add(&mut self, value: f64, bin: f64) {
        let place = (value / bin).round().clamp(-OUTERMOST, OUTERMOST);
        *self.0.entry(place as i64).or_default() += 1;
    }

    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.values().sum()
    }
}

/// Episodes by the names of rows and columns.
pub type Counts = BTreeMap<String, BTreeMap<String, u64>>;

/// The figures of a dataset, episode by episode.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    pub episodes: u64,
    pub frames: u64,
    /// The length of all ways, m.
    pub distance_m: f64,
    pub worlds: BTreeSet<String>,
    /// Episodes by who drove and outcome.
    pub by_driver: Counts,
    /// Episodes by the kind of ground at the end, and outcome.
    pub by_ground: Counts,
    /// Episodes by the world's relief, and outcome.
    pub by_elevation: Counts,
    /// Failures by cause, and the kind of ground at the end.
    pub by_cause: Counts,
    /// The distributions of the quantities, in their order, by the kind of the world's ground.
    pub histograms: BTreeMap<String, Vec<Histogram>>,
}

impl Figures {
    /// Adds an episode of a dataset with these columns, in its world at the dataset's scale.
    pub fn add(&mut self, features: &[Feature], episode: &Episode, world: &World) {
        let info = &episode.info;
        self.episodes += 1;
        self.frames += episode.frames as u64;
        self.distance_m += info.distance_m;
        self.worlds.insert(info.world.clone());
        let count = |table: &mut Counts, row: &str, column: &str| {
            *table.entry(row.to_owned()).or_default().entry(column.to_owned()).or_default() += 1;
        };
        let (outcome, ground) = (info.outcome.name(), info.ground.map_or("", TerrainClass::name));
        count(&mut self.by_driver, &info.driver, outcome);
        count(&mut self.by_ground, ground, outcome);
        count(&mut self.by_elevation, info.elevation.name(), outcome);
        if let Some(cause) = info.cause {
            count(&mut self.by_cause, cause.name(), ground);
        }
        let view = episode.view(features);
        let own = self.histograms.entry(info.terrain.name().to_owned()).or_default();
        own.resize_with(QUANTITIES.len(), Histogram::default);
        for index in 0..episode.frames {
            let frame = Frame { view: &view, index, state: view.state(index), world };
            for (histogram, q) in own.iter_mut().zip(&QUANTITIES) {
                let value = (q.value)(&frame);
                if value.is_finite() {
                    histogram.add(value, q.bin);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_dataset::{Ending, EpisodeInfo, Layout, Values};
    use vb_score::Outcome;
    use vb_world::Heightfield;

    #[test]
    fn quantities_are_in_the_units_of_their_axes() {
        // A plane that rises by one in ten to the east, and two frames on it.
        let n = 65;
        let heights = (0..n * n).map(|k| 0.1 * (k % n) as f64).collect();
        let world = World::uniform("w001", Heightfield::new(n, n, 1.0, heights), TerrainClass::Gravel, 0.6);
        let features = Layout { wheels: 4, speed: true, goal: false, truth: false, crops: 0 }.features();
        let zeros = |f: &Feature| {
            let mut values = Values::new(f.dtype);
            if let Values::F32(v) = &mut values {
                v.resize(2 * f.width(), 0.0);
            }
            values
        };
        let mut columns: Vec<Values> = features.iter().map(zeros).collect();
        for (f, values) in features.iter().zip(&mut columns) {
            let Values::F32(v) = values else { continue };
            match f.name {
                // Roll of 0.1 rad, pitch of -0.2 rad, 3 m/s.
                "observation.state" => (v[3], v[4], v[6]) = (0.1, -0.2, 3.0),
                "action" => v[..4].copy_from_slice(&[0.5, 0.25, 0.0, 1.0]),
                _ => {}
            }
        }
        let info = EpisodeInfo {
            outcome: Ending::Decided(Outcome::Stuck),
            ground: Some(TerrainClass::Gravel),
            ..EpisodeInfo::default()
        };
        let episode = Episode { info, frames: 2, columns };
        let mut figures = Figures::default();
        figures.add(&features, &episode, &world);
        assert_eq!((figures.episodes, figures.frames), (1, 2));
        assert_eq!(figures.by_ground["gravel"]["stuck"], 1);
        assert!(figures.by_cause.is_empty());
        let expected: [(&str, &[i64]); 6] = [
            // 12 bins of 0.25 m/s.
            ("forward speed", &[0, 12]),
            // atan(0.1) is 5.7 degrees.
            ("terrain slope under the vehicle", &[6]),
            ("roll", &[0, 6]),
            ("pitch", &[-11, 0]),
            ("steering command", &[0, 10]),
            ("gear command", &[0, 1]),
        ];
        for (name, bins) in expected {
            let k = QUANTITIES.iter().position(|q| q.name == name).unwrap();
            let found: Vec<i64> = figures.histograms["rigid"][k].0.keys().copied().collect();
            assert_eq!(found, bins, "{name}");
        }
    }

    #[test]
    fn a_value_is_in_the_bin_that_is_centred_next_to_it() {
        let mut h = Histogram::default();
        for value in [-0.6, -0.4, 0.0, 0.4, 0.6, 7.4] {
            h.add(value, 1.0);
        }
        assert_eq!(h.0, [(-1, 1), (0, 3), (1, 1), (7, 1)].into());
        assert_eq!(h.count(), 6);
        let mut h = Histogram::default();
        [1e38, -1e38, 1001.0].into_iter().for_each(|v| h.add(v, 1.0));
        assert_eq!(h.0, [(-1000, 1), (1000, 2)].into());
    }
}
