//! `vb-harness plugin install`: planners that are found by their file names.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::error::CliError;
use crate::output;

#[derive(Debug, Args)]
pub(crate) struct InstallArgs {
    /// Planners: WASM files and native libraries
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Replace installed planners with the same file names
    #[arg(long)]
    pub(crate) force: bool,
}

/// Copies all files, or none if one of them is no planner or would replace an installed one that is to stay.
pub(crate) fn install(args: &InstallArgs) -> Result<(), CliError> {
    let folder = vb_catalog::installed_planners().ok_or_else(|| {
        CliError::output(format!("no folder for planners is defined (set {}, or HOME)", vb_catalog::DATA_VAR))
    })?;
    for file in &args.files {
        vb_host::inspect(file).map_err(|e| CliError::input(e.to_string()))?;
        let installed = file.file_name().map(|name| folder.join(name)).filter(|path| path.exists());
        if let Some(installed) = installed.filter(|_| !args.force) {
            return Err(CliError::output(format!(
                "{} is installed already (replace it with --force, or give the new file another name)",
                installed.display()
            )));
        }
    }
    for file in &args.files {
        let installed = copy(file, &folder).map_err(|e| {
            CliError::output(format!("{}: can't install {}: {e}", folder.display(), file.display()))
        })?;
        output::say(&installed);
    }
    if let Some(named) = std::env::var_os(vb_catalog::PLUGINS_VAR).filter(|v| !v.is_empty()) {
        output::say(&format!(
            "note: {} is {}, so planners are searched only there",
            vb_catalog::PLUGINS_VAR,
            Path::new(&named).display()
        ));
    }
    Ok(())
}

fn copy(file: &Path, folder: &Path) -> std::io::Result<String> {
    let name = file.file_name().ok_or_else(|| std::io::Error::other("it has no file name"))?;
    let bytes = vb_files::read(file, vb_files::DATA)?;
    std::fs::create_dir_all(folder)?;
    let installed = folder.join(name);
    vb_files::write(&installed, &bytes)?;
    Ok(installed.display().to_string())
}
