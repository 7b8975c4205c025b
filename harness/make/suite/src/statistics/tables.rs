//! The figures as tables, for the terminal and the page alike.

use super::{CLEARANCE, OCTAVES, Roughness, SuiteStatistics, Summary, TaskFigures, WorldStatistics};
use vb_world::{Density, Elevation, Terrain};

/// The text of a cell that has no value.
pub const EMPTY: &str = "–";

/// A table of text: the first column names the row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    pub title: &'static str,
    /// A text on how its figures are meant.
    pub about: &'static str,
    /// The heads of the columns, with units.
    pub head: Vec<&'static str>,
    /// The rows, each with as many cells.
    pub rows: Vec<Vec<String>>,
}

/// A number with so many digits behind the point.
fn fixed(value: f64, digits: usize) -> String {
    format!("{value:.digits$}")
}

fn percent(fraction: f64) -> String {
    format!("{:.1}", 100.0 * fraction)
}

fn or_empty<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or_else(|| EMPTY.to_owned(), text)
}

fn count(n: usize) -> String {
    if n == 0 { EMPTY.to_owned() } else { n.to_string() }
}

impl SuiteStatistics {
    /// All tables but that of the worlds.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        let mut tables =
            vec![self.labels(), self.surfaces(), self.roughness(), self.ground(), self.obstacle_table()];
        tables.extend(self.tasks.as_ref().map(task_table));
        if !self.tasks_by_density.is_empty() {
            tables.push(self.paths());
        }
        tables.extend(self.proof.as_ref().map(|_| self.proven()));
        tables
    }

    #[must_use]
    pub fn world_table(&self) -> Table {
        Table {
            title: "Worlds",
            about: "Slope over 1 m; detour: mean of path length over straight distance.",
            head: vec![
                "world",
                "elevation",
                "terrain",
                "density",
                "std m",
                "relief m",
                "slope p95 °",
                "obstacles",
                "tasks",
                "detour",
                "clearance m",
            ],
            rows: self.worlds.iter().map(world_row).collect(),
        }
    }

    fn labels(&self) -> Table {
        let number = |of: &dyn Fn(Elevation, Terrain, Density) -> bool| {
            let cells = self.cells.iter().filter(|c| of(c.elevation, c.terrain, c.density));
            count(cells.map(|c| c.worlds).sum())
        };
        let mut rows = Vec::new();
        for e in Elevation::ALL {
            for t in Terrain::ALL {
                let mut row = vec![e.name().to_owned(), t.name().to_owned()];
                row.extend(Density::ALL.map(|d| number(&|a, b, c| (a, b, c) == (e, t, d))));
                row.push(number(&|a, b, _| (a, b) == (e, t)));
                rows.push(row);
            }
        }
        let mut row = vec!["all".to_owned(), String::new()];
        row.extend(Density::ALL.map(|d| number(&|_, _, c| c == d)));
        row.push(self.world_count.to_string());
        rows.push(row);
        Table {
            title: "Worlds by label",
            about: "Number of worlds of each elevation, terrain and obstacle density; a dash marks a combination without worlds.",
            head: vec!["elevation", "terrain", "sparse", "medium", "dense", "all"],
            rows,
        }
    }

    fn proven(&self) -> Table {
        let cell = |of: &dyn Fn(&WorldStatistics) -> bool| {
            let tasks = || self.worlds.iter().filter(|w| of(w)).flat_map(|w| &w.tasks);
            match tasks().count() {
                0 => EMPTY.to_owned(),
                n => format!("{}/{n}", tasks().filter(|t| t.proven == Some(true)).count()),
            }
        };
        let row = |name: &str, level: &dyn Fn(&WorldStatistics) -> bool| {
            let mut row = vec![name.to_owned()];
            row.extend(Terrain::ALL.map(|t| cell(&|w| level(w) && w.terrain == t)));
            row.push(cell(level));
            row
        };
        let mut rows: Vec<_> = Elevation::ALL.iter().map(|e| row(e.name(), &|w| w.elevation == *e)).collect();
        rows.push(row("all", &|_| true));
        Table {
            title: "Tasks with solvability certificates",
            about: "Tasks with a certificate, of all tasks, by elevation and terrain; the others may be unsolvable.",
            head: vec!["elevation", "rigid", "deformable", "mixed", "all"],
            rows,
        }
    }

    fn surfaces(&self) -> Table {
        let rows = self.relief.iter().map(|r| {
            let mut row = vec![r.elevation.name().to_owned(), r.height_std.count.to_string()];
            row.extend([r.height_std.mean, r.height_std.min, r.height_std.max].map(|v| fixed(v, 3)));
            row.extend([r.relief.mean, r.relief.max].map(|v| fixed(v, 2)));
            row.extend([r.slopes.p50, r.slopes.p95, r.slopes.p99, r.slopes.max].map(|v| fixed(v, 1)));
            row
        });
        Table {
            title: "Surface",
            about: "Standard deviation of height within a world (mean, minimum and maximum over worlds), relief from the lowest \
                    to the highest node, and percentiles of slope over 1 m.",
            head: vec![
                "elevation",
                "worlds",
                "std m",
                "min",
                "max",
                "relief m",
                "max",
                "slope p50 °",
                "p95",
                "p99",
                "max",
            ],
            rows: rows.collect(),
        }
    }

    fn roughness(&self) -> Table {
        let row = |name: &str, value: &dyn Fn(&Roughness) -> Option<String>| {
            let cells = Elevation::ALL.map(|e| {
                let level = self.relief.iter().find(|r| r.elevation == e);
                or_empty(level.and_then(|r| value(&r.roughness)), |text| text)
            });
            std::iter::once(name.to_owned()).chain(cells).collect::<Vec<_>>()
        };
        let mm = |v: f64| Some(fixed(1e3 * v, 1));
        let degrees = |v: f64| Some(fixed(v, 1));
        let mut rows = Vec::new();
        for (k, edges) in OCTAVES.windows(2).enumerate() {
            let name = format!("RMS height, waves of {} to {} m, mm", edges[0], edges[1]);
            rows.push(row(&name, &|r| r.octaves[k].and_then(mm)));
        }
        rows.push(row("RMS second difference over 1 m, mm", &|r| mm(r.second_difference)));
        rows.push(row("RMS twist of 1 m squares, mm", &|r| mm(r.twist)));
        let belly = format!("poses with belly contact ({CLEARANCE} m), %");
        rows.push(row(&belly, &|r| r.belly.map(|b| fixed(100.0 * b, 2))));
        rows.push(row("break-over p50, °", &|r| degrees(r.break_over.p50)));
        rows.push(row("break-over p95, °", &|r| degrees(r.break_over.p95)));
        rows.push(row("break-over p99, °", &|r| degrees(r.break_over.p99)));
        rows.push(row("facet slope p50, °", &|r| degrees(r.facets.p50)));
        rows.push(row("facet slope p95, °", &|r| degrees(r.facets.p95)));
        rows.push(row("facet slope p99, °", &|r| degrees(r.facets.p99)));
        Table {
            title: "Roughness",
            about: "By elevation level: height within octaves of wavelength; second differences and twists; random poses of an HMMWV on its \
                    four wheels; the angle between the terrain over the metre behind and the metre ahead of a point; slopes of facets.",
            head: vec!["figure", "low", "medium", "high"],
            rows,
        }
    }

    fn ground(&self) -> Table {
        let rows = self.classes.iter().map(|c| {
            let mut row = vec![c.class.name().to_owned(), percent(c.fraction), c.worlds.to_string()];
            let friction = c.friction.map(|f| [f.mean, f.std, f.min, f.max]);
            row.extend((0..4).map(|k| or_empty(friction, |f| fixed(f[k], 3))));
            row.extend((0..3).map(|k| or_empty(c.soil, |s| s[k].to_string())));
            row
        });
        Table {
            title: "Ground",
            about: "Area fraction and number of worlds of each class; friction over the area; number of worlds with \
                    soft, medium or hard soil.",
            head: vec![
                "class", "area %", "worlds", "friction", "std", "min", "max", "soft", "medium", "hard",
            ],
            rows: rows.collect(),
        }
    }

    fn obstacle_table(&self) -> Table {
        let rows = self.obstacles.iter().map(|o| {
            let mut row = vec![o.density.name().to_owned(), o.worlds.to_string()];
            row.extend([o.kinds.boulders, o.kinds.boxes, o.kinds.trunks].map(count));
            row.push(fixed(o.per_world.mean, 1));
            for s in [o.width, o.height] {
                row.extend([s.map(|s| s.mean), s.map(|s| s.max)].map(|v| or_empty(v, |v| fixed(v, 2))));
            }
            row.push(percent(o.covered.mean));
            row
        });
        Table {
            title: "Obstacles",
            about: "All obstacles of the worlds of a density; width (the larger one) and height above the terrain of boulders \
                    and boxes; area fraction that they cover.",
            head: vec![
                "density",
                "worlds",
                "boulders",
                "boxes",
                "trunks",
                "per world",
                "width m",
                "max",
                "height m",
                "max",
                "covered %",
            ],
            rows: rows.collect(),
        }
    }

    fn paths(&self) -> Table {
        let rows = self.tasks_by_density.iter().map(|(density, t)| {
            let mut row = vec![density.name().to_owned(), t.length.count.to_string()];
            row.extend([t.length.mean, t.length.p95, t.length.max].map(|v| fixed(v, 1)));
            row.extend([t.ratio.mean, t.ratio.max].map(|v| fixed(v, 3)));
            let clearance = t.clearance.map(|c| [c.min, c.mean, c.max]);
            row.extend((0..3).map(|k| or_empty(clearance, |c| fixed(c[k], 2))));
            row
        });
        Table {
            title: "Paths by density",
            about: "Length of the global paths, their length over the straight distance (detour), and their minimum distance to \
                    an obstacle.",
            head: vec![
                "density",
                "tasks",
                "length m",
                "p95",
                "max",
                "detour",
                "max",
                "clearance min m",
                "mean",
                "max",
            ],
            rows: rows.collect(),
        }
    }
}

