//! Reports of sweeps: planners by settings, with all seeds of a planner together.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

mod common;

use std::path::Path;

use common::{HOSTILE, header, tasks, write};
use vb_record::{DataHeader, RunHeader};
use vb_report::{Sweep, SweepRow};
use vb_score::{Rules, Summary};

/// A run of eight worlds of four tasks, of which the first `done` of each succeed.
fn row(dir: &Path, planner: &str, vehicle: &str, seed: u64, done: usize) -> SweepRow {
    let run = format!("{}--{}--{seed}", planner.len(), vehicle.bytes().map(usize::from).sum::<usize>());
    let header = RunHeader {
        vehicle: DataHeader { name: vehicle.into(), hash: "cc".repeat(32) },
        seed,
        ..header(planner, 32)
    };
    let records = tasks(8, |_, t| t < done);
    let dir = write(&dir.join(&run), &header, records.clone());
    SweepRow {
        run: format!("{planner}--{vehicle}--oracle--{seed}"),
        dir,
        planner: planner.to_owned(),
        vehicle: vehicle.to_owned(),
        perception: "oracle".to_owned(),
        seed,
        summary: Summary::new(&header, &Rules::paper(), &records, Vec::new()),
    }
}

fn sweep(dir: &Path) -> Sweep {
    let rows = vec![
        row(dir, "pid,speed=3", "hmmwv", 0, 1),
        row(dir, "pid,speed=3", "hmmwv", 1, 2),
        row(dir, "=<b>", "hmmwv", 0, 4),
        row(dir, "=<b>", "hmmwv", 1, 4),
        row(dir, "=<b>", "gator", 0, 2),
    ];
    Sweep::new("mine", rows).unwrap()
}

#[test]
fn seeds_of_a_planner_are_together_and_what_was_not_driven_is_a_dash() {
    let dir = tempfile::tempdir().unwrap();
    let markdown = sweep(dir.path()).markdown();
    assert!(markdown.starts_with("| mine | hmmwv, oracle | gator, oracle |\n|:--|--:|--:|\n"), "{markdown}");
    // One and two of four tasks: 25 and 50 %, together 37.5. All worlds are alike, and so is every draw of the bootstrap.
    assert!(markdown.contains("| pid,speed=3 | 37.5 [37.5, 37.5] (25.0 to 50.0) | – |"), "{markdown}");
    // All tasks of eight worlds: Wilson's interval begins at 8 / (8 + 1.96²) = 0.676. A setting with one seed has no range.
    assert!(
        markdown.contains("| =&lt;b&gt; | 100.0 [67.6, 100.0] (100.0 to 100.0) | 50.0 [50.0, 50.0] |"),
        "{markdown}"
    );
    assert!(markdown.contains("Tasks of all 2 seeds are pooled"));
    // By rank, over the 64 tasks of both seeds. A task with one seed is not the same as with the other.
    assert!(
        markdown.contains("## hmmwv, oracle") && markdown.contains("| 1 | =&lt;b&gt; | 64 |"),
        "{markdown}"
    );
    assert!(markdown.contains("| 2 | pid,speed=3 | 64 |"));
}

#[test]
fn its_text_is_the_table_of_a_run_within_the_width_a_table_a_setting() {
    let dir = tempfile::tempdir().unwrap();
    let sweep = sweep(dir.path());
    let table = sweep.table(None);
    let lines: Vec<&str> = table.lines().collect();
    let head = "hmmwv, oracle  tasks  success % (95 % CI)  time s  |roll| °  |pitch| °  rollover  stuck  timeout  out  errors  tilt > 30°  strict  > 2.5 g  > 6 W";
    assert_eq!(lines[0], head);
    assert!(lines[1].starts_with("pid,speed=3       64     37.5 (37.5-37.5)"), "{table}");
    assert!(lines[2].starts_with("=<b>              64   100.0 (67.6-100.0)"), "{table}");
    assert!(lines[3].is_empty() && lines[4].starts_with("gator, oracle  tasks"));
    assert!(sweep.table(Some(50)).lines().all(|line| line.chars().count() <= 50));
    assert_eq!(sweep.headlines().len(), 1, "nobody wins alone");
    assert!(
        sweep.headlines()[0]
            .starts_with("hmmwv, oracle: =<b> has the highest success rate: 100.0 % of 64 tasks")
    );
}

#[test]
fn a_page_sorts_and_links_a_planner_looks_the_same_everywhere_and_texts_are_no_markup() {
    let dir = tempfile::tempdir().unwrap();
    let page = sweep(dir.path()).page(&["hmmwv--oracle"]);
    let hostile = vec![row(&dir.path().join("h"), HOSTILE, HOSTILE.trim_end_matches('>'), 0, 1)];
    let hostile = Sweep::new(HOSTILE, hostile).unwrap().page(&[]);
    assert!(
        !hostile.contains("<img") && !hostile.contains("<script>document") && hostile.contains("&lt;img"),
        "{hostile}"
    );
    assert!(page.contains("<a href=\"hmmwv--oracle/index.html\">") && !page.contains("gator--oracle/"));
    assert!(
        page.contains("data-v=\"0.375\">37.5 <small>[37.5, 37.5]</small><small> (25.0 to 50.0)</small>"),
        "{page}"
    );
    // The second planner of the plan is the first of both rankings, and has its own look there.
    assert_eq!(page.matches("data-sample=\"1\"").count(), 3);
    assert_eq!(page.matches("data-sample=\"0\"").count(), 2);
    assert!(page.contains("&lt;b&gt;") && !page.contains("<b>=") && !page.contains("=<b>"), "{page}");
}

#[test]
fn a_table_for_programs_has_a_line_for_each_run_and_no_formulas() {
    let dir = tempfile::tempdir().unwrap();
    let csv = sweep(dir.path()).csv().unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].starts_with("run,planner,vehicle,perception,seed,tasks,success_rate,"), "{csv}");
    assert!(
        lines[1].starts_with("\"pid,speed=3--hmmwv--oracle--0\",\"pid,speed=3\",hmmwv,oracle,0,32,0.25,"),
        "{csv}"
    );
    assert_eq!(lines.len(), 6);
    assert!(lines[5].starts_with("'=<b>--gator--oracle--0,'=<b>,gator,oracle,0,32,0.5,"), "{csv}");
    assert!(
        lines[0].contains(",success,rollover,stuck,timeout,") && !lines[0].contains("host_error"),
        "{csv}"
    );
}
