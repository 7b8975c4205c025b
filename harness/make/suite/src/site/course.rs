//! A world of a course: a square about it, with a task along its reference line.

use vb_math::rng::Stream;
use vb_math::{cos, sin};
use vb_terrain::Course;
use vb_world::{Density, Obstacle, Pose2, Task, Terrain, TerrainClass, World};

use super::{GroundRule, SiteError, SiteGround, SiteParams, ground, within};
use crate::generate::{GenerateError, GeneratorParams, millimetres};
use crate::level::level;
use crate::rules::MOST_NODES;
use crate::surface::counted_from_lowest;

/// The room between an end of the course and the edge of the world, m: a vehicle that starts or ends there fits into it.
const MARGIN: f64 = 8.0;
/// The most nodes along a side of a world whose grid is chosen here: worlds of the benchmark have some hundreds.
const NODES: f64 = 2560.0;

/// A world of a course. Beyond the course its ground goes on as the borders are; the course has its own heading, so its x is the
/// world's, from the middle of the course's extents.
#[derive(Clone, Debug)]
pub struct CourseSite<'a> {
    course: &'a Course,
    obstacles: &'a [Obstacle],
    density: Density,
    site: SiteParams,
    rules: &'a GeneratorParams,
    seed: u64,
    /// The middle of the world in the coordinates of the course, m.
    middle: [f64; 2],
}

impl<'a> CourseSite<'a> {
    /// Chooses the grid, or takes that of `site`.
    ///
    /// Without rules of the user's the side is the least multiple of a patch that holds the course and 8 m about it; nodes are as
    /// near to each other as the course's lateral cuts if 2561 along a side are enough, else 2, 4, ... times as far; and the ground
    /// is concrete.
    ///
    /// # Errors
    /// Returns an error if the course does not fit into the world, or is too long for one.
    pub fn new(
        course: &'a Course,
        obstacles: &'a [Obstacle],
        density: Density,
        site: Option<&SiteParams>,
        rules: &'a GeneratorParams,
        seed: u64,
    ) -> Result<Self, SiteError> {
        let [low, high] = course.extents();
        let needed = (high[0] - low[0]).max(high[1] - low[1]) + 2.0 * MARGIN;
        let site = match site {
            Some(site) if site.side < needed => {
                return Err(SiteError::CourseSide { side: site.side, needed });
            }
            Some(site) => site.clone(),
            None => fitting(course, needed)?,
        };
        let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        Ok(Self { course, obstacles, density, site, rules, seed, middle })
    }

    /// The side of the world, m.
    #[must_use]
    pub fn side(&self) -> f64 {
        self.site.side
    }

    /// The distance between the nodes of the world, m.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.site.resolution
    }

    /// The name of the rules for the ground.
    #[must_use]
    pub fn rules(&self) -> &str {
        &self.site.name
    }

    /// Makes the world.
    ///
    /// # Errors
    /// Returns an error if the rules or the obstacles make a world that is not valid.
    pub fn world(&self) -> Result<World, SiteError> {
        let Self { course, obstacles, density, site, rules, seed, middle } = self;
        let id = super::name(0);
        let (nodes, half) = (site.nodes(), 0.5 * site.side);
        let place = |k: usize| k as f64 * site.resolution - half;
        let at = |i: usize| [middle[0] + place(i % nodes), middle[1] + place(i / nodes)];
        let heights: Vec<f64> = (0..nodes * nodes).map(|i| course.height_at(at(i))).collect();
        let heightfield = counted_from_lowest(nodes, site.resolution, &heights, None);
        let mut rng = Stream::new(*seed, &["site", &id, "ground"]);
        let semantics = ground(None, [0.0; 2], &heightfield, site, rules, &mut rng)?;
        let soft = semantics.classes.iter().filter(|c| c.is_deformable()).count();
        let terrain = match soft {
            0 => Terrain::Rigid,
            n if n == semantics.classes.len() => Terrain::Deformable,
            _ => Terrain::Mixed,
        };
        let world = World {
            elevation: level(&heightfield, rules),
            terrain,
            density: *density,
            scale: 1.0,
            heightfield,
            semantics,
            obstacles: within(obstacles, [0.0; 2], half),
            tasks: vec![self.task()],
            beds: Vec::new(),
            id: id.clone(),
        };
        world.check().map_err(|flaw| GenerateError::World { world: id, flaw })?;
        Ok(world)
    }

    /// From the start of the reference line to its end, or beside it in the middle of a course that does not contain it.
    fn task(&self) -> Task {
        let [right, left] = self.course.borders();
        let beside = if right <= 0.0 && left >= 0.0 { 0.0 } else { 0.5 * (right + left) };
        let [from, to] = self.course.span();
        let point = |u: f64| {
            let ([x, y], heading) = self.course.position(u);
            let moved =
                [x - beside * sin(heading) - self.middle[0], y + beside * cos(heading) - self.middle[1]];
            moved.map(millimetres)
        };
        // Waypoints that are rounded must not be farther apart than the rules say.
        let pieces = ((to - from) / (0.99 * self.rules.path.spacing)).ceil().max(1.0) as usize;
        let mut path: Vec<[f64; 2]> =
            (0..=pieces).map(|k| point(from + (to - from) * k as f64 / pieces as f64)).collect();
        path.dedup();
        let (start, goal) = (path[0], path[path.len() - 1]);
        let yaw = self.course.position(from).1;
        Task { id: "t00".into(), start: Pose2 { x: start[0], y: start[1], yaw }, goal, path }
    }
}

