//! The page of an entry.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use vb_page::{Page, TABLE_STYLE, escape, grouped, number};
use vb_report::{Measure, THUMBNAIL_STYLE, one_line};
use vb_score::{Cause, Flag, Outcome};
use vb_world::TaskId;

use super::index_page::{STYLE, strip, whisker};
use super::rank::{Board, Ranked};
use super::worlds::Maps;

pub(super) fn page(
    title: &str,
    board: &Board,
    r: &Ranked,
    replays: &BTreeSet<TaskId>,
    maps: &Maps,
) -> String {
    let (e, m) = (&r.entry, &r.entry.manifest);
    let text = |t: &str, most| escape(&one_line(t, most));
    let name = text(&m.run.plugin.name, 60);
    let who = text(&m.entrant.name, 80);
    let who = match &m.entrant.url {
        Some(url) => format!("<a href=\"{}\" rel=\"nofollow noopener\">{who}</a>", escape(url)),
        None => who,
    };
    let division = board.division.name();
    let mut head = format!(
        "<h1>{name} <small>{}</small> <span class=\"tag {division}\">{division}</span></h1><p class=\"meta\">{who}</p><nav><a \
         href=\"../../index.html\">{}</a><a href=\"report.html\">Report</a>",
        text(&m.run.plugin.version, 30),
        text(title, 60),
    );
    head.push_str("<a href=\"#worlds\">Worlds</a>");
    if !replays.is_empty() {
        head.push_str("<a href=\"#replays\">Replays</a>");
    }
    head.push_str("<a href=\"#conditions\">Conditions</a><a href=\"#verification\">Verification</a></nav>");

    let mut s = String::new();
    if let Some(note) = &m.entrant.note {
        let _ = write!(s, "<p class=\"note\">{}</p>", text(note, 500));
    }
    results(&mut s, board, r);
    worlds(&mut s, r, maps);
    if !replays.is_empty() {
        s.push_str("<section id=\"replays\"><h2>Replays</h2><ul class=\"replays\">");
        for task in replays {
            let _ = write!(s, "<li><a href=\"replays/{0}.html\">{0}</a></li>", escape(task.as_str()));
        }
        s.push_str(
            "</ul><p class=\"about\">Tasks in 3D, re-simulated from the recorded commands.</p></section>",
        );
    }
    conditions(&mut s, r);
    verification(&mut s, r);
    let page_title = format!("{} – {}", one_line(&e.manifest.run.plugin.name, 60), one_line(title, 60));
    Page {
        title: &page_title,
        styles: &[TABLE_STYLE, THUMBNAIL_STYLE, STYLE],
        body: &format!("<header>{head}</header><main>{s}</main>"),
        images_beside: true,
        ..Page::default()
    }
    .html()
}

fn results(s: &mut String, board: &Board, r: &Ranked) {
    let e = &r.entry;
    let success = e.figures.mean(Measure::Success);
    let _ = write!(
        s,
        "<section id=\"results\"><div class=\"cards\"><article class=\"card\"><h3>Success</h3><p class=\"big\">{}<small> %</small></p>{}<p \
         class=\"sub\">{} of {} tasks in {} worlds{}</p></article><article class=\"card\"><h3>Rank</h3><p class=\"big\">{}{}<small> of \
         {}</small></p><p class=\"sub\">{}</p></article>",
        success.map_or_else(|| "–".into(), |e| number(100.0 * e.mean, 1)),
        whisker(success),
        grouped(e.figures.count(Outcome::Success)),
        grouped(e.figures.tasks),
        e.figures.worlds,
        success.and_then(|e| e.interval).map_or_else(String::new, |i| format!(
            "; 95 %: {} to {} %",
            number(100.0 * i.low, 1),
            number(100.0 * i.high, 1)
        )),
        r.rank,
        if r.tied { "=" } else { "" },
        board.entries.len(),
        match (r.tied, board.entries.len()) {
            (true, _) => "shared: the differences are not significant",
            (false, 1) => "the only entry",
            (false, _) => "significantly different from the others",
        },
    );
    if let Some(h) = &e.holdout {
        let _ = write!(
            s,
            "<article class=\"card\"><h3>Hold-out</h3><p class=\"big\">{}<small> %</small></p><p class=\"sub\">of {} hidden tasks \
             ({}){}</p></article>",
            number(h.success_percent, 1),
            grouped(h.tasks),
            escape(&one_line(&h.suite, 60)),
            h.success_interval_percent.map_or_else(String::new, |[low, high]| format!(
                "; 95 %: {} to {} %",
                number(low, 1),
                number(high, 1)
            ))
        );
    }
    s.push_str("</div><dl class=\"figures\">");
    for m in [Measure::Time, Measure::Roll, Measure::Pitch] {
        let value = e.figures.mean(m).map_or_else(
            || "–".into(),
            |e| {
                let v = |v: f64| number(m.shown(v), 1);
                let interval = e
                    .interval
                    .map_or_else(String::new, |i| format!(" <small>[{}, {}]</small>", v(i.low), v(i.high)));
                format!("{}{interval}", v(e.mean))
            },
        );
        let _ = write!(s, "<div><dt>{}, {}</dt><dd>{value}</dd></div>", m.name(), m.unit());
    }
    for outcome in Outcome::ALL.iter().filter(|o| e.figures.count(**o) > 0) {
        let name = outcome.name().replace('_', " ");
        let _ = write!(s, "<div><dt>{name}</dt><dd>{}</dd></div>", grouped(e.figures.count(*outcome)));
    }
    for flag in Flag::ALL {
        if let Some(n) = e.figures.flagged(flag) {
            let (title, about) = (escape(flag.title()), escape(flag.about()));
            let _ = write!(s, "<div><dt title=\"{about}\">{title}</dt><dd>{}</dd></div>", grouped(n));
        }
    }
    s.push_str("</dl>");
    let causes = Cause::by_frequency(|cause| e.figures.caused(cause));
    if !causes.is_empty() {
        s.push_str("<h3>Causes of failures</h3><dl class=\"figures\">");
        for (cause, n) in causes {
            let _ = write!(s, "<div><dt>{}</dt><dd>{}</dd></div>", escape(cause.title()), grouped(n));
        }
        s.push_str("</dl>");
    }
    s.push_str("</section>");
}

