//! Submissions, their verification, scores on hidden suites and the leaderboard's site, by the built binary.

use std::fs;
use std::path::Path;

use serde_json::Value;
use vb_tests::{Bench, Browser, Mini, PluginKind, pid, plugin};

const HOSTILE: &str = "<img src=x onerror=\"document.title='owned'\"><script>alert(1)</script>";

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

#[test]
fn a_submission_is_small_says_what_was_run_and_verifies() {
    let mini = Mini::new();
    let pid = pid();
    mini.submit(&pid, "s", &["--entrant", "A team", "--note", "First try"]);
    let manifest = mini.bench.json("s/submission.json");
    assert_eq!((&manifest["division"], &manifest["abi"]), (&"ranked".into(), &"1.0".into()));
    assert_eq!(manifest["run"]["suite"]["name"], "mini");
    assert_eq!(manifest["tasks"].as_object().map(serde_json::Map::len), Some(20));
    // The run stays where runs are, with all its traces; the submission has those of a few tasks.
    let records = mini.bench.records("runs/pid-1");
    for (task, record) in &records {
        let entry = &manifest["tasks"][task];
        assert_eq!(
            (&entry["outcome"], &entry["state_hash"]),
            (&record["outcome"], &record["state_hash"]),
            "{task}"
        );
    }
    let size: usize = mini.bench.files("s").values().map(Vec::len).sum();
    assert!(size < 1_000_000, "{size} bytes");

    let told = mini.ok(&["verify", "s", "--plugin", text(&pid), "--sample", "3", "--seed", "5"]);
    assert!(told.contains("seed 5") && told.lines().filter(|l| l.contains("good")).count() == 13, "{told}");
    let verdict = mini.bench.json("s/verification.json");
    assert_eq!((&verdict["verified"], &verdict["sample"]["seed"]), (&true.into(), &5.into()));
    // The same sample again, with other workers; then a random one.
    let again = [
        "verify",
        "s",
        "--plugin",
        text(&pid),
        "--sample",
        "3",
        "--seed",
        "5",
        "--jobs",
        "1",
        "--out",
        "v.json",
    ];
    mini.ok(&again);
    assert_eq!(mini.bench.json("v.json"), verdict);
    mini.ok(&["verify", "s", "--plugin", text(&pid), "--sample", "1", "--ranked", "--out", "v.json"]);
    assert_ne!(mini.bench.json("v.json")["sample"]["seed"], 5);

    // Of the finished run the same submission is made.
    mini.ok(&[
        "submit",
        "--plugin",
        text(&pid),
        "--run",
        "runs/pid-1",
        "--out",
        "t",
        "--entrant",
        "A team",
        "--note",
        "First try",
    ]);
    fs::remove_file(mini.path("s/verification.json")).expect("a verdict");
    assert_eq!(mini.bench.files("t"), mini.bench.files("s"));
    // What it holds is a run as any other.
    mini.ok(&["report", "s/run", "--markdown", "-"]);
}

