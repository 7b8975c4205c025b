//! Drawn surfaces with a start and a goal for every task.

use super::broken::{Broken, Fields, NoStarts};
use super::ends::{DIRECTIONS, Possible, Starts};
use super::params::TaskParams;
use super::{GenerateError, Pairs};
use crate::surface::counted_from_lowest;
use vb_math::rng::Stream;
use vb_terrain::{Model, Request, Shaping};
use vb_world::{Heightfield, Semantics};

/// Surfaces drawn before giving up on starts and goals. A surface is wider than the world and has several windows, in each of which starts and
/// goals are looked for: that takes a hundredth of the time that a new surface takes.
const SURFACES: usize = 400;

/// If no task can start anywhere in so many windows, or there are more tasks than directions, the rules can't be met.
const HOPELESS: usize = 10;

/// If so many windows have too little room, or none of them has any where one of the tasks would start, the rules can't be met.
const TOO_FULL: usize = 600;

/// The surfaces of a world, all square and as rough, from which one is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surfaces<'a> {
    pub(crate) model: &'a Model,
    /// What is done to its wavelengths.
    pub(crate) shaping: Option<&'a Shaping>,
    /// Nodes along a side.
    pub(crate) nodes: usize,
    /// Distance between nodes, m.
    pub(crate) resolution: f64,
    /// The distance by which windows are moved, and by which a surface reaches beyond the middle one, nodes; 0: one window.
    pub(crate) shift: [usize; 2],
    /// Standard deviation of height over many surfaces, m.
    pub(crate) std: f64,
    /// Step of the heights, m; `None`: as fine as 16 bits over the surface's own range.
    pub(crate) step: Option<f64>,
    pub(crate) semantics: &'a Semantics,
    /// The tasks that must find room.
    pub(crate) tasks: &'a TaskParams,
    /// The rules' names for what surfaces follow from, for messages.
    pub(crate) fields: Fields,
}

impl Surfaces<'_> {
    /// Draws surfaces until one has starts and goals all around, and takes it with these.
    ///
    /// # Errors
    /// Returns an error if the model can't draw such a surface, or none of many has such ground.
    pub(crate) fn with_ends(
        &self,
        world: &str,
        rng: &mut Stream,
    ) -> Result<(Heightfield, Pairs), GenerateError> {
        let TaskParams { radius, count, stand } = self.tasks;
        let (mut room, mut broken, mut possible) = (0, Broken::default(), Possible::none());
        let mut looked = 0;
        'surfaces: for _ in 0..SURFACES {
            let surface = self.draw(rng.next_u64())?;
            for window in self.windows() {
                let ground = self.window(&surface, window);
                // There are no obstacles yet that could be too near.
                let starts = Starts::new(&ground, self.semantics, &[], 0.0, *radius, stand);
                match starts.ends(*count) {
                    Some(ends) if ends.spread => return Ok((ground, ends.pairs)),
                    _ => {}
                }
                looked += 1;
                room = room.max(starts.room());
                broken.join(&starts.broken);
                possible.add(&starts);
                let hopeless = looked == HOPELESS && (room == 0 || *count > DIRECTIONS);
                if hopeless || (looked == TOO_FULL && (room < *count || !possible.all_around(*count))) {
                    break 'surfaces;
                }
            }
        }
        let why = NoStarts::new(*count, room, &broken, self.fields);
        Err(GenerateError::NoStart { world: world.into(), distance: 2.0 * radius, why })
    }

    /// The first row and column of each window, the middle one first.
    fn windows(&self) -> Vec<[usize; 2]> {
        let [step, reach] = self.shift;
        let places: Vec<usize> = (0..=2 * reach).step_by(step.max(1)).collect();
        let mut all: Vec<[usize; 2]> = places.iter().flat_map(|r| places.iter().map(|c| [*r, *c])).collect();
        // From the middle outwards; of equals the first.
        all.sort_by_key(|w| w.iter().map(|k| k.abs_diff(reach).pow(2)).sum::<usize>());
        all
    }

    fn window(&self, surface: &Heightfield, [row, col]: [usize; 2]) -> Heightfield {
        let n = self.nodes;
        let heights: Vec<f64> = (0..n * n).map(|i| surface.node(row + i / n, col + i % n)).collect();
        counted_from_lowest(n, self.resolution, &heights, self.step)
    }

    fn draw(&self, seed: u64) -> Result<Heightfield, GenerateError> {
        let fraction = self.std / self.shaping.map_or(self.model.header().relief, Shaping::std);
        let nodes = self.nodes + 2 * self.shift[1];
        let request = Request { seed, rows: nodes, cols: nodes, resolution: self.resolution, fraction };
        let grid = self.fields.grid;
        self.model.shaped(&request, self.shaping).map_err(|source| GenerateError::Surface { grid, source })
    }
}
