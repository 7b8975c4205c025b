//! `vb-harness inspect`.

use clap::Args;
use serde::Serialize;
use vb_files::one_line;
use vb_host::{Limits, Plugin};
use vb_record::Recording;
use vb_sdk::metadata::Need;

use crate::args::{FormatArgs, MessageFormat, PluginArgs};
use crate::error::CliError;
use crate::{output, planner};

#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
struct Message<'a> {
    event: &'static str,
    name: &'a str,
    version: &'a str,
    abi: &'a str,
    authors: &'a [String],
    about: &'a str,
    control_period_s: f64,
    needs: Vec<NeedMessage>,
    needs_without_maps: Vec<NeedMessage>,
    models: &'a [String],
    params: Vec<Param<'a>>,
}

#[derive(Serialize)]
struct NeedMessage {
    sensor: &'static str,
    /// `None` where the perception profile decides.
    rate_hz: Option<f64>,
}

impl From<&Need> for NeedMessage {
    fn from(need: &Need) -> Self {
        Self { sensor: need.sensor.name(), rate_hz: need.rate }
    }
}

#[derive(Serialize)]
struct Param<'a> {
    key: &'a str,
    default: &'a str,
    help: &'a str,
}

/// `lidar at 10 Hz, pose`.
fn listed(needs: &[Need]) -> String {
    let texts: Vec<String> = needs
        .iter()
        .map(|need| match need.rate {
            Some(rate) => format!("{} at {rate} Hz", need.sensor.name()),
            None => need.sensor.name().to_owned(),
        })
        .collect();
    texts.join(", ")
}

pub(crate) fn inspect(args: &InspectArgs) -> Result<(), CliError> {
    let meta = match planner::command(args.plugin.path()) {
        // A command has no metadata that could be read without running it.
        Some(words) => Plugin::command(&words, &Limits::default()).map(|p| p.metadata().clone()),
        None if Recording::is_one(args.plugin.path()) => {
            vb_runner::recorded(args.plugin.path(), &Limits::default()).map(|p| p.metadata().clone())
        }
        None => vb_host::inspect(args.plugin.path()),
    };
    let meta = meta.map_err(|e| planner::unusable(&e))?;
    match args.format.get() {
        MessageFormat::Json => output::json(&Message {
            event: "plugin",
            name: &meta.name,
            version: &meta.version,
            abi: &meta.abi,
            authors: &meta.authors,
            about: &meta.about,
            control_period_s: meta.control_period,
            needs: meta.sensors(true).iter().map(NeedMessage::from).collect(),
            needs_without_maps: meta.needs_without_maps.iter().map(NeedMessage::from).collect(),
            models: &meta.models,
            params: meta
                .params
                .iter()
                .map(|p| Param { key: &p.key, default: &p.default, help: &p.help })
                .collect(),
        }),
        MessageFormat::Human => {
            let row = |name: &str, value: String| vec![name.to_owned(), value];
            let mut rows = vec![
                row("planner", format!("{} {}", one_line(&meta.name), one_line(&meta.version))),
                row("about", one_line(&meta.about)),
                row("authors", one_line(&meta.authors.join(", "))),
                row("planner ABI", one_line(&meta.abi)),
                row("control period", format!("{} s", meta.control_period)),
                row("sensors", listed(&meta.sensors(true))),
            ];
            if !meta.needs_without_maps.is_empty() {
                rows.push(row("without maps", listed(&meta.needs_without_maps)));
            }
            rows.extend(meta.models.iter().map(|m| row("model", one_line(m))));
            rows.extend(meta.params.iter().map(|p| {
                let text = format!("--param {}={}", one_line(&p.key), one_line(&p.default));
                row(&text, one_line(&p.help))
            }));
            output::text(&output::columns(&rows));
        }
    }
    Ok(())
}
