//! `vb-harness vehicle compare`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_page::rounded;
use vb_validate::{Figure, Recording};

use crate::args::values::duration;
use crate::args::{ForceArgs, FormatArgs, MessageFormat, TIME_STEP};
use crate::error::CliError;
use crate::{output, places};

#[derive(Debug, Args)]
pub(crate) struct VehicleCompareArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// Recording: CSV with the columns window, time (s), left and right (wheel speeds of a side, rad/s), x, y (m) and yaw (rad); rows of a
    /// window follow each other, and its first and last row have a pose. Or a table of DRIVE (torch_ready_dataframe.csv), with a window in
    /// each row
    #[arg(value_name = "RECORDING")]
    pub(crate) recording: PathBuf,
    /// Friction coefficients of the ground, which recordings do not have
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "0.2,0.3,0.4,0.5,0.6,0.8,1")]
    pub(crate) friction: Vec<f64>,
    /// Directory for report.html, results.json and the table of windows; default: runs/compare-VEHICLE-N
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Simulation step, s or with a unit (0.01ms to 10ms)
    #[arg(long, value_name = "TIME", default_value_t = TIME_STEP, value_parser = duration)]
    pub(crate) time_step: f64,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Friction coefficients that a ground may have.
const FRICTION: std::ops::RangeInclusive<f64> = 0.01..=2.0;

#[derive(Serialize)]
struct ComparisonMessage<'a> {
    event: &'static str,
    vehicle: &'a str,
    recording: &'a Path,
    figures: &'a [Figure],
    report: &'a Path,
}

pub(super) fn compare(args: &VehicleCompareArgs) -> Result<(), CliError> {
    let (_, spec) = places::vehicle(&args.vehicle)?;
    let mut frictions = args.friction.clone();
    if let Some(wrong) = frictions.iter().find(|f| !FRICTION.contains(f)) {
        let (least, most) = (FRICTION.start(), FRICTION.end());
        return Err(CliError::usage(format!("--friction {wrong}: must lie in {least} to {most}")));
    }
    frictions.sort_by(f64::total_cmp);
    frictions.dedup();
    let recording = Recording::load(&args.recording).map_err(CliError::input)?;
    let out = args.out.clone().unwrap_or_else(|| places::new_run_dir(&format!("compare-{}", spec.name)));
    output::must_not_replace(&out.join("report.html"), args.force)?;
    std::fs::create_dir_all(&out).map_err(|e| CliError::output(format!("{}: {e}", out.display())))?;
    let report = vb_validate::replay(&spec, &recording, &frictions, args.time_step)?;
    report.write(&out).map_err(CliError::output)?;
    let page = out.join("report.html");
    let figures = report.results.iter().flat_map(|r| &r.outcome.figures);
    if args.format.get() == MessageFormat::Json {
        let figures: Vec<Figure> = figures.cloned().collect();
        output::json(&ComparisonMessage {
            event: "comparison",
            vehicle: &spec.name,
            recording: &args.recording,
            figures: &figures,
            report: &page,
        });
        return Ok(());
    }
    let rows: Vec<Vec<String>> =
        figures.map(|f| vec![f.name.clone(), rounded(f.value), f.unit.to_owned()]).collect();
    output::text(&output::columns(&rows));
    output::say(&page.display().to_string());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::VehicleCommand;
    use crate::cli::parse;
    use crate::command::Command;

    #[test]
    fn the_default_of_a_list_is_what_a_user_could_give() {
        let friction = |more: &[&str]| match parse(&[&["vehicle", "compare", "v", "r.csv"], more].concat()) {
            Ok(Command::Vehicle(VehicleCommand::Compare(args))) => args.friction,
            other => panic!("{other:?}"),
        };
        assert_eq!(friction(&[]), friction(&["--friction", "0.2,0.3,0.4,0.5,0.6,0.8,1"]));
        assert_eq!(friction(&[]).len(), 7);
    }
}
