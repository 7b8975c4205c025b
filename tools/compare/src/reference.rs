//! The recorded runs of Project Chrono: `w{world}_{pair}.txt`, one line a run, or one table of many runs.

use std::fmt;
use std::path::{Path, PathBuf};

use vb_world::{Elevation, Terrain};

use crate::CompareError;

/// Grounds, in the order of tables.
pub(crate) const GROUNDS: [Terrain; 3] = [Terrain::Rigid, Terrain::Mixed, Terrain::Deformable];

/// How a recorded run ended, by the released code's rules; falling off the map is the recorder's own addition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Success,
    Stuck,
    Timeout,
    FellOffMap,
}

impl End {
    fn named(name: &str) -> Option<Self> {
        match name {
            "success" => Some(Self::Success),
            "stuck" => Some(Self::Stuck),
            "timeout" => Some(Self::Timeout),
            "fell_off_map" => Some(Self::FellOffMap),
            _ => None,
        }
    }
}

/// What a record may say in these columns.
const ENDS: &str = "success, stuck, timeout or fell_off_map";
const LEVELS: &str = "low, mid or high";
const TERRAINS: &str = "rigid, deformable or mixed";

fn level(name: &str) -> Option<Elevation> {
    match name {
        "low" => Some(Elevation::Low),
        "mid" => Some(Elevation::Medium),
        "high" => Some(Elevation::High),
        _ => None,
    }
}

fn ground(name: &str) -> Option<Terrain> {
    Terrain::ALL.into_iter().find(|t| t.name() == name)
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Success => "success",
            Self::Stuck => "stuck",
            Self::Timeout => "timeout",
            Self::FellOffMap => "fell off",
        })
    }
}

/// One recorded run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Run {
    /// The original's number of the world.
    pub(crate) world: u32,
    /// The original's number of the pair of start and goal.
    pub(crate) pair: usize,
    pub(crate) elevation: Elevation,
    pub(crate) terrain: Terrain,
    pub(crate) end: End,
    /// Simulated time at its end, s.
    pub(crate) time: f64,
    /// Mean of |roll| over all steps, degrees.
    pub(crate) roll: f64,
    /// Mean of |pitch| over all steps, degrees.
    pub(crate) pitch: f64,
    /// Distance from the goal marker at its end, m.
    pub(crate) goal_distance: f64,
    /// |roll| at its end, degrees; none where the record doesn't tell.
    pub(crate) roll_end: Option<f64>,
    /// Processor time a simulated second, s.
    pub(crate) cost: f64,
}

impl Run {
    /// Name of the task in an imported suite.
    pub(crate) fn task(&self) -> String {
        format!("{}/{}", self.world_id(), self.task_id())
    }

    /// Name of the world in an imported suite.
    pub(crate) fn world_id(&self) -> String {
        format!("w{:03}", self.world)
    }

    /// Name of the task in its world.
    pub(crate) fn task_id(&self) -> String {
        format!("t{:02}", self.pair)
    }
}

fn read(file: &Path) -> Result<String, CompareError> {
    std::fs::read_to_string(file).map_err(|source| CompareError::Io { path: file.into(), source })
}

fn number(file: &Path, line: usize, cells: &[&str], column: usize) -> Result<f64, CompareError> {
    let text = cells.get(column).copied().unwrap_or_default();
    let value = text.parse().ok().filter(|v: &f64| v.is_finite());
    value.ok_or_else(|| {
        CompareError::reference(file, line, format!("column {}: {text:?} is not a number", column + 1))
    })
}

/// Names of the wheels in a time series, in the order of a vehicle's, and the radius of each, m.
pub(crate) const WHEELS: [&str; 4] = ["FL", "FR", "RL", "RR"];
pub(crate) const RADIUS: f64 = 0.467;

/// The files of a folder with this extension, by name.
pub(crate) fn files(dir: &Path, extension: &str) -> Result<Vec<PathBuf>, CompareError> {
    let io = |source| CompareError::Io { path: dir.into(), source };
    let entries = std::fs::read_dir(dir).map_err(io)?;
    let mut files: Vec<PathBuf> = entries.map(|e| Ok(e?.path())).collect::<Result<_, _>>().map_err(io)?;
    files.retain(|f| f.extension().is_some_and(|e| e == extension));
    files.sort();
    Ok(files)
}

/// All recorded runs in `dir`, by ground, elevation, world and pair.
pub(crate) fn runs(dir: &Path) -> Result<Vec<Run>, CompareError> {
    let mut runs = Vec::new();
    for file in files(dir, "txt")? {
        runs.push(parse(&file, &read(&file)?)?);
    }
    sort(&mut runs);
    Ok(runs)
}

