//! What simulating costs: processor time a simulated second.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use vb_world::Terrain;

use crate::CompareError;
use crate::reference::{GROUNDS, Run};

/// Processor time and simulated time, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    pub(crate) processor: f64,
    pub(crate) simulated: f64,
}

impl Cost {
    pub(crate) fn add(&mut self, other: Self) {
        self.processor += other.processor;
        self.simulated += other.simulated;
    }

    fn rate(self) -> Option<f64> {
        (self.simulated > 0.0 && self.processor > 0.0).then(|| self.processor / self.simulated)
    }
}

/// Processor time of all programs that this one has started and that have ended, s; none where the system doesn't tell.
pub(crate) fn of_children() -> Option<f64> {
    #[cfg(unix)]
    {
        let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
        // SAFETY: the call writes a rusage to where the pointer points, which has room for one.
        let status = unsafe { libc::getrusage(libc::RUSAGE_CHILDREN, usage.as_mut_ptr()) };
        // SAFETY: all its fields are numbers, for which zeros are as good as what the call wrote.
        let usage = unsafe { usage.assume_init() };
        let seconds = |t: libc::timeval| t.tv_sec as f64 + 1e-6 * t.tv_usec as f64;
        (status == 0).then(|| seconds(usage.ru_utime) + seconds(usage.ru_stime))
    }
    #[cfg(not(unix))]
    None
}

/// Chrono's cost without pairs of fixed bodies, by ground, from a table with a line for each task and a header with at
/// least `terrain`, `time_s` (simulated, s) and `cpu_s_per_sim_s` (processor time a simulated second, s). Nothing where
/// there is no such file.
///
/// Rocks rest in the ground as fixed bodies. In the recorded set-up Chrono looks for contacts between them and the ground
/// at every step and throws them away, since neither can move; without these pairs its results are the same.
///
/// # Errors
/// If the file can't be read or a line is not as it must be.
pub(crate) fn without_fixed_pairs(file: &Path) -> Result<BTreeMap<Terrain, Cost>, CompareError> {
    let text = match std::fs::read_to_string(file) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeMap::new()),
        Err(source) => return Err(CompareError::Io { path: file.into(), source }),
    };
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| {
        let found = header.iter().position(|h| *h == name);
        found.ok_or_else(|| CompareError::reference(file, 1, format!("there is no column {name}")))
    };
    let (terrain, time, rate) = (column("terrain")?, column("time_s")?, column("cpu_s_per_sim_s")?);
    let mut costs: BTreeMap<Terrain, Cost> = BTreeMap::new();
    for (k, line) in lines.enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |column: usize| cells.get(column).copied().unwrap_or_default();
        let flaw = |column: usize, want: &str| {
            let problem = format!("{}: {:?} is not {want}", header[column], cell(column));
            CompareError::reference(file, k + 2, problem)
        };
        let number = |column: usize| {
            let value = cell(column).parse().ok().filter(|v: &f64| v.is_finite() && *v >= 0.0);
            value.ok_or_else(|| flaw(column, "a number from 0"))
        };
        let ground = Terrain::ALL.into_iter().find(|t| t.name() == cell(terrain));
        let ground = ground.ok_or_else(|| flaw(terrain, "rigid, deformable or mixed"))?;
        let simulated = number(time)?;
        costs.entry(ground).or_default().add(Cost { processor: number(rate)? * simulated, simulated });
    }
    Ok(costs)
}

