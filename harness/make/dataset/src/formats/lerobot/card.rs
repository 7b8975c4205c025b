//! The card of a dataset: `README.md`, which people and the Hugging Face hub read.

use crate::feature::Feature;
use crate::format::Whole;
use crate::header::{Header, Kind};

/// A number with a comma after each three digits.
fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(c);
    }
    text
}

fn about(header: &Header) -> String {
    match header.kind {
        Kind::Explore => {
            let rules = header.exploration.as_ref().map(|e| e.description.as_str()).unwrap_or_default();
            format!("Random exploration of rough terrain. {rules}")
        }
        Kind::Drive => {
            let names: Vec<String> =
                header.planners.iter().map(|p| format!("{} {}", p.name, p.version)).collect();
            format!("Navigation tasks on rough terrain, driven by {}.", names.join(", "))
        }
        Kind::Teleop => "Navigation tasks on rough terrain, driven by a person.".to_owned(),
        Kind::Failures => "The last seconds before rollovers and immobilisations of a vehicle.".to_owned(),
        Kind::Merged => "Several merged datasets of driving on rough terrain.".to_owned(),
        Kind::Split => "Part of a dataset of driving on rough terrain.".to_owned(),
    }
}

/// Returns the command that reproduces the dataset.
fn again(header: &Header) -> String {
    let command = format!("```console\n$ vb-harness {} --out DIR\n```", header.command.join(" "));
    match header.kind {
        Kind::Teleop => {
            format!(
                "A person drove, so the dataset can't be reproduced. This command records more:\n\n{command}"
            )
        }
        _ => format!(
            "This command reproduces the dataset, byte for byte, with the same version of the harness:\n\n{command}"
        ),
    }
}

pub(crate) fn card(header: &Header, features: &[Feature], whole: &Whole) -> String {
    let Whole { episodes, frames, summary, .. } = whole;
    let hours = *frames as f64 / f64::from(header.hz) / 3600.0;
    let outcomes: Vec<String> =
        summary.outcomes.iter().map(|(name, n)| format!("{name} {}", grouped(*n))).collect();
    let mut rows = String::new();
    for f in features {
        let shape: Vec<String> = f.shape.iter().map(usize::to_string).collect();
        let names = if f.names.len() > 1 { format!(": {}", f.names.join(", ")) } else { String::new() };
        rows +=
            &format!("| `{}` | {} | {} | {}{names} |\n", f.name, f.dtype.name(), shape.join(" × "), f.about);
    }
    let Header { name, licence, harness_version, harness_commit, seed, hz, scale, .. } = header;
    format!(
        "---\n\
         license: {}\n\
         task_categories:\n- robotics\n\
         tags:\n- LeRobot\n- off-road\n- vertibench\n\
         configs:\n- config_name: default\n  data_files: data/*/*.parquet\n\
         ---\n\n\
         # {name}\n\n\
         {} Recorded with Verti-Bench in Rust.\n\n\
         | | |\n|---|---|\n\
         | episodes | {} |\n| frames | {} at {hz} Hz: {hours:.2} h, {:.1} km |\n| outcomes | {} |\n\
         | vehicle | {} (`{}`) |\n| perception | {} (`{}`) |\n| rules | {} (`{}`) |\n| soils | {} (`{}`) |\n\
         | worlds | {} (`{}`), scale {scale}, in the folder `suite` |\n\
         | seed | {seed} |\n| licence | {licence} |\n| created by | vb-harness {harness_version}, commit {harness_commit} |\n\n\
         The values in brackets are SHA-256 hashes. {}\n\n\
         {}\n\n\
         ## Columns\n\n\
         The layout is LeRobot's, version 3.0. Units are SI and angles radians; the world's axes are x east, y north, z up, the\n\
         body's x forward, y left, z up. A frame contains the observation and the command at its `timestamp`.\n\n\
         | column | type | shape | |\n|---|---|---|---|\n{rows}\n\
         `meta/episodes` has one row per episode with its world, driver, outcome and reason.\n",
        licence.to_lowercase(),
        about(header),
        grouped(*episodes),
        grouped(*frames),
        summary.distance_m / 1000.0,
        outcomes.join(", "),
        header.vehicle.name,
        header.vehicle.hash,
        header.perception.name,
        header.perception.hash,
        header.rules.name,
        header.rules.hash,
        header.soils.name,
        header.soils.hash,
        header.worlds.name,
        header.worlds.hash,
        if header.of_a_suite {
            "**The worlds belong to a benchmark suite. The dataset is for inspection only and must not be used for training or tuning.**"
        } else {
            "No world belongs to a benchmark suite."
        },
        again(header),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_three() {
        assert_eq!([0, 12, 123, 1234, 1_234_567].map(grouped), ["0", "12", "123", "1,234", "1,234,567"]);
    }
}
