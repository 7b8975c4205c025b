//! The page in three dimensions.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest as _, Sha256};

use crate::Replay;

/// The page's script: three.js and what lies in `web/src`, made by `web/build.mjs`.
const SCRIPT: &str = include_str!("../assets/replay.min.js");
const STYLE: &str = include_str!("../web/src/replay.css");
const BODY: &str = include_str!("../web/src/body.html");

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// The page: one file that needs nothing else, no network either. Texts of planners are data for its script, which sets
/// them as text; no other script is run.
#[must_use]
pub fn page(replay: &Replay) -> String {
    let own = STANDARD.encode(Sha256::digest(SCRIPT.as_bytes()));
    // No tag can begin or end in the data.
    let data = replay.json().to_string().replace('<', "\\u003c");
    let title = escape(&format!("{}/{} on {}", replay.world.id, replay.task.id, replay.suite));
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         img-src data: blob:; style-src 'unsafe-inline'; script-src 'sha256-{own}'\"><title>{title}</title><style>{STYLE}</style></head>\
         <body>{BODY}<script type=\"application/json\" id=\"data\">{data}</script><script>{SCRIPT}</script></body></html>\n"
    )
}