/// Chrono's cost and ours by ground, as Markdown: Chrono's as recorded, and without pairs of fixed bodies (`lean`) where
/// that is known, each with its ratio to ours.
pub(crate) fn table(runs: &[&Run], lean: &BTreeMap<Terrain, Cost>, ours: &BTreeMap<Terrain, Cost>) -> String {
    let mut out = String::from(
        "| ground | Chrono as set up | without pairs of fixed bodies | here | ratio as set up | without those pairs |\n\
         |---|---|---|---|---|---|\n",
    );
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
    for terrain in GROUNDS {
        let mut theirs = Cost::default();
        for run in runs.iter().filter(|r| r.terrain == terrain) {
            theirs.add(Cost { processor: run.cost * run.time, simulated: run.time });
        }
        let Some(set_up) = theirs.rate() else { continue };
        let lean = lean.get(&terrain).and_then(|c| c.rate());
        let here = ours.get(&terrain).and_then(|c| c.rate());
        let ratio = |chrono: Option<f64>| or_dash(chrono.zip(here).map(|(c, h)| format!("{:.0}", c / h)));
        let _ = writeln!(
            out,
            "| {} | {:.0} ms | {} | {} | {} | {} |",
            terrain.name(),
            1e3 * set_up,
            or_dash(lean.map(|v| format!("{:.0} ms", 1e3 * v))),
            or_dash(here.map(|v| format!("{:.1} ms", 1e3 * v))),
            ratio(Some(set_up)),
            ratio(lean),
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::End;
    use vb_world::Elevation;

    #[test]
    fn costs_are_weighed_by_simulated_time_and_a_ground_without_ours_has_no_ratio() {
        let run = |terrain, time, cost| Run {
            world: 1,
            pair: 0,
            elevation: Elevation::Low,
            terrain,
            end: End::Success,
            time,
            roll: 1.0,
            pitch: 1.0,
            goal_distance: 8.0,
            cost,
        };
        let runs =
            [run(Terrain::Rigid, 30.0, 0.4), run(Terrain::Rigid, 10.0, 0.8), run(Terrain::Mixed, 9.0, 0.5)];
        let ours = BTreeMap::from([(Terrain::Rigid, Cost { processor: 2.0, simulated: 400.0 })]);
        let lean = BTreeMap::from([
            (Terrain::Rigid, Cost { processor: 6.0, simulated: 100.0 }),
            (Terrain::Mixed, Cost { processor: 8.0, simulated: 100.0 }),
        ]);
        // (30 · 0.4 + 10 · 0.8) / 40 = 0.5 s, and 6 / 100 = 0.06 s, over 2 / 400 = 0.005 s.
        let told = table(&runs.each_ref(), &lean, &ours);
        let rows = "| rigid | 500 ms | 60 ms | 5.0 ms | 100 | 12 |\n| mixed | 500 ms | 80 ms | – | – | – |\n";
        assert!(told.ends_with(rows), "{told}");
        // Without such measurements the table stays, with dashes.
        let told = table(&runs.each_ref(), &BTreeMap::new(), &ours);
        assert!(told.contains("| rigid | 500 ms | – | 5.0 ms | 100 | – |\n"), "{told}");
    }

    #[test]
    fn costs_without_fixed_pairs_are_read_by_ground_and_damage_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("all-tasks.csv");
        assert_eq!(without_fixed_pairs(&file).unwrap(), BTreeMap::new());
        let text =
            "world,terrain,time_s,cpu_s_per_sim_s\n1,rigid,30.0,0.05\n2,rigid,10.0,0.1\n91,mixed,20,0.2\n";
        std::fs::write(&file, text).unwrap();
        let costs = without_fixed_pairs(&file).unwrap();
        // 30 · 0.05 + 10 · 0.1 = 2.5 s of 40 s.
        assert_eq!(costs.keys().collect::<Vec<_>>(), [&Terrain::Rigid, &Terrain::Mixed]);
        assert!((costs[&Terrain::Rigid].rate().unwrap() - 0.0625).abs() < 1e-12);
        assert!((costs[&Terrain::Mixed].processor - 4.0).abs() < 1e-12);
        for (from, to, expected) in [
            ("time_s", "seconds", "line 1: there is no column time_s"),
            ("91,mixed", "91,lava", "line 4: terrain: \"lava\" is not rigid"),
            ("10.0,0.1", "10.0,", "line 3: cpu_s_per_sim_s: \"\" is not a number"),
            ("10.0,0.1", "10.0,-0.1", "line 3: cpu_s_per_sim_s: \"-0.1\" is not a number"),
        ] {
            std::fs::write(&file, text.replace(from, to)).unwrap();
            let message = without_fixed_pairs(&file).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_time_of_a_child_that_worked_counts() {
        let before = of_children().unwrap();
        let work = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        assert!(std::process::Command::new("sh").args(["-c", work]).status().unwrap().success());
        assert!(of_children().unwrap() > before);
    }
}
