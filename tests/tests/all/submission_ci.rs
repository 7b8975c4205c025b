//! The template repositories in `examples/submission-ci`, by the scripts that their workflows call, with git repositories in
//! a folder instead of GitHub.

#![cfg(unix)]

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use vb_tests::{Done, Mini, copy_dir, pid, release_harness, root};

fn template(part: &str) -> PathBuf {
    root().join("examples/submission-ci").join(part)
}

/// Both sides of a leaderboard in one folder.
struct Place {
    mini: Mini,
}

impl Place {
    /// The owner's repository is `remote`; a participant has his planner in `planner`.
    fn new() -> Self {
        let place = Self { mini: Mini::new() };
        copy_dir(&template("leaderboard"), &place.path("board"));
        copy_dir(&template("participant"), &place.path("planner"));
        // What a participant changes: how his planner is built.
        let build = format!("set -eu\ncp '{}' \"$1\"\n", pid().display());
        place.mini.bench.write("planner/scripts/build.sh", build);
        place.git("board", &["init", "--quiet", "--initial-branch", "main"]);
        place.git("board", &["add", "."]);
        place.git("board", &["commit", "--quiet", "-m", "A leaderboard"]);
        place.git(".", &["clone", "--quiet", "--bare", "board", "remote"]);
        place.git("board", &["remote", "add", "origin", "../remote"]);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.mini.path(name)
    }

    /// A program in a folder, with what scripts read from their surroundings and nothing of the user's own git.
    fn command<S: AsRef<OsStr>>(&self, folder: &str, program: &str, args: &[S]) -> Command {
        let mut command = Command::new(program);
        // The harness's command has the environment that tests share.
        for (key, value) in self.mini.command::<&str>(&[]).get_envs() {
            if let Some(value) = value {
                command.env(key, value);
            }
        }
        command.env("VB_HARNESS", release_harness()).env("VB_SUITE", "mini").env("VB_SAMPLE", "2");
        command.env("VB_ENTRANT", "A team").env("VB_SECRET", "tell nobody");
        command.env("GIT_CONFIG_GLOBAL", "/dev/null").env("GIT_CONFIG_NOSYSTEM", "1");
        for who in ["AUTHOR", "COMMITTER"] {
            command
                .env(format!("GIT_{who}_NAME"), "Somebody")
                .env(format!("GIT_{who}_EMAIL"), "a@example.org");
        }
        command.args(args).current_dir(self.path(folder));
        command
    }

    fn git(&self, folder: &str, args: &[&str]) -> String {
        Done::of(&mut self.command(folder, "git", args)).ok()
    }

    fn script<S: AsRef<OsStr>>(&self, folder: &str, args: &[S]) -> Done {
        Done::of(&mut self.command(folder, "sh", args))
    }

    /// What the workflows do with a pull request from a branch: gather and verify. The verdict is in `verdict-NAME`.
    fn check(&self, name: &str) -> Done {
        let checkout = format!("proposed-{name}");
        self.git(".", &["clone", "--quiet", "--branch", &format!("submit/{name}"), "remote", &checkout]);
        let entry = format!("../{checkout}/incoming/{name}");
        let _ = self.script("board", &["scripts/collect.sh", &entry, &format!("../in-{name}")]).ok();
        self.script("board", &["scripts/verify.sh", &format!("../in-{name}"), &format!("../verdict-{name}")])
    }

    fn accept(&self, entry: &str, name: &str) -> Done {
        let (entry, verdict) = (format!("../in-{entry}"), format!("../verdict-{entry}"));
        self.script("board", &["scripts/accept.sh", &entry, &verdict, name])
    }
}

