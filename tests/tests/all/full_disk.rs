//! Results that can't be written: one line, exit code 4, and nothing lost of what was written before.
#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use vb_tests::{Bench, Done, PluginKind, pid, plugin};

const OUTPUT: i32 = 4;

/// A small file system in memory, for those who may mount one; it is gone with this.
struct Disk(PathBuf);

impl Disk {
    fn mount(at: PathBuf, options: &str) -> Option<Self> {
        fs::create_dir(&at).expect("a folder to mount on");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(&at).output();
        if mounted.is_ok_and(|o| o.status.success()) {
            return Some(Self(at));
        }
        vb_testing::skip("mounting a file system takes root");
        None
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

fn args<'a>(plugin: &'a Path, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let plugin = plugin.to_str().expect("paths of tests are text");
    [&["--plugin", plugin, "--param", "speed=5", "--tasks", "w001", "--jobs", "1", "--out", out], more]
        .concat()
}

#[test]
fn a_full_disk_stops_the_run_and_with_space_it_goes_on() {
    let bench = Bench::new();
    // A trace of 10 Hz takes about 45 kB of these.
    let Some(disk) = Disk::mount(bench.path("disk"), "size=256k") else { return };
    let plugin = pid();
    let e = bench.run(&args(&plugin, "disk/r", &[])).error(OUTPUT);
    assert!(
        e.contains("disk/r") && e.contains("free some space") && e.contains("the same command and --resume"),
        "{e}"
    );
    // A run keeps its own settings: --resume would refuse another --trace.
    assert!(e.contains("a new run with --trace none"), "{e}");
    let safe = bench.records("disk/r").len();
    assert!((1..10).contains(&safe), "{safe}");
    // What is there can be scored.
    bench.ok(&["score", "disk/r"]);

    let more = Command::new("mount").args(["-o", "remount,size=8m"]).arg(&disk.0).status();
    assert!(more.expect("mount is there").success());
    let told = bench.ok(&args(&plugin, "disk/r", &["--resume", "--message-format", "json"]));
    assert!(
        told.starts_with(&format!("{{\"event\":\"started\",\"total\":10,\"resumed\":{safe}}}")),
        "{told}"
    );
    bench.ok(&args(&plugin, "whole", &[]));
    assert_eq!(bench.records("disk/r"), bench.records("whole"));
    assert!(bench.files("disk/r/traces") == bench.files("whole/traces"));
}

/// The system's limit on the size of a file needs no rights: to the writer it is a disk that is full. (In WASM the
/// planner's memory counts as a file, so the planner is a native one.)
#[test]
fn a_limit_on_the_size_of_files_is_told_as_a_full_disk() {
    let bench = Bench::new();
    let plugin = plugin("pid", PluginKind::Native);
    let harness = bench.command(&args(&plugin, "r", &[]));
    let mut limited = Command::new("sh");
    // 8 KiB: enough for run.json, not for a trace. Without the trap the signal would end the process.
    limited.args(["-c", "trap '' XFSZ; ulimit -f 16; exec \"$@\"", "sh"]);
    limited.arg(harness.get_program()).args(harness.get_args()).current_dir(bench.path(""));
    limited.envs(harness.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let e = Done::of(&mut limited).error(OUTPUT);
    assert!(e.contains("r/traces/w001") && e.contains("free some space"), "{e}");
    assert_eq!(bench.records("r").len(), 0);
    bench.ok(&args(&plugin, "r", &["--resume"]));
    assert_eq!(bench.records("r").len(), 10);
}

#[test]
fn a_directory_without_permission_to_write_is_named() {
    let bench = Bench::new();
    let dir = bench.path("closed");
    // Root may write wherever the file system lets it.
    let _disk = if Command::new("id").arg("-u").output().expect("id is there").stdout == b"0\n" {
        let Some(disk) = Disk::mount(dir, "ro") else { return };
        Some(disk)
    } else {
        use std::os::unix::fs::PermissionsExt as _;
        fs::create_dir(&dir).expect("a folder");
        fs::set_permissions(&dir, fs::Permissions::from_mode(0o555)).expect("it is ours");
        None
    };
    let e = bench.run(&args(&pid(), "closed/r", &[])).error(OUTPUT);
    assert!(e.contains("closed/r") && e.contains("may write") && e.contains("--out"), "{e}");
    let generate = ["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "closed/s"];
    let e = bench.run(&generate).error(OUTPUT);
    assert!(e.contains("closed/s"), "{e}");
}
