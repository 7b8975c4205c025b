//! Tells the program which git commit it is built from, as `VB_COMMIT`: where a result is from should be found again. And packs
//! the folder `tasks` for it, which it carries so that it needs no other file.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What the program is made of, as paths of the repository.
const SOURCES: [&str; 4] = ["harness", "sdk", "Cargo.toml", "Cargo.lock"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let commit = commit(&root).or_else(|| told(&root)).unwrap_or_else(|| "unknown".into());
    println!("cargo::rustc-env=VB_COMMIT={commit}");
    #[cfg(feature = "carried-tasks")]
    if let Err(e) = pack(&root.join("tasks")) {
        println!("cargo::error={}: can't pack what the program carries: {e}", root.join("tasks").display());
    }
}

/// Writes the bundle of tasks, and tells the program its hash as `VB_TASKS_HASH`.
#[cfg(feature = "carried-tasks")]
fn pack(tasks: &Path) -> std::io::Result<()> {
    println!("cargo::rerun-if-changed={}", tasks.display());
    let out = std::env::var_os("OUT_DIR").ok_or_else(|| std::io::Error::other("cargo names no OUT_DIR"))?;
    let bundle = vb_files::bundle::pack(tasks)?;
    println!("cargo::rustc-env=VB_TASKS_HASH={}", &vb_files::sha256(&bundle)[..12]);
    std::fs::write(Path::new(&out).join("tasks.bundle"), bundle)
}

/// The commit that a source distribution says it was made of.
fn told(root: &Path) -> Option<String> {
    let text = std::fs::read_to_string(root.join(".commit")).ok()?;
    text.lines().next().map(|line| line.trim().to_owned())
}

/// The commit, with `, modified` if the sources differ from it; none outside of a checkout of this repository, or without git.
fn commit(root: &Path) -> Option<String> {
    let git = |args: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(args).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim_end().to_owned())
    };
    // Sources that were unpacked within another repository are none of its.
    let top = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&top).canonicalize().ok()? != root.canonicalize().ok()? {
        return None;
    }
    let hash = git(&["rev-parse", "HEAD"])?;
    let status = ["status", "--porcelain", "--untracked-files=no", "--"];
    let modified = !git(&[&status[..], &SOURCES].concat())?.is_empty();
    // Asked again only when HEAD moved or a source changed, which builds the program anyway. A path that isn't there would make
    // cargo ask each time. The log of HEAD grows with every commit and checkout, also where HEAD itself names a branch.
    let of_git = ["HEAD", "logs/HEAD"].iter().filter_map(|name| git(&["rev-parse", "--git-path", name]));
    let folders = |of: &Path| -> Vec<PathBuf> {
        of.read_dir().into_iter().flatten().flatten().map(|e| e.path()).collect()
    };
    // Crates are in folders by role, but for the front ends.
    let roles = folders(&root.join("harness"));
    let crates = roles.iter().flat_map(|role| folders(role)).chain(roles.iter().cloned());
    let sources = crates.map(|folder| folder.join("src"));
    let paths =
        of_git.map(|p| root.join(p)).chain(sources).chain(["sdk/src", "Cargo.lock"].map(|p| root.join(p)));
    for path in paths.filter(|p| p.exists()) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    Some(if modified { format!("{hash}, modified") } else { hash })
}
