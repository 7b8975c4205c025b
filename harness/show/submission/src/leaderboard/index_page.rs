//! The front page: boards with their entries.

use std::fmt::Write as _;

use vb_page::{Page, SORTED_TABLES, TABLE_STYLE, escape, grouped, number};
use vb_record::planner_with_params;
use vb_report::{Estimate, Measure, Split, heat, one_line};
use vb_score::{Cause, Flag, Outcome};

use super::entries::Entry;
use super::rank::{Board, Ranked, RankedBy};
use crate::division::Division;

pub(super) const STYLE: &str = include_str!("site.css");
const SCRIPT: &str = include_str!("site.js");

/// Pixels from one square of a row's strip of worlds to the next.
const SQUARE: usize = 6;

/// What stands behind the figures of a division.
fn about(division: Division) -> &'static str {
    match division {
        Division::Ranked => {
            "WASM planners under the benchmark's default conditions, verified by re-running tasks."
        }
        Division::Onboard => {
            "Default conditions, but with realistic perception: a coarse map without obstacles, a pose that drifts, \
             sensors with typical errors."
        }
        Division::Degraded => {
            "Default conditions, but with degraded perception: no prior map, several times the errors, GNSS \
             outages and dust."
        }
        Division::Open => {
            "Other conditions or kinds of plugin, listed with each entry. Results are verified, but ranks are less comparable."
        }
    }
}

pub(super) fn page(title: &str, boards: &[Board]) -> String {
    let title = one_line(title, 120);
    let count: usize = boards.iter().map(|b| b.entries.len()).sum();
    let noun = if count == 1 { "entry" } else { "entries" };
    let head = format!(
        "<h1>{}</h1><p class=\"meta\">{} {noun}; <a href=\"leaderboard.json\">as JSON</a>; Verti-Bench in Rust {}</p>",
        escape(&title),
        grouped(count as u64),
        env!("CARGO_PKG_VERSION"),
    );
    let mut s = String::new();
    if boards.is_empty() {
        s.push_str("<p>No entries.</p>");
    } else {
        s.push_str(
            "<form class=\"bar\" id=\"filter\" autocomplete=\"off\" hidden><label>suite <select name=\"suite\"></select></label>\
             <label>vehicle <select name=\"vehicle\"></select></label><label>division <select name=\"division\"></select></label>\
             <output></output></form>",
        );
    }
    for b in boards {
        board(&mut s, b);
    }
    s.push_str(
        "<section><h2>Reading the boards</h2><p class=\"about\">Entries are sorted by success rate; intervals are 95 % \
         (bootstrap over worlds, because tasks of a world are dependent). An entry shares the rank of the best entry above \
         it (marked =) if the difference is not significant (sign-flip test over worlds, paired by task). \
         If all entries of a board have scores on the hidden suite, these determine order and ties: an entry shares \
         the rank if the two 95 % intervals overlap. The test would need outcomes of single tasks or worlds, which would reveal the \
         hidden suite; the comparison of intervals is more conservative, so more entries share a rank. \
         A small square is a world, from brown (no task solved) to green (all solved), with low elevation at the top and high elevation at the bottom. \
         Time is the mean traversal time of successes; angles are means over all samples. Results of other suites, vehicles, rules \
         or versions of the harness are on separate boards.</p></section>",
    );
    Page {
        title: &title,
        styles: &[TABLE_STYLE, STYLE],
        body: &format!("<header>{head}</header><main>{s}</main>"),
        script: &format!("{SORTED_TABLES}{SCRIPT}"),
        ..Page::default()
    }
    .html()
}

fn board(s: &mut String, b: &Board) {
    let m = &b.entries[0].entry.manifest;
    let text = |t: &str| escape(&one_line(t, 60));
    let suite = format!("{} {}", text(&m.run.suite.name), text(&m.suite_version));
    let vehicle = text(&m.run.vehicle.name);
    let division = b.division.name();
    let _ = write!(
        s,
        "<section class=\"board\" data-suite=\"{suite}\" data-vehicle=\"{vehicle}\" data-division=\"{division}\"><h2>{suite} \
         <small>{vehicle}</small> <span class=\"tag {division}\">{division}</span></h2><p class=\"sub\">{} {} tasks{}; rules {}; \
         harness {}; {}; suite hash <code title=\"{hash}\">{}</code></p>",
        about(b.division),
        grouped(m.run.tasks),
        m.run
            .selector
            .as_ref()
            .map_or_else(String::new, |t| { format!(" (of {}: {})", grouped(m.run.suite.tasks), text(t)) }),
        text(&m.run.rules.name),
        text(&m.run.harness_version),
        match b.ranked_by {
            RankedBy::Suite => "ranked by this suite",
            RankedBy::Holdout => "ranked by the hidden suite",
        },
        escape(m.run.suite.hash.get(..12).unwrap_or(&m.run.suite.hash)),
        hash = escape(&m.run.suite.hash),
    );
    let holdout = b.entries.iter().any(|r| r.entry.holdout.is_some());
    let _ = write!(
        s,
        "<div class=\"scroll\"><table class=\"sortable standings\"><thead><tr><th class=\"n\">rank</th><th>planner</th><th \
         class=\"n\">success %</th><th class=\"plot fixed\">95 % interval</th>{}<th class=\"n wide\">time s</th><th class=\"n \
         wide\">|roll| °</th><th class=\"n wide\">|pitch| °</th></tr></thead><tbody>",
        if holdout { "<th class=\"n hold\">hold-out %</th>" } else { "" }
    );
    // Scores of several hidden suites say which each is of.
    let suites: std::collections::BTreeSet<_> = b
        .entries
        .iter()
        .filter_map(|r| r.entry.holdout.as_ref())
        .map(|h| (&h.suite, &h.suite_version))
        .collect();
    for r in &b.entries {
        row(s, r, holdout, suites.len() > 1);
    }
    s.push_str("</tbody></table></div></section>");
}

