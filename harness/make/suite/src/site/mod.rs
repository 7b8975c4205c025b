//! Worlds of a real place, from a raster of its heights or a course.

mod course;
mod rules;
mod survey;

use std::collections::BTreeMap;

use vb_math::rng::Stream;
use vb_terrain::ElevationImage;
use vb_world::{Density, Heightfield, Obstacle, Semantics, Terrain, TerrainClass, World};

pub use course::CourseSite;
pub use rules::{GroundRule, SiteGround, SiteParams};

use crate::generate::{
    self, Fields, GenerateError, GeneratorParams, NoStarts, ObstacleParams, Starts, TaskParams,
    finest_path_grid,
};
use crate::level::{level, median_slope};
use crate::surface::counted_from_lowest;
use survey::{Layout, extents};

/// The data that are known of a place.
#[derive(Clone, Copy, Debug)]
pub struct Survey<'a> {
    /// The heights, m.
    pub heights: &'a ElevationImage,
    /// The distance between the samples of the heights, m.
    pub resolution: f64,
    /// The labels of the ground over the same rectangle, at any number of samples.
    pub labels: Option<&'a ElevationImage>,
    /// The obstacles, with positions from the middle of the raster; `None` if they are to be drawn.
    pub obstacles: Option<&'a [Obstacle]>,
    /// Whether a relief that no vehicle drives on is taken as it is; else it is an error, since the unit is wrong by all appearance.
    pub any_relief: bool,
}

/// The part of a survey that becomes worlds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// One world about a point (x, y), m, with x east and y north of the raster's middle.
    At([f64; 2]),
    /// As many worlds side by side as fit, about the middle.
    Tiles,
}

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SiteError {
    #[error(
        "a world of {side} m at ({}, {}) m exceeds the survey, which is {} m by {} m: use another position (--at), or rules with a smaller `side` (--site FILE, a copy of tasks/generator/site.yaml)",
        at[0], at[1], extents[0], extents[1]
    )]
    Outside {
        /// The middle (x, y) of the world, m.
        at: [f64; 2],
        /// The side of the world, m.
        side: f64,
        /// The extents of the survey along x and y, m.
        extents: [f64; 2],
    },
    #[error(
        "the survey, which is {} m by {} m, has room for {worlds} worlds of {side} m, more than the limit of {MOST_WORLDS}: use a larger `side` (--site FILE), split the survey, or create a single world (--at)",
        extents[0], extents[1]
    )]
    TooMany {
        worlds: f64,
        /// The side of a world, m.
        side: f64,
        /// The extents of the survey along x and y, m.
        extents: [f64; 2],
    },
    #[error(
        "path.grid: {grid} is too fine for worlds of {side} m: use {finest} or more (--params FILE), or a smaller `side` (--site FILE)"
    )]
    PathGrid {
        /// The distance between the nodes of the grid, m.
        grid: f64,
        /// The side of a world, m.
        side: f64,
        /// The finest grid of a world of this side, m.
        finest: f64,
    },
    #[error(
        "the height at ({:.1}, {:.1}) m from the survey's centre is unknown: fill the hole, or use another position (--at)", at[0], at[1]
    )]
    Hole {
        /// The place (x, y), m from the survey's middle.
        at: [f64; 2],
    },
    #[error(
        "label {label} at ({:.1}, {:.1}) m from the survey's centre is not in ground.legend: add it with its class", at[0], at[1]
    )]
    Label {
        label: f64,
        /// The place (x, y) of the label, m from the survey's middle.
        at: [f64; 2],
    },
    #[error(
        "labels of {} by {} samples cannot cover the survey's {} m by {} m with square samples: crop them to the same rectangle", samples[0], samples[1], extents[0], extents[1]
    )]
    Labels {
        /// The numbers of samples of the labels along x and y.
        samples: [usize; 2],
        /// The extents of the survey along x and y, m.
        extents: [f64; 2],
    },
    #[error(
        "heights at ({:.1}, {:.1}) m have a relief of {relief:.1} m within {side} m (median slope {slope:.0} degrees), which is not drivable: \
         check the unit. Give the metres of one unit of the file's values with --unit (centimetres: --unit 0.01, feet: --unit 0.3048, \
         grey levels: the relief over the number of levels), or accept them with --any-relief", at[0], at[1]
    )]
    Relief {
        /// The middle (x, y) of the world, m.
        at: [f64; 2],
        /// The side of the world, m.
        side: f64,
        /// The highest height less the lowest one, m.
        relief: f64,
        /// The median slope, degrees.
        slope: f64,
    },
    /// The starts, obstacles or paths found no place on steep ground.
    #[error(
        "{source} (relief {relief:.1} m within {side} m, median slope {slope:.0} degrees: if that is too much, give the right unit with --unit)"
    )]
    Steep {
        source: Box<GenerateError>,
        /// The side of the world, m.
        side: f64,
        /// The highest height less the lowest one, m.
        relief: f64,
        /// The median slope, degrees.
        slope: f64,
    },
    #[error("the course needs a world of {needed} m; the maximum is {most} m: cut it into parts")]
    CourseLength {
        /// The side that holds the course, m.
        needed: f64,
        /// The longest side of a world, m.
        most: f64,
    },
    #[error("`side` is {side} m, but the course needs {needed} m: raise it (--site FILE), or omit --site")]
    CourseSide {
        /// The side of the rules, m.
        side: f64,
        /// The side that holds the course, m.
        needed: f64,
    },
    /// The starts, obstacles or paths found no place.
    #[error(transparent)]
    Generate(#[from] GenerateError),
}

