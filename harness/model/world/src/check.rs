//! The conditions that a world must satisfy, wherever it comes from.

use crate::{Obstacle, ObstacleKind, Semantics, Task, Terrain, World, geometry};
use std::collections::BTreeSet;

/// The part of a world that a flaw is in; each is a file on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The name, the labels and the grid: `world.yaml`.
    World,
    /// The heights: `elevation.png`.
    Elevation,
    /// The classes and the friction: `semantics.yaml`.
    Semantics,
    /// The obstacles: `obstacles.yaml`.
    Obstacles,
    /// The tasks: `tasks.yaml`.
    Tasks,
    /// The granular beds: `beds.yaml`, which a world without beds doesn't have.
    Beds,
}

impl Part {
    /// All parts, in the order in which they are hashed.
    pub const ALL: [Self; 6] =
        [Self::World, Self::Elevation, Self::Semantics, Self::Obstacles, Self::Tasks, Self::Beds];

    /// The name of the file that holds the part.
    #[must_use]
    pub fn file_name(self) -> &'static str {
        match self {
            Self::World => "world.yaml",
            Self::Elevation => "elevation.png",
            Self::Semantics => "semantics.yaml",
            Self::Obstacles => "obstacles.yaml",
            Self::Tasks => "tasks.yaml",
            Self::Beds => "beds.yaml",
        }
    }
}

/// A flaw of a world: where it is, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {field}: {problem}", part.file_name())]
pub struct Flaw {
    /// The part in which the flaw is.
    pub part: Part,
    /// The field within the part, e.g. `tasks[2].goal`.
    pub field: String,
    /// The value, what is wrong with it, and what would be right.
    pub problem: String,
}

impl Flaw {
    pub(crate) fn new(part: Part, field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { part, field: field.into(), problem: problem.into() }
    }
}

/// Largest number of nodes along one side of a heightfield; keeps a typing error from filling the memory.
pub(crate) const MAX_SIDE: usize = 8193;

/// Largest Coulomb coefficient a patch may have. Dry rubber on dry rock stays below 1.5.
const MAX_FRICTION: f64 = 2.0;

/// The least and the greatest size of an obstacle at full scale, m: a smaller one has no faces that numbers tell apart.
const OBSTACLE_SIZES: [f64; 2] = [1e-3, 1e3];

/// Largest distance from the ground at its centre to an obstacle that hangs above it or lies wholly below it, m at
/// scale 1. The original's data have both, by 2.8 m at most (measured over its 100 worlds); more is a typing error.
const MAX_GAP: f64 = 10.0;

/// How far a path may begin from the start and end from the goal, m: what rounding to millimetres costs.
const PATH_END_TOLERANCE: f64 = 1.5e-3;

/// Checks that an id can be a folder's name and part of a selector on every system.
pub(crate) fn check_id(id: &str) -> Result<(), String> {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if id.is_empty() || id.len() > 32 || !id.chars().all(good) {
        return Err(format!("{id:?} is not an id: use 1 to 32 of a-z, 0-9 and _"));
    }
    Ok(())
}

impl World {
    /// Checks everything that the rest of the product relies on: finite and sensible numbers, counts that agree, and
    /// tasks that lie in the world, off its obstacles, and whose path leads from start to goal.
    ///
    /// # Errors
    /// Returns the first flaw found, in the order world, elevation, semantics, obstacles, tasks, beds.
    pub fn check(&self) -> Result<(), Flaw> {
        self.check_ground()?;
        for (k, o) in self.obstacles.iter().enumerate() {
            self.check_obstacle(k, o)?;
        }
        let outlines = self.outlines();
        let mut ids = BTreeSet::new();
        self.tasks
            .iter()
            .enumerate()
            .try_for_each(|(k, task)| self.check_task(k, task, &outlines, &mut ids))?;
        self.check_beds()
    }