/// The worlds as small maps, or why there are none.
fn worlds(s: &mut String, r: &Ranked, maps: &Maps) {
    let _ = write!(s, "<section id=\"worlds\"><h2>Worlds</h2>{}", strip(&r.entry, 12));
    s.push_str(
        "<p class=\"about\">One square per world, coloured by the fraction of solved tasks, from none (brown) to all (green); one \
         row per elevation level, lowest first.</p>",
    );
    match maps {
        Maps::Made(made) => {
            s.push_str("<ul class=\"maps\">");
            for m in made {
                let _ = write!(
                    s,
                    "<li><a href=\"maps/{0}.html\">{1}<span>{0} <small>{2}/{3}</small></span></a></li>",
                    escape(&m.world),
                    m.thumbnail,
                    m.done.0,
                    m.done.1
                );
            }
            s.push_str("</ul><p class=\"key outcomes\">");
            for (k, outcome) in Outcome::ALL.iter().enumerate().filter(|(_, o)| r.entry.figures.count(**o) > 0) {
                let _ = write!(s, "<span><i class=\"swatch o{k}\"></i>{}</span>", outcome.name().replace('_', " "));
            }
            s.push_str(
                "</p><p class=\"about\">Click a world for its map with the tasks' trajectories. A dot marks the end of a task; a ring at \
                 the goal marks the outcome of a task without a trace in the submission.</p>",
            );
        }
        Maps::Hidden => s.push_str(
            "<p class=\"about\">Maps and replays are not available, because the suite is hidden.</p>",
        ),
        Maps::Missing => s.push_str(
            "<p class=\"about\">Maps are not available, because the worlds of this suite were missing when the HTML report was created.</p>",
        ),
    }
    s.push_str("</section>");
}

fn conditions(s: &mut String, r: &Ranked) {
    let m = &r.entry.manifest;
    let text = |t: &str| escape(&one_line(t, 160));
    let data = |name: &str, hash: &str| format!("{} <code>{}</code>", text(name), text(hash));
    s.push_str("<section id=\"conditions\"><h2>Conditions</h2>");
    if !m.open_because.is_empty() {
        s.push_str("<p>In the open division, because:</p><ul class=\"notes\">");
        for reason in &m.open_because {
            let _ = write!(s, "<li>{}: {}</li>", text(&reason.field), text(&reason.text));
        }
        s.push_str("</ul>");
    }
    let params: Vec<String> = m.run.params.iter().map(|(k, v)| format!("{k}={v}")).collect();
    let rows = [
        ("plugin", data(&format!("{}, interface {}", m.run.plugin.kind, m.abi), &m.run.plugin.sha256)),
        ("parameters", if params.is_empty() { "none".into() } else { text(&params.join(" ")) }),
        ("suite", data(&format!("{} {}", m.run.suite.name, m.suite_version), &m.run.suite.hash)),
        ("tasks", text(&m.run.scope())),
        ("vehicle", data(&m.run.vehicle.name, &m.run.vehicle.hash)),
        ("soils", data(&m.run.soils.name, &m.run.soils.hash)),
        ("rules", data(&m.run.rules.name, &m.run.rules.hash)),
        ("scale, seed", format!("{}, {}", m.run.scale, m.run.seed)),
        ("harness", text(&format!("{}, commit {}", m.run.harness_version, m.run.harness_commit))),
    ];
    s.push_str("<div class=\"scroll\"><table class=\"facts\"><tbody>");
    for (name, value) in rows {
        let _ = write!(s, "<tr><th>{name}</th><td>{value}</td></tr>");
    }
    s.push_str("</tbody></table></div></section>");
}

fn verification(s: &mut String, r: &Ranked) {
    let v = &r.entry.verification;
    let driven = match &v.sample {
        Some(sample) if sample.tasks.len() as u64 == sample.of => format!("all {} tasks", grouped(sample.of)),
        Some(sample) => format!(
            "{} of {} tasks{}",
            grouped(sample.tasks.len() as u64),
            grouped(sample.of),
            sample.seed.map_or_else(String::new, |seed| format!(", sampled with seed {seed}"))
        ),
        None => "no tasks".into(),
    };
    let _ = write!(
        s,
        "<section id=\"verification\"><h2>Verification</h2><p>Harness {} re-ran {driven} with this plugin and reproduced the \
         trajectories bit for bit. Further checks: {}.</p><p class=\"about\"><a href=\"submission.json\">submission.json</a> \
         (SHA-256 <code>{}</code>), <a href=\"verification.json\">verification.json</a></p></section>",
        escape(&one_line(&v.harness_version, 30)),
        v.checks.iter().map(|c| c.name()).collect::<Vec<_>>().join(", "),
        escape(&one_line(&v.submission_sha256, 64)),
    );
}
