//! What planners are told, and how wrong it is, as users choose it.

use std::path::Path;

use vb_tests::{Bench, PluginKind, pid, plugin, root};

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// Exit code of bad input.
const INPUT: i32 = 3;

#[test]
fn a_planner_that_asks_for_every_sensor_drives_alike_in_wasm_and_natively_and_every_time() {
    let bench = Bench::new();
    let tasks = ["--suite", "smoke", "--tasks", "w001/t00", "--trace", "full"];
    for (kind, out) in
        [(PluginKind::Wasm, "wasm"), (PluginKind::Native, "native"), (PluginKind::Wasm, "again")]
    {
        let watch = plugin("watch", kind);
        let more = ["--plugin", text(&watch), "--perception", "onboard", "--out", out];
        bench.ok(&[&tasks[..], &more].concat());
        assert_eq!(bench.json(&format!("{out}/run.json"))["perception"]["name"], "onboard");
    }
    let hash = |out: &str| bench.records(out)["w001/t00"]["state_hash"].clone();
    assert!(hash("wasm") == hash("native") && hash("wasm") == hash("again"));
    // Another seed of the run is another noise, by which the planner steers.
    let watch = plugin("watch", PluginKind::Wasm);
    let other = ["--plugin", text(&watch), "--perception", "onboard", "--seed", "1", "--out", "other"];
    bench.ok(&[&tasks[..], &other].concat());
    assert_ne!(hash("wasm"), hash("other"));
}

#[test]
fn what_a_profile_does_not_offer_is_said_before_anything_is_driven() {
    let bench = Bench::new();
    let text_of = std::fs::read_to_string(root().join("tasks/perception/onboard.yaml")).unwrap();
    let (before, gnss) = text_of.split_once("\ngnss:").unwrap();
    let (_, after) = gnss.split_once("\nlidar:").unwrap();
    bench.write("blind.yaml", format!("{before}\nlidar:{after}").replace("name: onboard", "name: blind"));
    bench.write(
        "slow.yaml",
        text_of.replacen("rate_hz: 100", "rate_hz: 20", 1).replace("name: onboard", "name: slow"),
    );
    bench.write("wrong.yaml", text_of.replace("max_range_m: 90", "max_range_m: 0.1"));
    let watch = plugin("watch", PluginKind::Wasm);
    let pid = pid();
    for (planner, profile, says) in [
        (&watch, "blind.yaml", &["watch", "needs gnss", "blind", "it provides pose"][..]),
        (&watch, "slow.yaml", &["watch", "needs imu at 100 Hz", "slow provides 20"]),
        (&watch, "wrong.yaml", &["wrong.yaml", "lidar.max_range_m"]),
        (&watch, "nowhere.yaml", &["nowhere.yaml"]),
        (&pid, "weather", &["there is no perception profile weather", "onboard"]),
    ] {
        let error =
            bench.run(&["--plugin", text(planner), "--perception", profile, "--out", "r"]).error(INPUT);
        assert!(
            says.iter().all(|part| error.contains(part)) && error.lines().count() == 1,
            "{profile}: {error}"
        );
        assert!(!bench.path("r").exists(), "{profile}");
    }
}

#[test]
fn a_planner_without_maps_of_the_world_gets_by_on_what_it_sees() {
    let bench = Bench::new();
    for name in ["eh", "mppi"] {
        let planner = plugin(name, PluginKind::Wasm);
        for profile in ["onboard", "degraded"] {
            let out = format!("{name}-{profile}");
            let run = ["--plugin", text(&planner), "--suite", "smoke", "--tasks", "w001/t00"];
            bench.ok(&[&run[..], &["--perception", profile, "--out", &out]].concat());
            let record = &bench.records(&out)["w001/t00"];
            assert_ne!(record["outcome"], "planner_error", "{record}");
        }
    }
}