fn sort(runs: &mut [Run]) {
    runs.sort_by_key(|r| (GROUNDS.iter().position(|t| *t == r.terrain), r.elevation, r.world, r.pair));
}

/// The runs of a table with a header, in the same order: a line a run, of which those with the variant `base` (or
/// without such a column) count.
pub(crate) fn table(file: &Path) -> Result<Vec<Run>, CompareError> {
    let text = read(file)?;
    let mut lines = text.lines().enumerate();
    let header: Vec<&str> = lines.next().map(|(_, l)| l.split(',').collect()).unwrap_or_default();
    let column = |name: &str| {
        let found = header.iter().position(|h| *h == name);
        found.ok_or_else(|| CompareError::reference(file, 1, format!("there is no column {name}")))
    };
    let (world, pair, outcome) = (column("world")?, column("pair")?, column("outcome")?);
    let (elevation, terrain, time) = (column("level")?, column("terrain")?, column("time_s")?);
    let (roll, pitch) = (column("mean_abs_roll_deg")?, column("mean_abs_pitch_deg")?);
    let (goal_distance, roll_end) = (column("goal_distance_m")?, column("roll_end_deg")?);
    let cost = column("cpu_s_per_sim_s")?;
    let variant = column("variant").ok();
    let mut runs = Vec::new();
    for (k, text) in lines {
        let line = k + 1;
        let cells: Vec<&str> = text.trim().split(',').collect();
        let cell = |column: usize| cells.get(column).copied().unwrap_or_default();
        let flaw = |column: usize, want: &str| {
            CompareError::reference(
                file,
                line,
                format!("{}: {:?} is not {want}", header[column], cell(column)),
            )
        };
        if variant.is_some_and(|v| cell(v) != "base") {
            continue;
        }
        runs.push(Run {
            world: cell(world).parse().map_err(|_| flaw(world, "the number of a world"))?,
            pair: cell(pair).parse().map_err(|_| flaw(pair, "the number of a pair"))?,
            elevation: level(cell(elevation)).ok_or_else(|| flaw(elevation, LEVELS))?,
            terrain: ground(cell(terrain)).ok_or_else(|| flaw(terrain, TERRAINS))?,
            end: End::named(cell(outcome)).ok_or_else(|| flaw(outcome, ENDS))?,
            time: number(file, line, &cells, time)?,
            roll: number(file, line, &cells, roll)?,
            pitch: number(file, line, &cells, pitch)?,
            goal_distance: number(file, line, &cells, goal_distance)?,
            roll_end: Some(number(file, line, &cells, roll_end)?.abs()),
            cost: number(file, line, &cells, cost)?,
        });
    }
    sort(&mut runs);
    Ok(runs)
}

/// Columns of a line that are used (the recorder's own order).
const TIME: usize = 5;
const ROLL: usize = 7;
const PITCH: usize = 9;
const GOAL_DISTANCE: usize = 18;
const COST: usize = 25;

fn parse(file: &Path, text: &str) -> Result<Run, CompareError> {
    let cells: Vec<&str> = text.trim().split(',').collect();
    let flaw = |column: usize, want: &str| {
        let found = cells.get(column).copied().unwrap_or_default();
        CompareError::reference(file, 1, format!("column {}: {found:?} is not {want}", column + 1))
    };
    let cell = |column: usize| cells.get(column).copied().unwrap_or_default();
    let end = End::named(cell(4)).ok_or_else(|| flaw(4, ENDS))?;
    let elevation = level(cell(1)).ok_or_else(|| flaw(1, LEVELS))?;
    let terrain = ground(cell(2));
    Ok(Run {
        world: cell(0).parse().map_err(|_| flaw(0, "the number of a world"))?,
        pair: cell(3).parse().map_err(|_| flaw(3, "the number of a pair"))?,
        elevation,
        terrain: terrain.ok_or_else(|| flaw(2, TERRAINS))?,
        end,
        time: number(file, 1, &cells, TIME)?,
        roll: number(file, 1, &cells, ROLL)?,
        pitch: number(file, 1, &cells, PITCH)?,
        goal_distance: number(file, 1, &cells, GOAL_DISTANCE)?,
        roll_end: None,
        cost: number(file, 1, &cells, COST)?,
    })
}

/// A record's time series: numbers under a header.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    header: Vec<String>,
    pub(crate) rows: Vec<Vec<f64>>,
}