    /// All flaws that [`World::check`] would find if each were mended before the next: the first flaw of name, heights
    /// and ground, the first one of every obstacle and task, and that of the beds.
    #[must_use]
    pub fn flaws(&self) -> Vec<Flaw> {
        let obstacles = self.obstacles.iter().enumerate();
        let obstacles: Vec<Flaw> = obstacles.filter_map(|(k, o)| self.check_obstacle(k, o).err()).collect();
        let mut tasks = Vec::new();
        // An obstacle with a flaw may have no footprint that tasks could be held against.
        if obstacles.is_empty() {
            let outlines = self.outlines();
            let mut ids = BTreeSet::new();
            for (k, task) in self.tasks.iter().enumerate() {
                tasks.extend(self.check_task(k, task, &outlines, &mut ids).err());
            }
        }
        let ground = self.check_ground().err();
        // Beds lie on patches and heights.
        let beds = if ground.is_none() { self.check_beds().err() } else { None };
        ground.into_iter().chain(obstacles).chain(tasks).chain(beds).collect()
    }

    fn outlines(&self) -> Vec<Vec<[f64; 2]>> {
        self.obstacles.iter().map(Obstacle::footprint).collect()
    }

    fn check_ground(&self) -> Result<(), Flaw> {
        check_id(&self.id).map_err(|p| Flaw::new(Part::World, "id", p))?;
        if !(self.scale.is_finite() && self.scale > 0.0) {
            return Err(Flaw::new(Part::World, "scale", format!("{} is not a positive number", self.scale)));
        }
        self.check_elevation()?;
        self.check_semantics()
    }

    fn check_elevation(&self) -> Result<(), Flaw> {
        let h = &self.heightfield;
        if let Some(i) = h.heights().iter().position(|z| !z.is_finite()) {
            let field = format!("node at row {}, column {} from the south-west", i / h.cols(), i % h.cols());
            return Err(Flaw::new(
                Part::Elevation,
                field,
                format!("height {} is not a finite number", h.heights()[i]),
            ));
        }
        Ok(())
    }

    fn check_semantics(&self) -> Result<(), Flaw> {
        let flaw = |field: String, problem| Err(Flaw::new(Part::Semantics, field, problem));
        let s = &self.semantics;
        let count = s.rows * s.cols;
        if count == 0 || s.classes.len() != count || s.friction.len() != count {
            return flaw(
                "classes".into(),
                format!(
                    "{} classes and {} friction values do not fill {} x {} patches",
                    s.classes.len(),
                    s.friction.len(),
                    s.rows,
                    s.cols
                ),
            );
        }
        for (side, n, extent) in [
            ("columns", s.cols, 2.0 * self.heightfield.half_x()),
            ("rows", s.rows, 2.0 * self.heightfield.half_y()),
        ] {
            let covered = n as f64 * s.patch;
            if !(s.patch > 0.0 && (covered - extent).abs() <= 1e-9 * extent) {
                let patch = s.patch;
                return flaw(
                    "patch".into(),
                    format!(
                        "{n} {side} of {patch} m cover {covered} m, but the world measures {extent} m: they must agree"
                    ),
                );
            }
        }
        for i in 0..count {
            let (class, mu) = (s.classes[i], s.friction[i]);
            let field = || patch_field("friction", s, i);
            if class.is_deformable() && mu != 0.0 {
                let name = class.name();
                return flaw(
                    field(),
                    format!("{mu} on {name}: deformable patches carry 0, their grip comes from the soil"),
                );
            }
            let grips = mu > 0.0 && mu <= MAX_FRICTION;
            if !class.is_deformable() && !grips {
                return flaw(field(), format!("{mu} on {}: must lie in (0, {MAX_FRICTION}]", class.name()));
            }
            let excluded = match self.terrain {
                Terrain::Rigid => class.is_deformable(),
                Terrain::Deformable => !class.is_deformable(),
                Terrain::Mixed => false,
            };
            if excluded {
                return flaw(
                    patch_field("classes", s, i),
                    format!(
                        "{} does not belong in a world whose ground is {}",
                        class.name(),
                        self.terrain.name()
                    ),
                );
            }
        }
        let yielding = s.classes.iter().filter(|c| c.is_deformable()).count();
        if self.terrain == Terrain::Mixed && (yielding == 0 || yielding == count) {
            let kind = if yielding == 0 { "rigid" } else { "deformable" };
            return flaw(
                "classes".into(),
                format!("all are {kind}, but the world's ground is mixed: name it {kind}"),
            );
        }
        Ok(())
    }