#[test]
fn what_does_not_verify_is_named_and_has_its_own_exit_code() {
    let mini = Mini::new();
    let (pid, eh) = (pid(), plugin("eh", PluginKind::Wasm));
    mini.ok(&["--plugin", text(&pid), "--suite", "mini", "--tasks", "w001/t00-t02", "--out", "run"]);
    mini.ok(&["submit", "--plugin", text(&pid), "--run", "run", "--out", "s"]);
    let manifest = fs::read_to_string(mini.path("s/submission.json")).expect("a manifest");
    let verify = |more: &[&str]| mini.run(&[&["verify", "s", "--plugin", text(&pid)][..], more].concat());

    let told = verify(&["--ranked"]).error(9);
    assert!(told.contains("in the open division, for its selector"), "{told}");
    let told = mini.run(&["verify", "s", "--plugin", text(&eh)]).error(9);
    assert!(told.contains("plugin: submission.json: run.plugin.sha256"), "{told}");
    let native = plugin("pid", PluginKind::Native);
    let told = mini.run(&["verify", "s", "--plugin", text(&native)]).error(3);
    assert!(
        told.contains("is neither a WASM file nor a recording") && told.contains("--allow-native"),
        "{told}"
    );

    // A forger who makes the submission anew of records that he changed.
    mini.bench.write("forged/run.json", fs::read(mini.path("run/run.json")).expect("a header"));
    let records = fs::read_to_string(mini.path("run/tasks.jsonl")).expect("records");
    let time = mini.bench.records("run")["w001/t00"]["time_s"].to_string();
    mini.bench.write("forged/tasks.jsonl", records.replace(&format!("\"time_s\":{time}"), "\"time_s\":9.5"));
    mini.ok(&["submit", "--plugin", text(&pid), "--run", "forged", "--out", "f"]);
    let told = mini.run(&["verify", "f", "--plugin", text(&pid)]).error(9);
    assert!(told.contains("rerun: run/tasks.jsonl: w001/t00: time_s: is 9.5"), "{told}");
    assert_eq!(mini.bench.json("f/verification.json")["verified"], false);

    // Versions, and names that would lead to other files.
    mini.bench.write("s/submission.json", manifest.replacen("\"schema\": 1", "\"schema\": 2", 1));
    assert!(verify(&[]).error(3).contains("schema 2 is not supported"));
    mini.bench.write(
        "s/submission.json",
        manifest.replace("\"harness_version\": \"1.0.0-rc.1\"", "\"harness_version\": \"0.0.9\""),
    );
    assert!(verify(&[]).error(3).contains("was created with version 0.0.9"));
    mini.bench.write(
        "s/submission.json",
        manifest.replace("\"name\": \"hmmwv\"", "\"name\": \"../../etc/passwd\""),
    );
    assert!(verify(&[]).error(3).contains("is not built in"));
    mini.bench.write("s/submission.json", "{");
    assert!(verify(&[]).error(3).contains("submission.json"));
    assert!(mini.run(&["verify", "run", "--plugin", text(&pid)]).error(3).contains("is not a submission"));
}

/// The open division for planners that nobody else has: commands and nodes of ROS 2.
#[test]
fn recorded_commands_of_a_run_drive_it_again_and_can_be_submitted() {
    let mini = Mini::new();
    let pid = pid();
    let tasks = ["--suite", "mini", "--tasks", "w001/t00-t02"];
    let drive = |planner: &str, more: &[&str]| mini.run(&[&["run", planner][..], &tasks, more].concat());
    drop(drive(text(&pid), &["--out", "run", "--perception", "onboard"]).ok());
    mini.ok(&["commands", "run", "--out", "pid.commands"]);
    let told = mini.run(&["commands", "run", "--out", "pid.commands"]).error(4);
    assert!(told.contains("pid.commands already exists") && told.contains("--force"), "{told}");
    mini.ok(&["commands", "run", "--out", "pid.commands", "--force"]);
    let told = mini.ok(&["inspect", "pid.commands"]);
    assert!(told.contains("recorded commands of a planner of kind wasm"), "{told}");
    drop(drive("pid.commands", &["--out", "again", "--perception", "onboard"]).ok());
    let (first, again) = (mini.bench.records("run"), mini.bench.records("again"));
    assert_eq!(first.len(), 3);
    for (task, record) in &first {
        for field in ["state_hash", "outcome", "metrics"] {
            assert_eq!(again[task][field], record[field], "{task}: {field}");
        }
    }
    mini.ok(&["submit", "pid.commands", "--run", "again", "--out", "s"]);
    let manifest = mini.bench.json("s/submission.json");
    assert_eq!(
        (&manifest["division"], &manifest["run"]["plugin"]["kind"]),
        (&"open".into(), &"recording".into())
    );
    mini.ok(&["verify", "s", "--plugin", "pid.commands"]);
    assert!(
        mini.run(&["verify", "s", "--plugin", "pid.commands", "--ranked"]).error(9).contains("open division")
    );

    assert!(mini.run(&["check", "pid.commands"]).error(2).contains("a recording has no planner to check"));
    // Under other settings the commands mean nothing.
    for (settings, field) in [
        (&["--perception", "oracle"][..], "perception.hash"),
        (&["--perception", "onboard", "--time-step", "0.002"], "time_step"),
        (&["--perception", "onboard", "--scale", "0.5"], "scale"),
    ] {
        let told = drive("pid.commands", &[&["--out", "other"][..], settings].concat()).error(3);
        assert!(told.contains("the recording does not match this run") && told.contains(field), "{told}");
    }
    // A task of which there are no commands, and one whose commands end too early.
    let told = mini.run(&[
        "run",
        "pid.commands",
        "--suite",
        "mini",
        "--tasks",
        "w001/t03",
        "--perception",
        "onboard",
        "--out",
        "more",
        "--logs",
        "all",
    ]);
    drop(told.ok());
    let more = &mini.bench.records("more")["w001/t03"];
    assert_eq!(
        (&more["outcome"], &more["fault"]),
        (&"planner_error".into(), &"planner/init-failed".into()),
        "{more}"
    );
    // Runs whose traces lack commands, and files that are none.
    drop(drive(text(&pid), &["--out", "untraced", "--trace", "none"]).ok());
    assert!(mini.run(&["commands", "untraced", "--out", "c"]).error(3).contains("w001/t00 has no trace"));
    mini.bench.write("cut.commands", &fs::read(mini.path("pid.commands")).expect("it")[..2000]);
    let trace = mini.path("run/traces/w001/t00.parquet");
    for file in ["cut.commands", text(&trace)] {
        assert!(drive(file, &["--out", "bad"]).error(3).contains("not a planner plugin"), "{file}");
    }
    assert!(!mini.path("c").exists() && !mini.path("bad").exists() && !mini.path("other").exists());
}