/// What a site's rules are called, which has other places than the one where a world was to lie.
const FIELDS: Fields =
    Fields { elsewhere: " in the rules of --params; or use another position (--at)", ..generate::FIELDS };

/// Slope above which a world is no ground to drive on, if half of it is steeper, degrees. The benchmark's worlds have a median of 23
/// degrees at most.
const STEEPEST: f64 = 50.0;
/// Relief above which a world is no ground to drive on, in sides of it: its tangent is the steepest slope from edge to edge. The
/// benchmark's worlds have a fourteenth.
const HIGHEST: f64 = 1.2;
/// Median slope above which the unit may be the reason that nothing can start, degrees.
const STEEP: f64 = 20.0;

/// Room between a start and the edge of the world, m.
const MARGIN: f64 = 4.0;

/// The most worlds that are made of a survey: their names have three digits, and none wants to wait for more.
pub const MOST_WORLDS: usize = 999;

/// The worlds of a survey. Friction, obstacles, tasks and paths follow the generator's rules; what is drawn follows from the seed.
///
/// Heights are counted from the lowest place of each world. The numbers of obstacles are those of the generator's
/// world, in proportion to the area.
#[derive(Clone, Debug)]
pub struct Site<'a> {
    obstacles: Option<&'a [Obstacle]>,
    any_relief: bool,
    heights: Layout<'a>,
    labels: Option<Layout<'a>>,
    /// The middles of the worlds, m from that of the survey.
    centres: Vec<[f64; 2]>,
    density: Density,
    site: &'a SiteParams,
    rules: &'a GeneratorParams,
    seed: u64,
}

impl<'a> Site<'a> {
    /// Lays the worlds out.
    ///
    /// # Errors
    /// Returns an error if the survey is too small or has room for too many worlds, or its labels cover another rectangle.
    pub fn new(
        survey: &Survey<'a>,
        cut: Cut,
        density: Density,
        site: &'a SiteParams,
        rules: &'a GeneratorParams,
        seed: u64,
    ) -> Result<Self, SiteError> {
        let size = extents(survey.heights, survey.resolution);
        let finest = finest_path_grid(0.5 * site.side);
        if rules.path.grid < finest {
            return Err(SiteError::PathGrid { grid: rules.path.grid, side: site.side, finest });
        }
        let outside = |at: [f64; 2]| SiteError::Outside { at, side: site.side, extents: size };
        let centres = match cut {
            Cut::At(at) => vec![at],
            Cut::Tiles => tiles(size, site.side)?,
        };
        if centres.is_empty() {
            return Err(outside([0.0, 0.0]));
        }
        // Rounding must not push a world that just fits over the edge.
        let fits = |at: &[f64; 2], i: usize| at[i].abs() + 0.5 * site.side <= 0.5 * size[i] * (1.0 + 1e-12);
        if let Some(&at) = centres.iter().find(|at| !(fits(at, 0) && fits(at, 1))) {
            return Err(outside(at));
        }
        let heights = Layout::new(survey.heights, survey.resolution, site.resolution);
        let labels = survey.labels.map(|l| {
            let resolution = size[0] / l.cols() as f64;
            // The number of rows may be rounded.
            if (l.rows() as f64 * resolution - size[1]).abs() > resolution {
                return Err(SiteError::Labels { samples: [l.cols(), l.rows()], extents: size });
            }
            Ok(Layout::new(l, resolution, resolution))
        });
        let labels = labels.transpose()?;
        let Survey { obstacles, any_relief, .. } = *survey;
        Ok(Self { obstacles, any_relief, heights, labels, centres, density, site, rules, seed })
    }