fn task_table(t: &TaskFigures) -> Table {
    let row = |name: &str, s: Summary, digits| {
        let figures = [s.min, s.mean, s.p50, s.p95, s.max].map(|v| fixed(v, digits));
        std::iter::once(name.to_owned()).chain(figures).collect()
    };
    let mut rows = vec![
        row("straight distance, m", t.straight, 1),
        row("path length, m", t.length, 1),
        row("length / straight", t.ratio, 3),
    ];
    rows.extend(t.clearance.map(|c| row("clearance, m", c, 2)));
    rows.push(row("ascent, m", t.ascent, 1));
    rows.push(row("steepest, °", t.steepest, 1));
    Table {
        title: "Tasks",
        about: "Over all tasks: straight distance from start to goal, global path, its minimum distance to an obstacle, its total \
                ascent and its maximum grade between waypoints.",
        head: vec!["figure", "min", "mean", "p50", "p95", "max"],
        rows,
    }
}

fn world_row(w: &WorldStatistics) -> Vec<String> {
    let ratio = Summary::of(w.tasks.iter().map(|t| t.ratio));
    let clearance = Summary::of(w.tasks.iter().filter_map(|t| t.clearance));
    vec![
        w.id.clone(),
        w.elevation.name().to_owned(),
        w.terrain.name().to_owned(),
        w.density.name().to_owned(),
        fixed(w.height_std, 3),
        fixed(w.relief, 2),
        fixed(w.slopes.p95, 1),
        w.obstacles.total().to_string(),
        w.tasks.len().to_string(),
        or_empty(ratio, |r| fixed(r.mean, 3)),
        or_empty(clearance, |c| fixed(c.min, 2)),
    ]
}