#[test]
fn what_cannot_be_submitted_is_refused_before_anything_is_driven() {
    let mini = Mini::new();
    let pid = pid();
    let submit = |more: &[&str]| {
        let args = ["submit", "--plugin", text(&pid), "--suite", "mini", "--out", "s"];
        mini.run(&[&args[..], more].concat())
    };
    assert!(submit(&["--url", "javascript:alert(1)"]).error(2).contains("https://"));
    assert!(submit(&["--entrant", "a\nb"]).error(2).contains("control character"));
    let told = mini.run(&["submit", "--plugin", "sh planner.sh", "--out", "s"]).error(3);
    assert!(told.contains("a command or a ROS 2 node can't be submitted"), "{told}");
    mini.bench.write("full/thesis.tex", "");
    assert!(mini.run(&["submit", "--plugin", text(&pid), "--out", "full"]).error(4).contains("is not empty"));
    assert!(!mini.path("runs").exists() && !mini.path("s").exists());
    // A run that was killed.
    mini.ok(&["--plugin", text(&pid), "--suite", "mini", "--tasks", "w001/t00-t01", "--out", "run"]);
    let records = fs::read_to_string(mini.path("run/tasks.jsonl")).expect("records");
    mini.bench.write("run/tasks.jsonl", &records[..records.len() - 30]);
    let told = mini.run(&["submit", "--plugin", text(&pid), "--run", "run", "--out", "s"]).error(3);
    assert!(told.contains("not finished: 1 of 2 tasks"), "{told}");
    let eh = plugin("eh", PluginKind::Wasm);
    let told = mini.run(&["submit", "--plugin", text(&eh), "--run", "run", "--out", "s"]).error(3);
    assert!(told.contains("its plugin is"), "{told}");
}

