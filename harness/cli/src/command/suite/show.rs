//! `vb-harness suite show`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_suite::album::Album;
use vb_suite::proof::Proof;
use vb_suite::statistics::{SuiteStatistics, Survey, Table, WorldStatistics};

use crate::args::{ForceArgs, FormatArgs};
use crate::error::CliError;
use crate::output;

#[derive(Debug, Args)]
pub(crate) struct ShowArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(value_name = "NAME|DIR")]
    pub(crate) suite: PathBuf,
    /// Directory for the HTML report (index.html, with a map of every world) and statistics.json
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    World {
        #[serde(flatten)]
        figures: &'a WorldStatistics,
    },
    Suite {
        #[serde(flatten)]
        statistics: &'a SuiteStatistics,
        #[serde(skip_serializing_if = "Option::is_none")]
        page: Option<&'a Path>,
    },
}

#[derive(Serialize)]
struct StatisticsFile<'a> {
    schema: u32,
    #[serde(flatten)]
    statistics: &'a SuiteStatistics,
    worlds: &'a [WorldStatistics],
}

pub(crate) fn show(args: &ShowArgs) -> Result<(), CliError> {
    let suite = super::open(&args.suite)?;
    if let Some(out) = &args.out {
        output::must_not_replace(&out.join("index.html"), args.force)?;
        // What can't be written is said before all worlds are drawn, not after.
        std::fs::create_dir_all(out).map_err(|e| CliError::output(format!("{}: {e}", out.display())))?;
    }
    let mut survey = Survey::default();
    let mut album = args.out.as_ref().map(|_| Album::new(suite.worlds().len()));
    for info in suite.worlds() {
        let world = suite.load_world(&info.id)?;
        let figures = survey.add(&world);
        if let Some(album) = &mut album {
            album.add(&world, figures);
        }
    }
    let proof = Proof::read(&suite).map_err(CliError::input)?;
    let statistics = survey.finish(&suite, proof.as_ref());
    let page = match args.out.as_ref().zip(album) {
        Some((out, album)) => Some(write(out, &album, &statistics)?),
        None => None,
    };
    if args.format.is_json() {
        for figures in &statistics.worlds {
            output::json(&Message::World { figures });
        }
        output::json(&Message::Suite { statistics: &statistics, page: page.as_deref() });
        return Ok(());
    }
    output::text(&text(&statistics));
    if let Some(page) = page {
        output::say(&format!("wrote {}", page.display()));
    }
    Ok(())
}

/// Writes the page and the figures, and returns where the page is.
fn write(out: &Path, album: &Album, statistics: &SuiteStatistics) -> Result<PathBuf, CliError> {
    let save = |name: &str, text: &str| {
        let path = out.join(name);
        output::write(&path, text).map(|()| path)
    };
    let file = StatisticsFile { schema: 1, statistics, worlds: &statistics.worlds };
    let json = serde_json::to_string_pretty(&file).map_err(CliError::internal)?;
    save("statistics.json", &(json + "\n"))?;
    save("index.html", &album.page(statistics))
}

/// Everything for the terminal: the long table of worlds first, so that the figures stand where one looks.
fn text(s: &SuiteStatistics) -> String {
    let mut out = table(&s.world_table());
    for t in s.tables() {
        out += &table(&t);
    }
    let [name, version, description, provenance] =
        [&s.name, &s.version, &s.description, &s.provenance].map(|text| plain(text));
    let proof = s.proof.as_ref().map_or_else(String::new, |p| format!("tasks {}\n", plain(p)));
    out + &format!(
        "{name} {version}: {description}\n{provenance}\nhash {}\n{} worlds, {} tasks\n{proof}",
        s.hash, s.world_count, s.task_count
    )
}

/// Free text on one line, without characters that a terminal obeys.
fn plain(text: &str) -> String {
    text.split(char::is_control).map(str::trim).filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

fn table(t: &Table) -> String {
    let head = t.head.iter().map(|h| (*h).to_owned()).collect();
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(t.rows.iter().cloned()).collect();
    format!("{}\n{}\n", t.title, output::columns(&rows))
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn names_of_a_suite_do_not_command_the_terminal() {
        assert_eq!(plain("two\r\n lines \u{1b}[31mred\u{7}"), "two lines [31mred");
    }
}
