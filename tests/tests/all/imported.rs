//! The original's released data, from import to a driven task. Without the data the tests say so and pass.

use vb_tests::{Bench, pid};

#[test]
fn the_released_worlds_are_imported_checked_and_driven() {
    let Some(original) = vb_testing::shared("verti-bench") else { return };
    let shared = vb_testing::shared_folder();
    let bench = Bench::new();
    let imported = bench.ok(&["suite", "import", original.to_str().expect("text"), "--out", "imported"]);

    // What is there by the reference's own table, which lists each world of the release.
    let table = std::fs::read_to_string(shared.join("reference/worlds.csv")).expect("worlds.csv");
    let header: Vec<&str> = table.lines().next().expect("a header").split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).expect("a column");
    let (world, kind) = (column("world"), column("terrain_type"));
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let of = |wanted: &str| -> Vec<String> {
        let rows = rows.iter().filter(|r| r[kind] == wanted && bench.path(path(r[world])).exists());
        rows.map(|r| name(r[world])).collect()
    };
    let (rigid, deformable, mixed) = (of("rigid"), of("deformable"), of("mixed"));
    let count = rigid.len() + deformable.len() + mixed.len();
    assert!(imported.contains(&format!("{count} worlds, {} tasks", 10 * count)), "{imported}");
    let checked = bench.ok(&["suite", "validate", "./imported"]);
    assert!(checked.contains(&format!("{count} worlds, {} tasks, all valid", 10 * count)), "{checked}");
    let told = bench.ok(&["tasks", "list", "--suite", "./imported", "--tasks", "terrain=rigid"]);
    assert_eq!(told.lines().count(), 10 * rigid.len());

    let pid = pid();
    let run = ["--plugin", pid.to_str().expect("text"), "--suite", "./imported"];
    // On low ground the planner gets on; elsewhere it may be stuck where it starts.
    let low = |w: &&String| rows.iter().any(|r| name(r[world]) == **w && r[column("difficulty")] == "low");
    let first = |kind: &[String]| kind.iter().find(low).expect("a world of low elevation").clone();
    let worlds = [first(&rigid), first(&deformable), first(&mixed)];
    let tasks = worlds.map(|w| format!("{w}/t00-t04")).join(",");
    bench.ok(&[&run[..], &["--tasks", &tasks, "--param", "speed=5", "--out", "run"]].concat());
    let records = bench.records("run");
    assert_eq!(records.len(), 15);
    let mut driven = 0;
    for (task, record) in records {
        let outcome = record["outcome"].as_str().expect("an outcome");
        let by_rule = ["success", "rollover", "stuck", "timeout", "out_of_bounds"];
        assert!(by_rule.contains(&outcome), "{task}: {record}");
        driven += usize::from(record["metrics"]["distance_m"].as_f64() > Some(10.0));
    }
    // A start that lies across a hump holds the vehicle on a diagonal, for ever on soft ground.
    assert!(driven >= 12, "{driven} of 15 get anywhere");
}

/// The name that the import gives the world of this number.
fn name(number: &str) -> String {
    format!("w{number:0>3}")
}

fn path(number: &str) -> String {
    format!("imported/worlds/{}", name(number))
}