fn row(s: &mut String, r: &Ranked, holdout: bool, several: bool) {
    let e = &r.entry;
    let success = e.figures.mean(Measure::Success);
    let mean = |m: Measure| cell(m, e.figures.mean(m));
    let params = e.manifest.run.params.iter().map(|(k, v)| (one_line(k, 60), one_line(v, 60))).collect();
    let _ = write!(
        s,
        "<tr><td class=\"n rank\" data-v=\"{rank}\">{rank}{}</td><td><a href=\"entries/{id}/index.html\">{}</a> <small>{}</small><br>\
         <small class=\"who\">{}{}</small>{}<small class=\"details\">{}</small></td>{}<td class=\"plot\">{}</td>",
        if r.tied { "<small>=</small>" } else { "" },
        escape(&one_line(&e.manifest.run.plugin.name, 60)),
        escape(&planner_with_params(&one_line(&e.manifest.run.plugin.version, 30), &params)),
        escape(&one_line(&e.manifest.entrant.name, 80)),
        links(e),
        strip(e, SQUARE),
        details(e),
        mean(Measure::Success),
        whisker(success),
        rank = r.rank,
        id = escape(&e.id),
    );
    if holdout {
        let text = e.holdout.as_ref().map_or_else(
            || "–".into(),
            |h| {
                let suite = escape(&one_line(&format!("{} {}", h.suite, h.suite_version), 40));
                let suite = if several { format!("<br><small>{suite}</small>") } else { String::new() };
                format!("{}{suite}", number(h.success_percent, 1))
            },
        );
        let _ = write!(s, "<td class=\"n\">{text}</td>");
    }
    for m in [Measure::Time, Measure::Roll, Measure::Pitch] {
        s.push_str(&mean(m).replacen("class=\"n\"", "class=\"n wide\"", 1));
    }
    s.push_str("</tr>");
}

/// Links to the entrant's source and paper.
fn links(e: &Entry) -> String {
    let all = [("code", &e.manifest.entrant.code), ("paper", &e.manifest.entrant.paper)];
    let link = |(name, url): (&str, &Option<String>)| {
        let url = escape(url.as_ref()?);
        Some(format!(" · <a href=\"{url}\" rel=\"nofollow noopener\">{name}</a>"))
    };
    all.into_iter().filter_map(link).collect()
}

/// What else is known of an entry, in a line below its name. A narrow screen has no room for columns, so means are told here as well.
fn details(e: &Entry) -> String {
    let f = &e.figures;
    let percent = |n: f64| number(100.0 * n, 1);
    let share = |o: Outcome| percent(f.count(o) as f64 / f.tasks.max(1) as f64);
    let mut parts = Vec::new();
    if e.levels.len() > 1 {
        let levels: Vec<String> =
            e.levels.iter().map(|(level, rate)| format!("{level} {}", percent(*rate))).collect();
        parts.push(format!("{} %", levels.join(", ")));
    }
    let narrow: Vec<String> = [Measure::Time, Measure::Roll, Measure::Pitch]
        .into_iter()
        .filter_map(|m| {
            let mean = number(m.shown(f.mean(m)?.mean), 1);
            Some(match m {
                Measure::Time => format!("{mean} s"),
                _ => format!("{} {mean}°", m.name()),
            })
        })
        .collect();
    let flagged = |flag| f.flagged_percent(flag).map(|v| number(v, 1));
    let tilted = flagged(Flag::Tilted).map_or_else(String::new, |v| format!(" (tilt above 30° in {v} %)"));
    parts.push(format!("rollover {} %{tilted}", share(Outcome::Rollover)));
    if let Some(strict) = flagged(Flag::Strict) {
        parts.push(format!("strict success {strict} %"));
    }
    let most = Cause::by_frequency(|cause| f.caused(cause));
    let why = most.first().map_or_else(String::new, |(cause, n)| {
        format!(" (most frequent cause: {}, {} %)", cause.title(), percent(*n as f64 / f.tasks.max(1) as f64))
    });
    parts.push(format!("stuck {} %{why}", share(Outcome::Stuck)));
    let other = f.tasks
        - [Outcome::Success, Outcome::Rollover, Outcome::Stuck].map(|o| f.count(o)).iter().sum::<u64>();
    if other > 0 {
        parts.push(format!("other failures {} %", percent(other as f64 / f.tasks.max(1) as f64)));
    }
    if let Some(fuel) = e.fuel {
        parts.push(format!(
            "maximum fuel per step {} % of the limit",
            number(100.0 * fuel, if fuel < 0.01 { 3 } else { 1 })
        ));
    }
    let sample = e.verification.sample.as_ref();
    let again = sample.map_or(0.0, |s| s.tasks.len() as f64 / s.of.max(1) as f64);
    parts.push(format!("{} % re-run", number(100.0 * again, 0)));
    // A time is told by its day; what is no time is an entrant's own text.
    let day = e.manifest.run.started_at.get(..10).unwrap_or_default();
    if day.bytes().all(|b| b.is_ascii_digit() || b == b'-') && !day.is_empty() {
        parts.push(format!("run on {day}"));
    }
    format!("<span class=\"narrow\">{}; </span>{}", escape(&narrow.join(", ")), escape(&parts.join("; ")))
}

