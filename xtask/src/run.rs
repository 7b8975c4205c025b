//! Running other programs.

use std::ffi::OsString;
use std::fmt;
use std::path::Path;
use std::process::Command;

#[derive(Debug)]
pub(crate) struct Failure(String);

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Says what is being done.
pub(crate) fn step(message: &str) {
    eprintln!("{message}");
}

/// The cargo that runs this task.
pub(crate) fn cargo_program() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Runs cargo in the workspace.
pub(crate) fn cargo(args: &[&str]) -> Result<(), Failure> {
    run(Command::new(cargo_program()).args(args).current_dir(crate::root()))
}

/// Runs a program to its end.
pub(crate) fn run(command: &mut Command) -> Result<(), Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command.status().map_err(|e| Failure::new(format!("can't run {name}: {e}")))?;
    if status.success() {
        return Ok(());
    }
    let args: Vec<_> = command.get_args().map(|a| a.to_string_lossy()).collect();
    Err(Failure::new(format!("`{name} {}` failed ({status})", args.join(" "))))
}

/// Removes what was made in a folder before, if there is anything.
pub(crate) fn remove(folder: &Path) -> Result<(), Failure> {
    if !folder.exists() {
        return Ok(());
    }
    std::fs::remove_dir_all(folder)
        .map_err(|e| Failure::new(format!("can't remove {}: {e}", folder.display())))
}

/// What a program prints, without the end of line; nothing if it fails or isn't there.
pub(crate) fn output(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|o| o.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_names_the_command() {
        let message = run(Command::new(cargo_program()).arg("no-such-subcommand")).unwrap_err().to_string();
        assert!(message.contains("no-such-subcommand") && message.contains("failed"), "{message}");
        let message = run(&mut Command::new("/no/such/program")).unwrap_err().to_string();
        assert!(message.contains("can't run /no/such/program"), "{message}");
        assert_eq!(output(&mut Command::new("/no/such/program")), None);
    }
}