    fn check_obstacle(&self, k: usize, o: &Obstacle) -> Result<(), Flaw> {
        let flaw =
            |name: &str, problem| Err(Flaw::new(Part::Obstacles, format!("obstacles[{k}]{name}"), problem));
        if !(o.x.is_finite() && o.y.is_finite() && self.heightfield.contains(o.x, o.y)) {
            return flaw("", format!("centre [{:?}, {:?}] {}", o.x, o.y, self.outside()));
        }
        if !o.yaw.is_finite() {
            return flaw(".yaw", format!("{} is not a finite angle in radians", o.yaw));
        }
        let height = o.size()[2];
        let [least, most] = OBSTACLE_SIZES.map(|size| size * self.scale);
        let sizes = least..=most;
        match o.kind {
            ObstacleKind::Boulder { size, .. } | ObstacleKind::Box { size } => {
                if !size.iter().all(|l| sizes.contains(l)) {
                    let lengths = format!("three lengths from {least} to {most} m");
                    return flaw(".size", format!("{size:?} must be {lengths}"));
                }
            }
            ObstacleKind::Trunk { radius, height } => {
                for (name, value) in [(".radius", radius), (".height", height)] {
                    if !sizes.contains(&value) {
                        return flaw(name, format!("{value} must be a length from {least} to {most} m"));
                    }
                }
            }
        }
        let [low, high] = [-MAX_GAP * self.scale, height + MAX_GAP * self.scale];
        if !(o.buried >= low && o.buried <= high) {
            return flaw(
                ".buried",
                format!("{} must lie in [{low}, {high}] m for an obstacle {height} m high", o.buried),
            );
        }
        Ok(())
    }

    fn check_task<'a>(
        &self,
        k: usize,
        task: &'a Task,
        outlines: &[Vec<[f64; 2]>],
        ids: &mut BTreeSet<&'a str>,
    ) -> Result<(), Flaw> {
        let flaw = |name: &str, problem| Err(Flaw::new(Part::Tasks, format!("tasks[{k}].{name}"), problem));
        if let Err(problem) = check_id(&task.id) {
            return flaw("id", problem);
        }
        if !ids.insert(task.id.as_str()) {
            return flaw("id", format!("{:?} is used twice in this world: give each task its own", task.id));
        }
        if !(task.start.yaw.is_finite() && task.start.yaw.abs() <= 2.0 * std::f64::consts::PI) {
            let yaw = task.start.yaw;
            return flaw("start.yaw", format!("{yaw} must be an angle in radians within one turn"));
        }
        let start = [task.start.x, task.start.y];
        for (name, p) in [("start", start), ("goal", task.goal)] {
            if !self.has(p) {
                return flaw(name, format!("{p:?} {}", self.outside()));
            }
            if let Some(hit) = outlines.iter().position(|o| geometry::contains(o, p)) {
                return flaw(name, format!("{p:?} lies inside obstacles[{hit}]: move one of them"));
            }
        }
        if start == task.goal {
            return flaw("goal", format!("{start:?} is also the start: there is nothing to drive"));
        }
        if let Some(i) = task.path.iter().position(|&p| !self.has(p)) {
            return flaw(&format!("path[{i}]"), format!("{:?} {}", task.path[i], self.outside()));
        }
        let (Some(&first), Some(&last)) = (task.path.first(), task.path.last()) else {
            return flaw("path", "is empty: it must lead from the start to the goal".into());
        };
        for (name, p, end) in [("start", first, start), ("goal", last, task.goal)] {
            if vb_math::hypot(p[0] - end[0], p[1] - end[1]) > PATH_END_TOLERANCE * self.scale {
                let end_name = if name == "start" { "begins" } else { "ends" };
                return flaw(
                    "path",
                    format!("{end_name} at {p:?}, but the {name} is {end:?}: they must agree"),
                );
            }
        }
        Ok(())
    }

    fn has(&self, p: [f64; 2]) -> bool {
        p[0].is_finite() && p[1].is_finite() && self.heightfield.contains(p[0], p[1])
    }

    pub(crate) fn outside(&self) -> String {
        let (x, y) = (self.heightfield.half_x(), self.heightfield.half_y());
        if x == y {
            return format!("lies outside the world (±{x} m)");
        }
        format!("lies outside the world (x ±{x} m, y ±{y} m)")
    }
}

/// Names a patch as it stands in the file, north row first.
fn patch_field(list: &str, s: &Semantics, index: usize) -> String {
    format!("{list}[{}][{}]", s.rows - 1 - index / s.cols, index % s.cols)
}
