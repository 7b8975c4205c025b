//! Trajectories of runs over a real place as GeoJSON (RFC 7946), for a map.

use std::path::Path;

use serde_json::json;
use vb_record::RunReader;
use vb_report::Report;
use vb_terrain::crs::Crs;
use vb_world::Provenance;

use crate::error::CliError;
use crate::output;
use crate::places::suite_of;

/// Decimals of a degree: a centimetre.
const DECIMALS: f64 = 1e7;

/// Writes the trajectory of every task that has a trace, with its run, task and outcome.
pub(crate) fn write(report: &Report, suite: Option<&Path>, path: &Path) -> Result<(), CliError> {
    let runs = &report.runs().runs;
    let suite = suite_of(&runs[0].header, suite)?;
    let nowhere = |what: &str| CliError::input(format!("--geojson: suite {} {what}", suite.meta().name));
    let Provenance::Imported { place: Some(place), .. } = &suite.meta().provenance else {
        return Err(nowhere(
            "has no georeference: create it with suite site from a file with a coordinate system, or with --crs",
        ));
    };
    let system = Crs::parse(place.proj.as_deref().unwrap_or(&place.crs)).ok();
    let globe = system.and_then(|crs| crs.to_globe());
    let globe =
        globe.ok_or_else(|| nowhere(&format!("is in {}, which has no known projection", place.crs)))?;
    let mut features = Vec::new();
    for run in runs {
        let reader = RunReader::open(&run.dir)?;
        for row in &run.rows {
            if !reader.has_trace(&row.task)? {
                continue;
            }
            let trace = reader.trace(&row.task)?;
            // A run at another scale has the world smaller than it is on the Earth.
            let at = |x: f64, y: f64| {
                let [lon, lat] = globe
                    .lon_lat(place.at(row.task.world(), [x / run.header.scale, y / run.header.scale])?)?;
                Some([lon, lat].map(|v| (v * DECIMALS).round() / DECIMALS))
            };
            let line: Option<Vec<_>> = trace.samples.iter().map(|s| at(s.x, s.y)).collect();
            let line = line.ok_or_else(|| nowhere(&format!("has no georeference for task {}", row.task)))?;
            // A line has two places at least.
            if line.len() < 2 {
                continue;
            }
            features.push(json!({
                "type": "Feature",
                "properties": {"run": run.label, "task": row.task, "outcome": row.outcome, "time_s": row.time},
                "geometry": {"type": "LineString", "coordinates": line},
            }));
        }
    }
    if features.is_empty() {
        return Err(CliError::usage("--geojson: no run has a trace (run with --trace 10hz or full)"));
    }
    let text = json!({"type": "FeatureCollection", "features": features}).to_string();
    output::write(path, text)
}
