//! The page in three dimensions.

use serde::Serialize;
use serde_json::json;
use vb_page::Page;
use vb_world::TaskId;

use crate::Replay;

/// The script of both pages: three.js and what lies in `web/src`, made by `web/build.mjs`.
const SCRIPT: &str = include_str!("../assets/replay.min.js");
const STYLE: &str = include_str!("../web/src/replay.css");
const BODY: &str = include_str!("../web/src/body.html");

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Link {
    /// What it is called, e.g. the name of a task.
    pub name: String,
    /// Where it lies, relative to the page.
    pub href: String,
}

/// Where a page leads to; nowhere by default.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Links {
    /// The page that lists this one.
    pub report: Option<Link>,
    pub previous: Option<Link>,
    pub next: Option<Link>,
}

impl Links {
    /// The links of each of a report's replays, which lie at `replays/WORLD/TASK.html` beside it. `report` is the name of the
    /// report's file; `tasks` are the tasks that have a replay, in their order.
    #[must_use]
    pub fn of_report(report: &str, tasks: &[TaskId]) -> Vec<Self> {
        let link = |task: &TaskId| Link { name: task.to_string(), href: format!("../{task}.html") };
        let links = tasks.iter().enumerate().map(|(k, task)| Self {
            report: Some(Link { name: "report".into(), href: format!("../../{report}#task={task}") }),
            previous: k.checked_sub(1).and_then(|k| tasks.get(k)).map(link),
            next: tasks.get(k + 1).map(link),
        });
        links.collect()
    }
}

/// The script of all replays, for a file that lies beside pages.
#[must_use]
pub fn script() -> &'static str {
    SCRIPT
}

pub const SCRIPT_FILE: &str = "replay.js";

/// What a page shows whose script isn't where it should be; the script takes it away.
const ALONE: &str = "<p id=\"alone\">This replay needs the file replay.js from its folder, which is missing. Copy the \
                     whole folder, or create a replay in one file: vb-harness replay RUN --task TASK --out FILE.</p>";

/// The page. It needs no network. Texts of planners are data for its script, which sets them as text; no other script is run. `links`
/// lead to other pages. `script_at` is the address of a file with [`script`], relative to the page; without it the page is one file
/// that needs nothing else.
#[must_use]
pub fn page(replay: &Replay, links: &Links, script_at: Option<&str>) -> String {
    let mut data = replay.json();
    data["links"] = json!(links);
    Page {
        title: &format!("{} on {}", replay.id(), replay.suite),
        styles: &[STYLE],
        body: &match script_at {
            Some(_) => format!("{ALONE}{BODY}"),
            None => BODY.to_owned(),
        },
        data: Some(&data),
        script: SCRIPT,
        script_at,
        makes_images: true,
        ..Page::default()
    }
    .html()
}

const LIVE_STYLE: &str = include_str!("../web/src/teleop.css");
const LIVE_BODY: &str = include_str!("../web/src/teleop.html");

/// The page in which a person drives. It speaks with the server that it comes from, and with nobody else; `data` is there from
/// the start, scenes ([`crate::live_scene`]) come later.
#[must_use]
pub fn live_page(title: &str, data: &serde_json::Value) -> String {
    Page {
        title,
        styles: &[STYLE, LIVE_STYLE],
        body: LIVE_BODY,
        data: Some(data),
        script: SCRIPT,
        makes_images: true,
        connects: true,
        ..Page::default()
    }
    .html()
}
