//! `vb-harness vehicle compare`.

use std::path::Path;

use serde::Serialize;
use vb_page::rounded;
use vb_validate::{Figure, Recording};

use crate::args::{MessageFormat, VehicleCompareArgs};
use crate::error::CliError;
use crate::{output, places};

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