#[test]
fn an_evaluation_on_a_hidden_suite_tells_scores_and_nothing_else() {
    let mini = Mini::new();
    let seed = "7164283450912345678";
    mini.ok(&[
        "suite",
        "generate",
        "--seed",
        seed,
        "--worlds",
        "1",
        "--name",
        "holdout",
        "--out",
        "cellar/vault",
    ]);
    // A planner that writes to its log, to series and to standard error in each task, and fails in each.
    // An evaluation gives no parameters, so the default in the plugin's metadata becomes another one of the same length.
    let mut file = fs::read(plugin("faulty", PluginKind::Wasm)).expect("a plugin");
    let (from, to) = (b"default: none\nhelp: none,", b"default: panic\nhelp: non,");
    let places: Vec<usize> = (0..file.len()).filter(|&k| file[k..].starts_with(from)).collect();
    assert!(!places.is_empty(), "the planner's metadata are written otherwise now");
    places.iter().for_each(|&k| file[k..k + to.len()].copy_from_slice(to));
    mini.bench.write("loud.wasm", file);
    mini.ok(&["--plugin", "loud.wasm", "--suite", "cellar/vault", "--out", "open-run"]);
    let records = mini.bench.records("open-run");
    let loud = records.values().next().expect("a record");
    assert_eq!(loud["outcome"], "planner_error");
    assert!(loud["log"].to_string().contains("failing at"), "the planner of this test logs: {loud}");

    let index = fs::read_to_string(mini.path("cellar/vault/suite.yaml")).expect("an index");
    let world_hash = index.split("sha256: \"").nth(1).and_then(|t| t.get(..16)).expect("a hash");
    let suite_hash = mini.bench.json("open-run/run.json")["suite"]["hash"].to_string();
    let words =
        [seed, "w001", "t00", "vault", "cellar", "failing at", "panicked", world_hash, &suite_hash[1..17]];
    let silent = |what: &str, told: &str| {
        for word in words {
            assert!(!told.contains(word), "{what}: {word}: {told}");
        }
    };
    let pid = pid();
    for (planner, format) in [("loud.wasm", "human"), ("loud.wasm", "json"), (text(&pid), "human")] {
        let done = mini.run(&[
            "evaluate",
            "--plugin",
            planner,
            "--suite",
            "cellar/vault",
            "--out",
            "scores.json",
            "--force",
            "--message-format",
            format,
        ]);
        assert_eq!(done.status.code(), Some(0), "{}", done.stderr);
        silent(planner, &format!("{}{}", done.stdout, done.stderr));
        silent(planner, &fs::read_to_string(mini.path("scores.json")).expect("scores"));
    }
    let scores = mini.bench.json("scores.json");
    assert_eq!((&scores["suite"], &scores["tasks"]), (&"holdout".into(), &10.into()));
    let again = ["evaluate", "--plugin", text(&pid), "--suite", "cellar/vault", "--out", "scores.json"];
    let told = mini.run(&again).error(4);
    assert!(told.contains("scores.json already exists") && told.contains("--force"), "{told}");
    // Nothing is driven for scores that have no place.
    let nowhere = ["evaluate", "--plugin", text(&pid), "--suite", "cellar/vault", "--out", "no/where.json"];
    let told = mini.run(&nowhere).error(4);
    assert!(told.contains("cannot write no/where.json"), "{told}");
    // A suite that is damaged: not even that is told, nor where it lies.
    fs::remove_file(mini.path("cellar/vault/worlds/w001/elevation.png")).expect("a file of the world");
    let done = mini.run(&["evaluate", "--plugin", text(&pid), "--suite", "cellar/vault"]);
    silent("damaged", &done.stderr);
    assert!(done.error(3).contains("the suite is invalid"));
    let native = plugin("pid", PluginKind::Native);
    let told = mini.run(&["evaluate", "--plugin", text(&native), "--suite", "cellar/vault"]).error(3);
    assert!(told.contains("is not a WASM file"), "{told}");
}

/// Three entries on two boards, of which one has scores on a hidden suite.
fn accepted(mini: &Mini) {
    let (pid, pursuit) = (pid(), plugin("pursuit", PluginKind::Wasm));
    mini.submit(
        &pid,
        "accepted/pid",
        &["--entrant", HOSTILE, "--note", HOSTILE, "--url", "https://example.org"],
    );
    mini.submit(&pursuit, "accepted/pursuit", &["--entrant", "A team", "--replays", "w001/t00,w002/t03"]);
    mini.ok(&[
        "--plugin",
        text(&pid),
        "--suite",
        "mini",
        "--tasks",
        "w001",
        "--param",
        "speed=2",
        "--out",
        "run",
    ]);
    mini.ok(&[
        "submit",
        "--plugin",
        text(&pid),
        "--run",
        "run",
        "--out",
        "accepted/pid-w001",
        "--entrant",
        "B team",
    ]);
    for (id, plugin) in [("pid", &pid), ("pursuit", &pursuit), ("pid-w001", &pid)] {
        mini.ok(&["verify", &format!("accepted/{id}"), "--plugin", text(plugin), "--sample", "1"]);
    }
    mini.suite("hidden", "holdout", &["w003"]);
    mini.ok(&["evaluate", "--plugin", text(&pid), "--suite", "hidden", "--out", "accepted/pid/holdout.json"]);
}

#[test]
fn a_run_whose_selector_selects_all_tasks_is_one_of_the_whole_suite() {
    let mini = Mini::new();
    let pid = pid();
    let pid = text(&pid);
    mini.ok(&["run", pid, "--suite", "mini", "--tasks", "w*", "--trace", "none", "--out", "run"]);
    assert_eq!(mini.bench.json("run/run.json")["selector"], Value::Null);
    mini.ok(&["submit", pid, "--run", "run", "--out", "s"]);
    let manifest = mini.bench.json("s/submission.json");
    assert_eq!(manifest["division"], "ranked", "{}", manifest["open_because"]);
}