    #[must_use]
    pub fn count(&self) -> usize {
        self.centres.len()
    }

    /// The names of the worlds with their middles, m east and north of that of the survey.
    pub fn centres(&self) -> impl Iterator<Item = (String, [f64; 2])> {
        self.centres.iter().enumerate().map(|(k, at)| (name(k), *at))
    }

    /// Makes the worlds, one after the other as they are asked for. Each is an error if the survey has a hole there, or leaves no
    /// room for tasks.
    pub fn worlds(&self) -> impl Iterator<Item = Result<World, SiteError>> {
        self.centres.iter().enumerate().map(|(k, &at)| {
            let place = Place { id: name(k), at, heights: &self.heights, labels: self.labels.as_ref() };
            self.world(&place)
        })
    }

    fn world(&self, place: &Place<'_>) -> Result<World, SiteError> {
        let Self { obstacles, density, site, rules, seed, .. } = *self;
        let stream = |part: &str| Stream::new(seed, &["site", &place.id, part]);
        let heightfield = surface(place, site)?;
        let slope = median_slope(&heightfield);
        let (low, high) = heightfield.range();
        let (at, side, relief) = (place.at, site.side, high - low);
        if !self.any_relief && (relief > HIGHEST * side || slope > STEEPEST) {
            return Err(SiteError::Relief { at, side, relief, slope });
        }
        let semantics = ground(place.labels, place.at, &heightfield, site, rules, &mut stream("ground"))?;
        let soft = semantics.classes.iter().filter(|c| c.is_deformable()).count();
        let terrain = match soft {
            0 => Terrain::Rigid,
            n if n == semantics.classes.len() => Terrain::Deformable,
            _ => Terrain::Mixed,
        };
        let mut world = World {
            elevation: level(&heightfield, rules),
            terrain,
            density,
            scale: 1.0,
            heightfield,
            semantics,
            obstacles: Vec::new(),
            tasks: Vec::new(),
            beds: Vec::new(),
            id: place.id.clone(),
        };
        let half = 0.5 * site.side;
        let radius = rules.tasks.radius.min(half - MARGIN).max(0.25 * half);
        let ratio = half / rules.half();
        let params =
            ObstacleParams { extent: rules.obstacles.extent * ratio, ..rules.obstacles.times(ratio * ratio) };
        if let Some(all) = obstacles {
            world.obstacles = within(all, place.at, half);
        }
        let TaskParams { count, stand, .. } = &rules.tasks;
        let starts = Starts::new(
            &world.heightfield,
            &world.semantics,
            &world.obstacles,
            rules.path.clearance,
            radius,
            stand,
        );
        let no_start = || GenerateError::NoStart {
            world: world.id.clone(),
            distance: 2.0 * radius,
            why: NoStarts::new(*count, starts.room(), &starts.broken, FIELDS),
        };
        let found = starts.ends(*count).ok_or_else(no_start);
        let made = found.and_then(|found| match obstacles {
            Some(_) => generate::plan_tasks(&mut world, &rules.path, &found.pairs),
            None => {
                generate::furnish(&mut world, &params, &rules.path, &found.pairs, &mut stream("obstacles"))
            }
        });
        match made {
            Ok(()) => Ok(world),
            Err(e) if slope > STEEP => Err(SiteError::Steep { source: Box::new(e), side, relief, slope }),
            Err(e) => Err(e.into()),
        }
    }
}

/// The name of a world by its number from 0 on.
fn name(k: usize) -> String {
    format!("w{:03}", k + 1)
}

/// Middles of squares that fit into a rectangle, from the north-west on.
fn tiles(size: [f64; 2], side: f64) -> Result<Vec<[f64; 2]>, SiteError> {
    let fitting = size.map(|s| (s / side * (1.0 + 1e-12)).floor());
    let worlds = fitting[0] * fitting[1];
    if worlds > MOST_WORLDS as f64 {
        return Err(SiteError::TooMany { worlds, side, extents: size });
    }
    let [columns, rows] = fitting.map(|n| n as usize);
    let middle = |k: usize, n: usize| (k as f64 - 0.5 * (n as f64 - 1.0)) * side;
    Ok((0..rows * columns).map(|i| [middle(i % columns, columns), -middle(i / columns, rows)]).collect())
}

/// Where a world is made.
struct Place<'a> {
    id: String,
    at: [f64; 2],
    heights: &'a Layout<'a>,
    labels: Option<&'a Layout<'a>>,
}