/// The grid of a world for a course that needs this side, m, on concrete.
fn fitting(course: &Course, needed: f64) -> Result<SiteParams, SiteError> {
    let own = SiteParams::default();
    let side = (needed / own.patch).ceil() * own.patch;
    let most = (MOST_NODES - 1) as f64 * own.resolution;
    if side > most {
        return Err(SiteError::CourseLength { needed, most });
    }
    // Halves of the usual distance divide the patch.
    let mut resolution = own.resolution;
    while resolution > course.increment() && 2.0 * side / resolution <= NODES {
        resolution *= 0.5;
    }
    let concrete = GroundRule { class: TerrainClass::Concrete, ..GroundRule::ALWAYS };
    let ground = SiteGround { rules: vec![concrete], ..own.ground };
    Ok(SiteParams { name: "course".into(), resolution, side, ground, ..own })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_lies_in_the_middle_of_its_world_with_a_task_along_it() {
        // 50 m with a ramp of 0.1 from 10 to 30 m.
        let heights: Vec<f64> =
            (0..=200).map(|k| 0.1 * (0.25 * f64::from(k) - 10.0).clamp(0.0, 20.0)).collect();
        let course = Course::straight(0.25, 2.0, &heights);
        let rules = GeneratorParams::default();
        let site = CourseSite::new(&course, &[], Density::Sparse, None, &rules, 7).unwrap();
        // 50 m and twice 8 m need 9 patches of 8 m.
        assert_eq!((site.side(), site.resolution()), (72.0, 0.25));
        let world = site.world().unwrap();
        for (x, z) in [(-36.0, 0.0), (-15.0, 0.0), (-5.0, 1.0), (5.0, 2.0), (36.0, 2.0)] {
            for y in [-30.0, 0.0, 1.0, 36.0] {
                let own = world.heightfield.height(x, y);
                assert!((own - z).abs() < 1e-3, "{x} {y}: {own}, not {z}");
            }
        }
        assert!(world.semantics.classes.iter().all(|c| *c == TerrainClass::Concrete));
        let task = &world.tasks[0];
        assert_eq!((task.start, task.goal), (Pose2 { x: -25.0, y: 0.0, yaw: 0.0 }, [25.0, 0.0]));
        assert!(task.path.windows(2).all(|w| w[1][0] - w[0][0] <= rules.path.spacing && w[1][1] == 0.0));
    }

    #[test]
    fn a_course_that_does_not_fit_is_refused() {
        let course = Course::straight(10.0, 2.0, &[0.0; 501]);
        let rules = GeneratorParams::default();
        let made = |site: Option<&SiteParams>| {
            CourseSite::new(&course, &[], Density::Sparse, site, &rules, 7).unwrap_err().to_string()
        };
        assert!(made(None).contains("needs a world of 5016 m; the maximum is 4096 m"), "{}", made(None));
        let own = SiteParams::default();
        assert!(
            made(Some(&own)).contains("`side` is 128 m, but the course needs 5016 m"),
            "{}",
            made(Some(&own))
        );
    }
}