#[test]
fn replays_that_cannot_be_carried_along_are_refused_before_anything_is_driven() {
    let bench = Bench::new();
    let submit = |replays: &str| {
        let pid = pid();
        let args =
            ["submit", "--plugin", text(&pid), "--suite", "smoke", "--out", "s", "--entrant", "A team"];
        bench.run(&[&args[..], &["--replays", replays]].concat()).error(2)
    };
    let many = submit("w001,w002,w003/t00");
    assert!(many.contains("w001/t00: one of 21 tasks; a submission contains at most 20 replays"), "{many}");
    assert!(submit("w999").contains("no world \"w999\" in suite \"smoke\""));
    assert!(bench.files(".").is_empty(), "{:?}", bench.files(".").keys());
}

#[test]
fn a_leaderboard_is_ranked_filtered_fits_a_phone_and_leads_to_replays() {
    let mini = Mini::new();
    accepted(&mini);
    mini.ok(&["leaderboard", "build", "accepted", "--out", "site", "--title", "Our board"]);
    let data = mini.bench.json("site/leaderboard.json");
    let boards = data["boards"].as_array().expect("boards");
    assert_eq!(boards.len(), 2);
    let ids = |b: &Value| -> Vec<String> {
        let entries = b["entries"].as_array().expect("entries");
        entries.iter().map(|e| e["id"].as_str().expect("text").to_owned()).collect()
    };
    let mut ranked = ids(&boards[0]);
    ranked.sort();
    assert_eq!(
        (ranked, ids(&boards[1])),
        (vec!["pid".into(), "pursuit".into()], vec!["pid-w001".to_owned()])
    );
    let reasons = boards[1]["entries"][0]["open_because"].to_string();
    assert!(reasons.contains("params") && reasons.contains("selector"), "{reasons}");
    // Figures are those of the summaries.
    for e in boards[0]["entries"].as_array().expect("entries") {
        let id = e["id"].as_str().expect("text");
        let summary = mini.bench.json(&format!("accepted/{id}/run/summary.json"));
        assert_eq!(e["success_rate"]["mean"], summary["all"]["success_rate"], "{id}");
    }
    let files = mini.bench.files("site");
    for file in [
        "entries/pursuit/replays/w001/t00.html",
        "entries/pursuit/replays/w002/t03.html",
        "entries/pid/report.html",
    ] {
        assert!(files.contains_key(Path::new(file)), "{file} of {:?}", files.keys());
    }
    // The same entries give the same site.
    mini.ok(&["leaderboard", "build", "accepted", "--out", "again", "--title", "Our board"]);
    assert_eq!(mini.bench.files("again"), files);

    let Some(mut browser) = Browser::start(1280, 900) else { return };
    browser.open(&mini.path("site/index.html"));
    let shown = "[...document.querySelectorAll('.board')].filter(b => !b.hidden).length";
    assert_eq!(browser.eval(shown), 2);
    let choose = |value: &str| {
        format!(
            "(() => {{ const f = document.querySelector('#filter'); f.division.value = {value:?}; f.dispatchEvent(new Event('input')); \
             return {shown}; }})()"
        )
    };
    assert_eq!(browser.eval(&choose("open")), 1);
    assert_eq!(browser.eval(&choose("")), 2);
    // Sorted by the name of the planner, up and down.
    let first = "document.querySelector('.standings tbody tr td:nth-child(2) a').textContent";
    browser.click(".standings thead th:nth-child(2)");
    assert_eq!(browser.eval(first), "pid");
    browser.click(".standings thead th:nth-child(2)");
    assert_eq!(browser.eval(first), "pursuit");
    assert!(browser.screenshot().content() > 0.03, "a page without content");
    let link = browser.eval("document.querySelector('.standings a[href*=pursuit]').getAttribute('href')");
    assert_eq!(link, "entries/pursuit/index.html");
    browser.open(&mini.path("site/entries/pursuit/index.html"));
    let links = browser.eval("[...document.querySelectorAll('a')].map(a => a.getAttribute('href')).filter(h => !h.startsWith('#'))");
    for link in links.as_array().expect("a list").iter().filter_map(Value::as_str) {
        assert!(mini.path("site/entries/pursuit").join(link).is_file(), "{link} leads nowhere");
    }
    // A small map leads to the large one, whose pictures lie beside the page; from there to the replay, and from a row of the report
    // to the map.
    assert_eq!(browser.eval("document.querySelectorAll('.maps .thumbnail').length"), 2);
    let picture = |of: &str| {
        format!(
            "(() => {{ const i = new Image(); i.src = document.querySelector({of:?}).href.baseVal; return i.decode().then(() => \
             i.naturalWidth); }})()"
        )
    };
    assert_eq!(browser.eval(&picture(".thumbnail image")), 128);
    browser.open_at(&mini.path("site/entries/pursuit/maps/w001.html"), "#t00");
    assert_eq!(browser.eval("document.querySelector('tr.on th').textContent"), "t00");
    assert!(browser.eval(&picture("image.shade")).as_f64().is_some_and(|w| w > 256.0));
    assert_eq!(
        browser.eval("document.querySelectorAll('.ways .way').length"),
        1,
        "one task of it has a trace"
    );
    assert_eq!(
        browser.eval("document.querySelectorAll('.ways .end').length"),
        9,
        "of others it is seen where they ended"
    );
    assert_eq!(browser.eval("document.querySelectorAll('.ways .unplaced').length"), 0);
    let links =
        browser.eval("[...document.querySelectorAll('a')].map(a => a.getAttribute('href').split('#')[0])");
    for link in links.as_array().expect("a list").iter().filter_map(Value::as_str) {
        assert!(mini.path("site/entries/pursuit/maps").join(link).is_file(), "{link} leads nowhere");
    }
    assert!(links.to_string().contains("../replays/w001/t00.html"), "{links}");
    browser.open(&mini.path("site/entries/pursuit/replays/w001/t00.html"));
    assert_eq!(browser.eval("document.querySelector('#task').textContent"), "w001/t00");
    browser.open(&mini.path("site/entries/pursuit/report.html"));
    assert_eq!(browser.eval("document.querySelectorAll('#browser tbody tr').length"), 20);
    assert_eq!(browser.eval("document.querySelectorAll('#browser a[href^=\"maps/w00\"]').length"), 20);

    // What entrants write is text, wherever it is.
    for page in
        ["index.html", "entries/pid/index.html", "entries/pid/report.html", "entries/pid/maps/w002.html"]
    {
        browser.open(&mini.path("site").join(page));
        browser.eval("new Promise(done => setTimeout(done, 200))");
        assert_ne!(browser.eval("document.title"), "owned", "{page}");
        assert_eq!(browser.eval("document.querySelectorAll('img').length"), 0, "{page}");
    }
    let errors: Vec<&String> = browser.errors().iter().collect();
    assert_eq!(errors, [] as [&String; 0]);

    // Nothing sticks out of a phone's screen, whatever texts there are.
    let Some(mut phone) = Browser::start(390, 844) else { return };
    for page in [
        "index.html",
        "entries/pid/index.html",
        "entries/pursuit/index.html",
        "entries/pursuit/maps/w001.html",
    ] {
        phone.open(&mini.path("site").join(page));
        phone.phone(390, 844);
        let width = phone.eval("document.documentElement.scrollWidth").as_f64().expect("a width");
        assert!(width <= 390.0, "{page}: {width} px");
        assert!(phone.screenshot().content() > 0.03, "{page}");
    }
}