/// The ground, counted from its lowest place.
fn surface(place: &Place<'_>, site: &SiteParams) -> Result<Heightfield, SiteError> {
    let (nodes, half) = (site.nodes(), 0.5 * site.side);
    let mut heights = Vec::with_capacity(nodes * nodes);
    for row in 0..nodes {
        for col in 0..nodes {
            let at = [
                place.at[0] - half + col as f64 * site.resolution,
                place.at[1] - half + row as f64 * site.resolution,
            ];
            let z = place.heights.height(at);
            if !z.is_finite() {
                return Err(SiteError::Hole { at });
            }
            heights.push(z);
        }
    }
    Ok(counted_from_lowest(nodes, site.resolution, &heights, None))
}

/// Classes by labels about `middle` or by rules, friction by class as the generator draws it.
fn ground(
    labels: Option<&Layout<'_>>,
    middle: [f64; 2],
    surface: &Heightfield,
    site: &SiteParams,
    rules: &GeneratorParams,
    rng: &mut Stream,
) -> Result<Semantics, SiteError> {
    let (n, half) = (site.patches(), 0.5 * site.side);
    let (mut classes, mut friction) = (Vec::with_capacity(n * n), Vec::with_capacity(n * n));
    for row in 0..n {
        for col in 0..n {
            let corner = [col as f64 * site.patch - half, row as f64 * site.patch - half];
            let class = match labels {
                Some(labels) => majority(labels, middle, corner, site)?,
                None => by_rules(surface, corner, site),
            };
            classes.push(class);
            friction.push(generate::friction(&rules.ground.friction, class, rng));
        }
    }
    let present = |class, level| if classes.contains(&class) { level } else { Default::default() };
    let soil = vb_world::SoilLevels {
        mud: present(TerrainClass::Mud, site.ground.soil.mud),
        sand: present(TerrainClass::Sand, site.ground.soil.sand),
        snow: present(TerrainClass::Snow, site.ground.soil.snow),
    };
    Ok(Semantics { rows: n, cols: n, patch: site.patch, classes, friction, soil })
}

/// Middles of the cells of the grid in a patch.
fn cells(corner: [f64; 2], site: &SiteParams) -> impl Iterator<Item = [f64; 2]> + use<> {
    let (n, resolution) = ((site.patch / site.resolution).round() as usize, site.resolution);
    (0..n * n).map(move |i| {
        [corner[0] + ((i % n) as f64 + 0.5) * resolution, corner[1] + ((i / n) as f64 + 0.5) * resolution]
    })
}

/// The class that most of a patch has; of equally many that of the lowest label.
fn majority(
    labels: &Layout,
    middle: [f64; 2],
    corner: [f64; 2],
    site: &SiteParams,
) -> Result<TerrainClass, SiteError> {
    let mut counts: BTreeMap<u16, usize> = BTreeMap::new();
    for cell in cells(corner, site) {
        let at = [middle[0] + cell[0], middle[1] + cell[1]];
        let label = labels.nearest(at);
        let known = label.fract() == 0.0
            && (0.0..=f64::from(u16::MAX)).contains(&label)
            && site.ground.legend.contains_key(&(label as u16));
        if !known {
            return Err(SiteError::Label { label, at });
        }
        *counts.entry(label as u16).or_default() += 1;
    }
    let most = counts.iter().max_by_key(|(label, count)| (**count, std::cmp::Reverse(**label)));
    let class = most.and_then(|(label, _)| site.ground.legend.get(label));
    Ok(class.copied().unwrap_or(TerrainClass::Dirt))
}

fn by_rules(surface: &Heightfield, corner: [f64; 2], site: &SiteParams) -> TerrainClass {
    let (mut steepest, mut height, mut count) = (0.0_f64, 0.0, 0.0);
    for [x, y] in cells(corner, site) {
        steepest = steepest.max(slope(surface, [x, y]));
        height += surface.height(x, y);
        count += 1.0;
    }
    let rule = site.ground.rules.iter().find(|rule| rule.holds(steepest, height / count));
    // The last rule always holds.
    rule.map_or(TerrainClass::Dirt, |rule| rule.class)
}

/// Degrees.
fn slope(surface: &Heightfield, [x, y]: [f64; 2]) -> f64 {
    let [dx, dy] = surface.facet(x, y).gradient;
    vb_math::atan(vb_math::hypot(dx, dy)).to_degrees()
}

/// The obstacles in a world, from its middle.
fn within(all: &[Obstacle], middle: [f64; 2], half: f64) -> Vec<Obstacle> {
    let moved = |o: &Obstacle| Obstacle { x: o.x - middle[0], y: o.y - middle[1], ..*o };
    all.iter().map(moved).filter(|o| o.x.abs() <= half && o.y.abs() <= half).collect()
}
