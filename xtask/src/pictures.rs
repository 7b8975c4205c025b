//! The pictures of the README, from drives over the small suite.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::run::{Failure, remove, run, step};
use crate::{build_all, built, default_plugin_dir, root, target_dir};

/// The planners of the pictures: the simplest, and the best of each kind.
const PLANNERS: [&str; 4] = ["pid", "rl", "tal", "ibex"];
const SUITE: &str = "smoke";
/// The task that is filmed: one of rough ground and boulders that two of them do and two don't.
const TASK: &str = "w009/t06";
/// Where the pictures are kept, below the root.
const FOLDER: &str = "docs/pictures";
/// Tasks that are driven again to verify each entry of the leaderboard.
const SAMPLE: &str = "10";
/// The browser that takes the picture of a page.
const BROWSER: &str = "chromium";
/// Pixels of it, across and down.
const WINDOW: &str = "1180,560";

/// Drives, and makes the pictures of the README anew: the same everywhere but for the leaderboard, which a browser draws with the
/// machine's fonts.
pub(crate) fn pictures() -> Result<(), Failure> {
    build_all()?;
    let dir = target_dir().join("pictures");
    remove(&dir)?;
    let out = root().join(FOLDER);
    std::fs::create_dir_all(&out).map_err(|e| failed("make", &out, &e))?;
    let runs: Vec<_> = PLANNERS.iter().map(|name| dir.join(name)).collect();
    for (name, folder) in PLANNERS.iter().zip(&runs) {
        step(&format!("driving {name}"));
        let plugin = plugin(name);
        harness(|c| c.arg("--plugin").arg(plugin).args(["--suite", SUITE, "--out"]).arg(folder))?;
    }
    step("drawing");
    let replay = |more: &[&str], option: &str, name: &str| {
        harness(|c| {
            c.arg("replay")
                .args(&runs)
                .args(["--task", TASK, "--force"])
                .args(more)
                .arg(option)
                .arg(out.join(name))
        })
    };
    replay(&["--size", "560x316", "--fps", "8", "--speed", "4"], "--video", "drive.gif")?;
    replay(&["--size", "900x900", "--camera", "map"], "--png", "ways.png")?;
    let figures = dir.join("figures");
    harness(|c| c.arg("report").args(&runs).arg("--figures").arg(&figures))?;
    let (from, to) = (figures.join("results.svg"), out.join("success.svg"));
    std::fs::copy(&from, &to).map_err(|e| failed("copy to", &to, &e))?;
    leaderboard(&runs, &dir, &out)?;
    step(&format!("pictures: {}", out.display()));
    Ok(())
}

/// The upper part of a leaderboard of these runs.
fn leaderboard(runs: &[std::path::PathBuf], dir: &Path, out: &Path) -> Result<(), Failure> {
    let (accepted, site) = (dir.join("accepted"), dir.join("site"));
    std::fs::create_dir_all(&accepted).map_err(|e| failed("make", &accepted, &e))?;
    for (name, folder) in PLANNERS.iter().zip(runs) {
        let (plugin, entry) = (plugin(name), accepted.join(name));
        harness(|c| {
            c.arg("submit").arg("--plugin").arg(&plugin).arg("--run").arg(folder).arg("--out").arg(&entry)
        })?;
        harness(|c| {
            c.arg("verify").arg(&entry).arg("--plugin").arg(&plugin).args(["--sample", SAMPLE, "--seed", "1"])
        })?;
    }
    harness(|c| c.args(["leaderboard", "build"]).arg(&accepted).arg("--out").arg(&site))?;
    let mut browser = Command::new(BROWSER);
    browser.args(["--headless=new", "--no-sandbox", "--hide-scrollbars", &format!("--window-size={WINDOW}")]);
    browser.arg(format!("--screenshot={}", out.join("leaderboard.png").display()));
    browser.arg(format!("file://{}", site.join("index.html").display())).stderr(Stdio::null());
    run(&mut browser)
}

fn plugin(name: &str) -> std::path::PathBuf {
    default_plugin_dir().join(format!("{name}.wasm"))
}

/// Runs the harness with arguments; only its errors are seen.
fn harness(arguments: impl FnOnce(&mut Command) -> &mut Command) -> Result<(), Failure> {
    let mut command = Command::new(built("vb-harness"));
    arguments(&mut command);
    run(command.current_dir(root()).stdout(Stdio::null()))
}

fn failed(what: &str, path: &Path, e: &std::io::Error) -> Failure {
    Failure::new(format!("can't {what} {}: {e}", path.display()))
}