/// A cell with a mean and, below, its interval.
fn cell(measure: Measure, e: Option<Estimate>) -> String {
    let Some(e) = e else { return "<td class=\"n\" data-v=\"\">–</td>".into() };
    let v = |v: f64| number(measure.shown(v), 1);
    let interval = e.interval.map_or_else(String::new, |i| {
        format!("<br><small class=\"interval\">{} to {}</small>", v(i.low), v(i.high))
    });
    format!("<td class=\"n\" data-v=\"{}\">{}{interval}</td>", measure.shown(e.mean), v(e.mean))
}

/// A square a world, `side` pixels apart, in the colour of the share of its tasks that were done; a row an elevation level, the
/// lowest first.
pub(super) fn strip(e: &Entry, side: usize) -> String {
    let rows: Vec<Vec<_>> = Split::Elevation
        .levels()
        .into_iter()
        .map(|level| {
            let mut row: Vec<_> =
                e.worlds.iter().filter(|(w, _)| Split::Elevation.level(w) == level).collect();
            row.sort_by_key(|(w, _)| (w.terrain, w.density, &w.name));
            row
        })
        .filter(|row| !row.is_empty())
        .collect();
    let longest = rows.iter().map(Vec::len).max().unwrap_or(0);
    let mut s = format!(
        "<svg class=\"strip\" viewBox=\"0 0 {w} {h}\" style=\"width:{w}px\" role=\"img\" aria-label=\"{} of {} worlds with all tasks solved\">",
        e.worlds.iter().filter(|(_, (done, all))| done == all).count(),
        e.worlds.len(),
        w = longest * side,
        h = rows.len() * side,
    );
    for (y, row) in rows.iter().enumerate() {
        for (x, (w, done)) in row.iter().enumerate() {
            let _ = write!(
                s,
                "<rect class=\"q{}\" x=\"{}\" y=\"{}\" width=\"{d}\" height=\"{d}\"><title>{}, {} elevation, {} terrain, {} obstacles: {} of {} \
                 tasks</title></rect>",
                heat(*done),
                x * side,
                y * side,
                escape(&one_line(&w.name, 60)),
                w.elevation.name(),
                w.terrain.name(),
                w.density.name(),
                done.0,
                done.1,
                d = side - 1,
            );
        }
    }
    s.push_str("</svg>");
    s
}

/// A rate and its interval on a line from 0 to 100 %.
pub(super) fn whisker(e: Option<Estimate>) -> String {
    let Some(e) = e else { return String::new() };
    let x = |v: f64| number((v * 200.0).clamp(0.0, 200.0), 1);
    let (low, high) = e.interval.map_or((e.mean, e.mean), |i| (i.low, i.high));
    format!(
        "<svg viewBox=\"-4 0 208 16\" role=\"img\" aria-label=\"{}\"><path class=\"grid\" d=\"M0 3V13M50 3V13M100 3V13M150 3V13M200 3V13\"/>\
         <path class=\"base\" d=\"M0 8H200\"/><path class=\"range s0\" d=\"M{} 8H{}\"/><circle class=\"dot f0\" cx=\"{}\" cy=\"8\" \
         r=\"4.5\"/></svg>",
        e.interval.map_or_else(
            || "no interval (single world)".to_owned(),
            |i| format!("{} to {} %", number(100.0 * i.low, 1), number(100.0 * i.high, 1))
        ),
        x(low),
        x(high),
        x(e.mean)
    )
}