impl Series {
    pub(crate) fn read(file: &Path) -> Result<Self, CompareError> {
        Self::parse(file, &read(file)?)
    }

    pub(crate) fn parse(file: &Path, text: &str) -> Result<Self, CompareError> {
        let mut lines = text.lines().enumerate();
        let header: Vec<String> =
            lines.next().map(|(_, l)| l.split(',').map(str::to_owned).collect()).unwrap_or_default();
        let mut rows = Vec::new();
        for (k, line) in lines {
            let cells: Vec<&str> = line.split(',').collect();
            let row = (0..header.len()).map(|column| number(file, k + 1, &cells, column));
            rows.push(row.collect::<Result<Vec<f64>, _>>()?);
        }
        Ok(Self { header, rows })
    }

    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|h| h == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = "1,high,rigid,0,stuck,16.310,0,3.969,6.261,4.863,2.171,27.76,14.17,21.00,120.00,44.39,-5.19,\
                        4.37,104.532,9.6138,9.6172,0.04,1,123,159,1.8767\n";

    #[test]
    fn a_line_is_read_as_its_table_explains_it() {
        let run = parse(Path::new("w1_0.txt"), LINE).unwrap();
        assert_eq!(
            (run.task().as_str(), run.elevation, run.terrain),
            ("w001/t00", Elevation::High, Terrain::Rigid)
        );
        assert_eq!((run.end, run.time, run.roll, run.pitch), (End::Stuck, 16.31, 3.969, 4.863));
        assert_eq!((run.goal_distance, run.cost), (104.532, 1.8767));
    }

    #[test]
    fn a_damaged_line_is_named() {
        for (from, to, expected) in [
            ("stuck", "lost", "w1_0.txt: line 1: column 5: \"lost\" is not success"),
            ("16.310", "soon", "column 6: \"soon\" is not a number"),
            ("high", "", "column 2: \"\" is not low"),
        ] {
            let message = parse(Path::new("w1_0.txt"), &LINE.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
        assert!(parse(Path::new("w1_0.txt"), "").is_err());
    }

    #[test]
    fn a_table_is_read_by_its_header_and_its_flaws_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("all.csv");
        let header = "level,world,terrain,pair,variant,outcome,time_s,mean_abs_roll_deg,mean_abs_pitch_deg,\
                      goal_distance_m,roll_end_deg,cpu_s_per_sim_s\n";
        let line =
            |variant: &str, roll: &str| format!("mid,7,rigid,2,{variant},stuck,20,4,3,61,{roll},0.1\n");
        let write = |lines: String| std::fs::write(&file, format!("{header}{lines}")).unwrap();
        write(line("base", "-44.5") + &line("ms1", "3"));
        let runs = table(&file).unwrap();
        assert_eq!(runs.len(), 1, "variants of the recording are left out");
        let run = &runs[0];
        assert_eq!((run.world, run.pair, run.elevation, run.end), (7, 2, Elevation::Medium, End::Stuck));
        assert_eq!((run.time, run.goal_distance, run.roll_end, run.cost), (20.0, 61.0, Some(44.5), 0.1));
        write(line("base", "much"));
        let message = table(&file).unwrap_err().to_string();
        assert!(message.contains("all.csv: line 2: column 11: \"much\" is not a number"), "{message}");
        std::fs::write(&file, "world,pair\n").unwrap();
        assert!(table(&file).unwrap_err().to_string().contains("there is no column outcome"));
    }

    #[test]
    fn runs_are_read_from_a_folder_by_ground_level_world_and_pair() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, line: &str| std::fs::write(dir.path().join(name), line).unwrap();
        write("w1_0.txt", LINE);
        write("w1_0.csv", "t,x\n");
        write("w10_3.txt", &LINE.replace("1,high,rigid,0", "10,high,rigid,3"));
        write("w2_3.txt", &LINE.replace("1,high,rigid,0", "2,high,rigid,3"));
        write("w70_0.txt", &LINE.replace("1,high,rigid", "70,low,deformable"));
        write("w91_0.txt", &LINE.replace("1,high,rigid", "91,low,mixed"));
        write("w93_0.txt", &LINE.replace("1,high,rigid", "93,low,rigid"));
        let order: Vec<_> = runs(dir.path()).unwrap().iter().map(Run::task).collect();
        assert_eq!(order, ["w093/t00", "w001/t00", "w002/t03", "w010/t03", "w091/t00", "w070/t00"]);
    }
}
