//! The page in three dimensions.

use vb_page::Page;

use crate::Replay;

/// The page's script: three.js and what lies in `web/src`, made by `web/build.mjs`.
const SCRIPT: &str = include_str!("../assets/replay.min.js");
const STYLE: &str = include_str!("../web/src/replay.css");
const BODY: &str = include_str!("../web/src/body.html");

/// The page: one file that needs nothing else, no network either. Texts of planners are data for its script, which sets
/// them as text; no other script is run.
#[must_use]
pub fn page(replay: &Replay) -> String {
    Page {
        title: &format!("{}/{} on {}", replay.world.id, replay.task.id, replay.suite),
        styles: &[STYLE],
        body: BODY,
        data: Some(&replay.json()),
        script: SCRIPT,
        makes_images: true,
        ..Page::default()
    }
    .html()
}

/// The script of the page in which a person drives, made as the other.
const LIVE_SCRIPT: &str = include_str!("../assets/teleop.min.js");
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
        script: LIVE_SCRIPT,
        makes_images: true,
        connects: true,
        ..Page::default()
    }
    .html()
}
