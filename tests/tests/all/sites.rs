//! A user's survey becomes a suite that planners are run on.

use vb_tests::{Bench, pid, root};

const RASTER: &str = "examples/site/heights.tif";

fn text(path: &std::path::Path) -> String {
    path.to_string_lossy().into_owned()
}

#[test]
fn a_geotiff_becomes_a_suite_in_one_command_and_a_planner_drives_it() {
    let bench = Bench::new();
    let raster = text(&root().join(RASTER));
    let said = bench.ok(&["suite", "site", &raster, "--out", "valley"]);
    assert!(said.contains("1 worlds, 10 tasks"), "{said}");
    bench.ok(&["suite", "validate", "valley"]);
    let pid = text(&pid());
    bench.ok(&["--plugin", &pid, "--suite", "valley", "--tasks", "w001/t00-t01", "--out", "run"]);
    let records = bench.records("run");
    assert_eq!(records.len(), 2);
    for (task, record) in records {
        assert_ne!(record["outcome"], "sim_error", "{task}: {record}");
        assert_ne!(record["outcome"], "planner_error", "{task}: {record}");
    }
}

#[test]
fn labels_and_tiles_make_four_worlds_and_the_same_bytes_again() {
    let bench = Bench::new();
    let [raster, labels, site] =
        [RASTER, "examples/site/labels.png", "examples/site/site.yaml"].map(|f| text(&root().join(f)));
    let make = |out: &str| {
        bench.ok(&[
            "suite", "site", &raster, "--out", out, "--tiles", "--labels", &labels, "--site", &site,
            "--seed", "5",
        ])
    };
    let said = make("a");
    assert!(said.contains("4 worlds, 40 tasks"), "{said}");
    make("b");
    // The index has the folder's name.
    let worlds = |name: &str| {
        let mut files = bench.files(name);
        files.retain(|path, _| !path.ends_with("suite.yaml"));
        files
    };
    assert!(worlds("a") == worlds("b") && worlds("a").len() == 20);
    let shown = bench.ok(&["suite", "show", "a"]);
    assert!(shown.contains("mixed"), "the stream is mud: {shown}");
}

#[test]
fn what_is_wrong_with_a_survey_is_one_line_that_says_what_to_do() {
    let bench = Bench::new();
    bench.write("cut.tif", &std::fs::read(root().join(RASTER)).unwrap()[..4000]);
    bench.write("notes.txt", "412.0");
    bench.write("site.yaml", "schema: 1\nname: x\nresolution: 1.0\npatch: 8.0\nside: 127.0\n");
    let raster = text(&root().join(RASTER));
    let labels = text(&root().join("examples/site/labels.png"));
    let cases: [(&[&str], i32, &str); 7] = [
        (&["cut.tif"], 3, "cut.tif"),
        (&["notes.txt"], 3, "its content is not a supported elevation file"),
        (&["nowhere.tif"], 3, "nowhere.tif"),
        (&[&labels], 2, "give --sample-resolution"),
        (&[&raster, "--at", "120,0"], 3, "exceeds the survey, which is 300 m by 260 m"),
        (&[&raster, "--site", "site.yaml"], 3, "site.yaml"),
        (&[&raster, "--labels", &labels], 3, "is not in ground.legend"),
    ];
    for (args, code, expected) in cases {
        let all: Vec<&str> = ["suite", "site"].iter().chain(args).chain(&["--out", "x"]).copied().collect();
        let error = bench.run(&all).error(code);
        assert!(error.contains(expected) && error.trim().lines().count() == 1, "{args:?}: {error}");
        assert!(!bench.path("x").exists(), "{args:?}: nothing is written");
    }
}
