//! `vb-harness suite validate`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_sim::SimOptions;
use vb_suite::validate::{Finding, Limits, Severity, Vehicle};
use vb_trial::static_shape;
use vb_vehicle::VehicleModel;

use crate::args::{FormatArgs, VEHICLE};
use crate::error::CliError;
use crate::{output, places};

#[derive(Debug, Args)]
pub(crate) struct ValidateArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(value_name = "NAME|DIR")]
    pub(crate) suite: PathBuf,
    /// Vehicle that must fit at starts and goals and along paths: a name or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Minimum distance of paths from obstacles, m; smaller distances are warnings
    #[arg(long, value_name = "METRES", default_value_t = limits().clearance, value_parser = length)]
    pub(crate) clearance: f64,
    /// Maximum tilt of the ground under the vehicle, degrees; more is a warning along paths, and an error at starts and goals
    #[arg(long, value_name = "DEGREES", default_value_t = limits().tilt, value_parser = tilt)]
    pub(crate) max_tilt: f64,
    /// Treat warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// The limits of a validation, which are those of any vehicle.
fn limits() -> Limits {
    Limits::of(Vehicle { length: 0.0, width: 0.0 })
}

/// A length in metres, 0 or more.
fn length(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value.filter(|v| (0.0..=1e3).contains(v)).ok_or_else(|| "want metres from 0 to 1000, e.g. 3.5".into())
}

/// An angle of the ground in degrees.
fn tilt(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value.filter(|v| (0.0..=90.0).contains(v)).ok_or_else(|| "want degrees from 0 to 90, e.g. 31".into())
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Finding {
        #[serde(flatten)]
        finding: &'a Finding,
    },
    Summary {
        suite: &'a Path,
        hash: &'a str,
        worlds: usize,
        tasks: usize,
        errors: usize,
        warnings: usize,
        valid: bool,
    },
}

pub(crate) fn validate(args: &ValidateArgs) -> Result<(), CliError> {
    let suite = super::open(&args.suite)?;
    let mut limits = Limits::of(footprint(&args.vehicle)?);
    (limits.clearance, limits.tilt) = (args.clearance, args.max_tilt);
    let json = args.format.is_json();
    let findings = vb_suite::validate::validate(&suite, &limits, |_, found| {
        for finding in found {
            if json {
                output::json(&Message::Finding { finding });
            } else {
                let (severity, rule) = (finding.severity.name(), finding.rule.name());
                output::text(&format!("{severity}[{rule}]: {}\n", finding.text));
            }
        }
    });
    let count = |severity| findings.iter().filter(|f| f.severity == severity).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    let refused = if args.strict { errors + warnings > 0 } else { errors > 0 };
    let (worlds, tasks, hash) = (suite.worlds().len(), suite.task_count(), suite.hash());
    if json {
        let (suite, valid) = (suite.dir(), !refused);
        output::json(&Message::Summary { suite, hash: &hash, worlds, tasks, errors, warnings, valid });
    }
    if refused {
        let first = findings.iter().find(|f| args.strict || f.severity == Severity::Error);
        return Err(CliError::input(format!(
            "{}: {} and {}; the first: {}",
            suite.dir().display(),
            number(errors, "error"),
            number(warnings, "warning"),
            first.map_or("", |f| &f.text)
        )));
    }
    if !json {
        let also = if warnings > 0 { format!(", {}", number(warnings, "warning")) } else { String::new() };
        output::text(&format!(
            "{}: {worlds} worlds, {tasks} tasks, all valid{also}; hash {hash}\n",
            suite.dir().display()
        ));
    }
    Ok(())
}

/// What a vehicle takes up of the full-size world, in which suites are stored.
fn footprint(wanted: &str) -> Result<Vehicle, CliError> {
    let (_, spec) = places::vehicle(wanted)?;
    let scale = spec.scale;
    let model = VehicleModel::new(spec).map_err(CliError::input)?;
    let shape = static_shape(&model, SimOptions::default()).map_err(CliError::input)?;
    Ok(Vehicle { length: shape.length / scale, width: shape.width / scale })
}

fn number(n: usize, what: &str) -> String {
    let s = if n == 1 { "" } else { "s" };
    format!("{n} {what}{s}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_car_takes_up_what_it_would_at_full_size() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tasks/vehicles/verti4wheeler.yaml");
        let v = footprint(file).unwrap();
        // 0.49 m of hull, and 2 (0.1 + 0.0205) m over the tyres, of a car of 1/10.
        assert!((v.length - 4.9).abs() < 0.02 && (v.width - 2.41).abs() < 0.01, "{v:?}");
    }
}