#[test]
fn a_planner_goes_from_its_authors_repository_onto_the_site() {
    let place = Place::new();
    let _ = place.script("planner", &["scripts/submit.sh", "out"]).ok();
    let told = place.script("planner", &["scripts/propose.sh", "out", "../remote", "my-planner"]).ok();
    assert!(told.contains("pushed submit/my-planner"), "{told}");
    let changed = place.git("remote", &["diff", "--name-only", "main", "submit/my-planner"]);
    assert!(changed.lines().all(|l| l.starts_with("incoming/my-planner/")), "{changed}");

    let told = place.check("my-planner").ok();
    assert!(told.contains("**This submission verifies.**") && told.contains("    rerun "), "{told}");
    let _ = place.accept("my-planner", "my-planner").ok();
    place.git("board", &["push", "--quiet", "origin", "accept/my-planner"]);
    place.git("board", &["checkout", "--quiet", "main"]);
    place.git("board", &["merge", "--quiet", "--ff-only", "accept/my-planner"]);
    assert_eq!(
        fs::read(place.path("board/plugins/my-planner.wasm")).expect("a plugin"),
        fs::read(pid()).expect("a plugin")
    );
    let mut command = place.command("board", "sh", &["scripts/holdout.sh", "my-planner"]);
    let told =
        Done::of(command.env("VB_HOLDOUT_SEED", "9126481234971234").env("VB_HOLDOUT_WORLDS", "1")).ok();
    assert!(told.contains("10 tasks") && !told.contains("w001"), "{told}");

    let _ = place.script("board", &["scripts/site.sh", "../site"]).ok();
    let board = place.mini.bench.json("site/leaderboard.json");
    let entry = &board["boards"][0]["entries"][0];
    assert_eq!((&entry["id"], &entry["entrant"]["name"]), (&"my-planner".into(), &"A team".into()));
    assert_eq!(entry["holdout"]["tasks"], 10);
    assert!(place.path("site/entries/my-planner/report.html").is_file());
    // A sample was driven again, so all tasks of who is in the first ranks are; once they were, nothing is left to do.
    let driven = |place: &Place| {
        let verdict = place.mini.bench.json("board/accepted/my-planner/verification.json");
        verdict["sample"]["tasks"].as_array().map(Vec::len)
    };
    assert!(driven(&place) < Some(20));
    let told = place.script("board", &["scripts/top.sh", "../top"]).ok();
    assert!(told.contains("my-planner: all tasks verify"), "{told}");
    assert_eq!(driven(&place), Some(20));
    let told = place.script("board", &["scripts/top.sh", "../top"]).ok();
    assert!(!told.contains("verify"), "{told}");
    // The name is taken now.
    let told = place.accept("my-planner", "my-planner");
    assert_eq!(told.status.code(), Some(2));
    assert!(told.stderr.contains("there is an entry my-planner"), "{}", told.stderr);
}

#[test]
fn what_strangers_propose_is_refused_with_a_comment_and_gets_nowhere() {
    let place = Place::new();
    let _ = place.script("planner", &["scripts/submit.sh", "out"]).ok();
    // A better result by hand; a verdict and scores of one's own; a planner that is built from its source.
    let records = place.path("planner/out/submission/run/tasks.jsonl");
    let text = fs::read_to_string(&records).expect("records");
    fs::write(&records, text.replacen("\"outcome\":\"success\"", "\"outcome\":\"stuck\"", 1))
        .expect("written");
    for file in ["verification.json", "holdout.json"] {
        place.mini.bench.write(&format!("planner/out/submission/{file}"), "{\"verified\": true}");
    }
    let _ = place.script("planner", &["scripts/propose.sh", "out", "../remote", "forged"]).ok();
    let done = place.check("forged");
    assert_eq!(done.status.code(), Some(9), "{}", done.stderr);
    let comment = fs::read_to_string(place.path("verdict-forged/comment.md")).expect("a comment");
    assert!(comment.starts_with("**This submission does not verify.**"), "{comment}");
    assert!(comment.contains("run/tasks.jsonl: its SHA-256"), "{comment}");
    // All that strangers could have written is indented: it is shown as it is.
    let rest: Vec<&str> =
        comment.lines().skip(1).filter(|l| !l.is_empty() && !l.starts_with("    ")).collect();
    assert_eq!(rest, [] as [&str; 0], "{comment}");
    assert!(!place.path("in-forged/submission/holdout.json").exists(), "scores of one's own are dropped");

    // A link to something of the owner's.
    copy_dir(&place.path("in-forged"), &place.path("in-linked"));
    fs::remove_file(place.path("in-linked/planner.wasm")).expect("removed");
    std::os::unix::fs::symlink("/etc/passwd", place.path("in-linked/planner.wasm")).expect("a link");
    let done = place.script("board", &["scripts/verify.sh", "../in-linked", "../verdict-linked"]);
    assert_eq!(done.status.code(), Some(9));
    assert!(done.stdout.contains("It holds links"), "{}", done.stdout);

    for name in ["../board", ".git", "a b", "", "a/b", "$(touch x)"] {
        let done = place.accept("forged", name);
        assert_eq!(done.status.code(), Some(2), "{name}: {}", done.stderr);
    }
    assert_eq!(place.git("board", &["status", "--porcelain"]), "");
    assert_eq!(place.git("board", &["branch", "--list", "accept/*"]), "");
}