#[test]
fn entries_that_cannot_be_shown_are_named() {
    let mini = Mini::new();
    let pid = pid();
    mini.ok(&["--plugin", text(&pid), "--suite", "mini", "--tasks", "w001/t00", "--out", "run"]);
    mini.ok(&["submit", "--plugin", text(&pid), "--run", "run", "--out", "accepted/a"]);
    let build = || mini.run(&["leaderboard", "build", "accepted", "--out", "site"]);
    let told = build().error(3);
    assert!(told.contains("accepted/a: verification.json is missing"), "{told}");
    mini.ok(&["verify", "accepted/a", "--plugin", text(&pid)]);
    let manifest = fs::read_to_string(mini.path("accepted/a/submission.json")).expect("a manifest");
    mini.bench.write("accepted/a/submission.json", manifest.replace("\"open\"", "\"ranked\""));
    let told = build().error(3);
    assert!(told.contains("verify again") && !mini.path("site").exists(), "{told}");
    mini.bench.write("accepted/a/submission.json", manifest);
    assert_eq!(build().status.code(), Some(0));
    // A site that is there is replaced only on purpose.
    let told = build().error(4);
    assert!(told.contains("leaderboard.json already exists") && told.contains("--force"), "{told}");
    mini.ok(&["leaderboard", "build", "accepted", "--out", "site", "--force"]);
    mini.bench.write("elsewhere/thesis.tex", "");
    assert!(
        mini.run(&["leaderboard", "build", "accepted", "--out", "elsewhere"]).error(4).contains("not empty")
    );
    assert!(mini.run(&["leaderboard", "build", "nowhere", "--out", "new"]).error(3).contains("nowhere"));
}
