//! The options of the tasks that make files for users.

use std::path::PathBuf;

use crate::run::Failure;
use crate::target_dir;

#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Options {
    /// The system that the files are for; none for this one, as everything else here is built.
    pub(crate) target: Option<String>,
    pub(crate) check: bool,
    pub(crate) out: PathBuf,
}

impl Options {
    /// Reads the options of a task, which writes to this folder of [`target_dir`] if nothing is said. `portable` is the system
    /// that `--portable` stands for, where the task has that option.
    pub(crate) fn parse(
        task: &str,
        args: &[&str],
        folder: &str,
        portable: Option<&str>,
    ) -> Result<Self, Failure> {
        let mut options = Self { target: None, check: false, out: target_dir().join(folder) };
        let mut rest = args.iter();
        while let Some(arg) = rest.next() {
            let mut value =
                || rest.next().ok_or_else(|| Failure::new(format!("{task} {arg}: its value is missing")));
            match (*arg, portable) {
                ("--portable", Some(system)) => {
                    options.target = options.target.or_else(|| Some(system.into()));
                }
                ("--target", _) => options.target = Some((*value()?).into()),
                ("--out", _) => options.out = (*value()?).into(),
                ("--check", _) => options.check = true,
                _ => {
                    return Err(Failure::new(format!(
                        "{task}: no such option: `{arg}` (see `cargo xtask help`)"
                    )));
                }
            }
        }
        Ok(options)
    }
}