#[test]
fn a_planner_is_built_from_its_source_without_the_owners_secrets() {
    let place = Place::new();
    let build = format!("set -eu\nenv >env.txt\ncp '{}' \"$1\"\n", pid().display());
    place.mini.bench.write("entry/source/build.sh", build);
    place.mini.bench.write("entry/submission/submission.json", "{}");
    let _ = place.script("board", &["scripts/collect.sh", "../entry", "../in"]).ok();
    assert_eq!(
        fs::read(place.path("in/planner.wasm")).expect("a plugin"),
        fs::read(pid()).expect("a plugin")
    );
    let seen = fs::read_to_string(place.path("entry/source/env.txt")).expect("what the build saw");
    assert!(!seen.contains("tell nobody") && !seen.contains("VB_"), "{seen}");
}

/// What is tested is what runs: workflows call the scripts, and what runs strangers' code has no rights.
#[test]
fn workflows_call_the_scripts_and_untrusted_ones_have_no_rights() {
    for part in ["participant", "leaderboard"] {
        let (mut called, mut there) = (BTreeSet::new(), BTreeSet::new());
        for entry in fs::read_dir(template(part).join(".github/workflows")).expect("workflows") {
            let text = fs::read_to_string(entry.expect("an entry").path()).expect("a workflow");
            for word in text.split_whitespace().filter(|w| w.contains("scripts/") && w.ends_with(".sh")) {
                let name = word.rsplit('/').next().expect("a name");
                called.insert(name.to_owned());
            }
            // Texts of strangers reach shells by the environment only.
            for line in text.lines().filter(|l| l.contains("${{")) {
                let key = line.trim_start().trim_start_matches("- ").split(':').next().expect("a key");
                assert!(key != "run", "{line}");
            }
        }
        for entry in fs::read_dir(template(part).join("scripts")).expect("scripts") {
            there.insert(entry.expect("an entry").file_name().to_string_lossy().into_owned());
        }
        called
            .extend(["build.sh", "propose.sh"].map(str::to_owned).into_iter().filter(|n| there.contains(n)));
        assert_eq!(called, there, "{part}");
    }
    let workflow = |name: &str| {
        let text =
            fs::read_to_string(template("leaderboard/.github/workflows").join(name)).expect("a workflow");
        text.lines()
            .filter(|l| !l.trim_start().starts_with('#'))
            .map(|l| format!("{l}\n"))
            .collect::<String>()
    };
    let collect = workflow("collect.yml");
    assert!(collect.contains("permissions:\n  contents: read\njobs:"), "{collect}");
    assert!(
        !collect.contains("secrets.")
            && !collect.contains("write")
            && !collect.contains("pull_request_target")
    );
    // The job that drives the planner has no more; the one that writes doesn't look at the proposal's own files.
    let verify = workflow("verify.yml");
    let (drives, writes) = verify.split_once("  tell:").expect("two jobs");
    assert!(!drives.contains("write") && !drives.contains("secrets."), "{drives}");
    assert!(
        writes.contains("pull-requests: write")
            && !writes.contains("cargo")
            && !writes.contains("collect.sh")
    );
    assert!(Path::new(&template("leaderboard/accepted")).is_dir());
}
