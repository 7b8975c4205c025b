//! `vb-harness inspect`.

use serde::Serialize;
use vb_host::{Limits, Plugin, one_line};

use crate::args::{InspectArgs, MessageFormat};
use crate::error::CliError;
use crate::{output, planner};

#[derive(Serialize)]
struct Message<'a> {
    event: &'static str,
    name: &'a str,
    version: &'a str,
    abi: &'a str,
    authors: &'a [String],
    about: &'a str,
    control_period_s: f64,
    params: Vec<Param<'a>>,
}

#[derive(Serialize)]
struct Param<'a> {
    key: &'a str,
    default: &'a str,
    help: &'a str,
}

pub(crate) fn inspect(args: &InspectArgs) -> Result<(), CliError> {
    let meta = match planner::command(&args.plugin) {
        // A command has no metadata that could be read without running it.
        Some(words) => Plugin::command(&words, &Limits::default()).map(|p| p.metadata().clone()),
        None => vb_host::inspect(&args.plugin),
    };
    let meta = meta.map_err(|e| CliError::input(format!("{e} ({})", e.code())))?;
    match args.format.get() {
        MessageFormat::Json => output::json(&Message {
            event: "plugin",
            name: &meta.name,
            version: &meta.version,
            abi: &meta.abi,
            authors: &meta.authors,
            about: &meta.about,
            control_period_s: meta.control_period,
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
            ];
            rows.extend(meta.params.iter().map(|p| {
                let text = format!("--param {}={}", one_line(&p.key), one_line(&p.default));
                row(&text, one_line(&p.help))
            }));
            output::text(&output::columns(&rows));
        }
    }
    Ok(())
}
