//! The page.

use super::Report;
use super::svg::plot;
use super::text::expected;
use crate::check::{Check, Expected, Kind, Verdict};
use crate::event::Figure;
use crate::result::EventResult;
use std::fmt::Write as _;
use vb_page::{Page, escape, rounded};

const STYLE: &str = include_str!("page.css");

/// How far the figure is from the reference, %, where there is a value to compare with.
fn deviation(c: &Check) -> String {
    match (c.expectation.expected, c.measured) {
        (Expected::Within { value, .. }, Some(m)) if value.abs() > 1e-9 => {
            let percent = format!("{:+.1} %", 100.0 * (m / value - 1.0));
            percent.replace('-', "−")
        }
        _ => String::new(),
    }
}

fn chip(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "<span class=\"chip pass\">pass</span>",
        Verdict::Fail => "<span class=\"chip fail\">fail</span>",
        Verdict::Shown => "<span class=\"chip shown\">no verdict</span>",
    }
}

pub(super) fn page(report: &Report) -> String {
    let v = &report.vehicle;
    let name = escape(&v.name);
    let mut s = String::new();
    let _ = write!(s, "<header><h1>Vehicle test: {name}</h1><p>{}</p>", escape(&v.description));
    let _ = write!(
        s,
        "<p class=\"meta\">Verti-Bench in Rust {}, step {} ms, {} events</p></header>",
        env!("CARGO_PKG_VERSION"),
        1e3 * report.step,
        report.results.len()
    );
    s.push_str("<div class=\"frame\">");
    navigation(&mut s, report);
    s.push_str("<main>");
    summary(&mut s, report);
    for r in &report.results {
        section(&mut s, r);
    }
    s.push_str("</main></div>");
    Page { title: &format!("Vehicle test: {}", v.name), styles: &[STYLE], body: &s, ..Page::default() }.html()
}

fn summary(s: &mut String, report: &Report) {
    let all = report.counts(None);
    let class = if report.passed() { "pass" } else { "fail" };
    let _ = write!(
        s,
        "<section class=\"summary\"><p class=\"verdict {class}\"><b>{}</b> of {} checks pass</p><table><thead><tr><th>reference</th>\
         <th class=\"n\">pass</th><th class=\"n\">fail</th><th class=\"n\">no verdict</th></tr></thead><tbody>",
        all.passed,
        all.passed + all.failed
    );
    let kinds = [
        (Kind::Theory, "theory, with the vehicle's data"),
        (Kind::Published, "published values of the vehicle"),
        (Kind::Chrono, "Project Chrono"),
        (Kind::Convergence, "convergence: half the time step"),
    ];
    for (kind, label) in kinds {
        let c = report.counts(Some(kind));
        if c != crate::Counts::default() {
            let _ = write!(
                s,
                "<tr><td>{label}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
                c.passed, c.failed, c.shown
            );
        }
    }
    s.push_str("</tbody></table>");
    s.push_str(
        "<p>Unsound references are shown without a verdict, with the reason; theory provides the verdict \
         instead.</p>",
    );
    for (kind, about) in &report.setups {
        let _ = write!(
            s,
            "<p><b>In {}</b>: measurements compared with it, and the curves drawn with it, use the vehicle in the \
             configuration of its runs. All other measurements use the vehicle unchanged. {}.</p>",
            kind.setup(),
            escape(about.trim_end_matches('.'))
        );
    }
    failures(s, report);
    s.push_str("</section>");
}

/// The events with what came of them; it stays in sight.
fn navigation(s: &mut String, report: &Report) {
    s.push_str("<nav aria-label=\"events\"><ol>");
    for r in &report.results {
        let failed = r.checks.iter().filter(|c| c.verdict == Verdict::Fail).count();
        let class = if r.passed() { "pass" } else { "fail" };
        let text = match (r.broken().next().is_some(), failed) {
            (true, _) => "simulation failed".to_owned(),
            (false, 0) if r.checks.is_empty() => String::new(),
            (false, 0) => format!("{} pass", r.checks.iter().filter(|c| c.verdict == Verdict::Pass).count()),
            (false, n) => format!("{n} fail"),
        };
        let _ = write!(
            s,
            "<li><a href=\"#{}\">{}</a> <span class=\"{class}\">{text}</span></li>",
            r.event.name,
            escape(r.event.title)
        );
    }
    s.push_str("</ol></nav>");
}

/// What a reader wants to know first.
fn failures(s: &mut String, report: &Report) {
    if report.passed() {
        return;
    }
    s.push_str("<h3>Failures</h3><div class=\"scroll\"><table class=\"checks\"><tbody>");
    for r in &report.results {
        let link = format!("<a href=\"#{}\">{}</a>", r.event.name, escape(r.event.title));
        for failure in r.broken() {
            let _ = write!(s, "<tr><td>{link}</td><td colspan=\"6\">{}</td></tr>", escape(&failure));
        }
        for c in r.checks.iter().filter(|c| c.verdict == Verdict::Fail) {
            let _ = write!(
                s,
                "<tr><td>{link}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"u\">{}</td>\
                 <td class=\"n\">{}</td><td class=\"source\"><b>{}</b></td></tr>",
                escape(&c.expectation.figure),
                c.measured.map_or_else(|| "not reached".to_owned(), rounded),
                expected(c.expectation.expected),
                c.unit,
                deviation(c),
                c.against(),
            );
        }
    }
    s.push_str("</tbody></table></div>");
}

fn section(s: &mut String, r: &EventResult) {
    let _ = write!(
        s,
        "<section id=\"{}\"><h2>{}</h2><p class=\"about\">{}</p>",
        r.event.name,
        escape(r.event.title),
        escape(r.event.about)
    );
    for failure in r.broken() {
        let _ = write!(s, "<p class=\"failure\">The simulation failed: {}</p>", escape(&failure));
    }
    for note in &r.outcome.notes {
        let _ = write!(s, "<p class=\"note\">{}</p>", escape(note));
    }
    if !r.outcome.plots.is_empty() {
        s.push_str("<div class=\"plots\">");
        for p in &r.outcome.plots {
            s.push_str(&plot(p));
        }
        s.push_str("</div>");
    }
    checks(s, r);
    rest(s, r, None, &r.outcome.figures);
    for driven in &r.setups {
        rest(s, r, Some(driven.kind), &driven.outcome.figures);
    }
    s.push_str("</section>");
}

/// Figures, of the vehicle as it is or in a set-up, that are held against nothing.
fn rest(s: &mut String, r: &EventResult, setup: Option<Kind>, figures: &[Figure]) {
    let judged = |name: &str| r.checks.iter().any(|c| c.setup == setup && c.expectation.figure == name);
    let rest: Vec<_> = figures.iter().filter(|f| !judged(&f.name)).collect();
    if rest.is_empty() {
        return;
    }
    let within = setup.map_or_else(String::new, |kind| format!(" in {}", kind.setup()));
    let _ = write!(
        s,
        "<details><summary>Measurements{within} without a reference</summary><table class=\"figures\"><tbody>"
    );
    for f in rest {
        let value = if f.value.is_finite() { rounded(f.value) } else { "not reached".to_owned() };
        let _ = write!(
            s,
            "<tr><td>{}</td><td class=\"n\">{value}</td><td class=\"u\">{}</td></tr>",
            escape(&f.name),
            f.unit
        );
    }
    s.push_str("</tbody></table></details>");
}

fn checks(s: &mut String, r: &EventResult) {
    if r.checks.is_empty() {
        return;
    }
    s.push_str(
        "<div class=\"scroll\"><table class=\"checks\"><thead><tr><th>measurement</th><th class=\"n\">measured</th><th class=\"n\">expected</th><th>unit</th>\
         <th class=\"n\">deviation</th><th></th><th>reference</th></tr></thead><tbody>",
    );
    for c in &r.checks {
        let measured = c.measured.map_or_else(|| "not reached".to_owned(), rounded);
        let why = c.expectation.unsound.as_ref().map_or_else(String::new, |u| {
            format!("<br><span class=\"unsound\">no verdict: {}</span>", escape(u))
        });
        let tag = c
            .setup
            .map_or_else(String::new, |kind| format!("<br><span class=\"tag\">in {}</span>", kind.setup()));
        let _ = write!(
            s,
            "<tr class=\"{}\"><td>{}{tag}</td><td class=\"n\">{measured}</td><td class=\"n\">{}</td><td class=\"u\">{}</td>\
             <td class=\"n\">{}</td><td>{}</td><td class=\"source\"><b>{}</b> {}{why}</td></tr>",
            if c.verdict == Verdict::Fail { "failed" } else { "" },
            escape(&c.expectation.figure),
            expected(c.expectation.expected),
            c.unit,
            deviation(c),
            chip(c.verdict),
            c.expectation.kind.name(),
            escape(&c.expectation.source),
        );
        if c.verdict == Verdict::Fail {
            let _ =
                write!(s, "<tr class=\"failed why\"><td colspan=\"7\">{}</td></tr>", escape(&explanation(c)));
        }
    }
    s.push_str("</tbody></table></div>");
}

/// Why a check fails, and what that may mean.
fn explanation(c: &Check) -> String {
    let Some(measured) = c.measured else {
        return "The event has no such measurement, because the vehicle did not get that far (see the time series)."
            .to_owned();
    };
    let unit = if c.unit.is_empty() { String::new() } else { format!(" {}", c.unit) };
    let below = |low: f64| format!("{}{unit} below the minimum", rounded(low - measured));
    let above = |high: f64| format!("{}{unit} above the maximum", rounded(measured - high));
    let off = match c.expectation.expected {
        Expected::Within { value, tolerance } => {
            let off = (measured - value).abs();
            let side = if measured > value { "more" } else { "less" };
            format!(
                "{}{unit} {side} than expected, which is {} times the tolerance of {}{unit}",
                rounded(off),
                rounded(off / tolerance.max(f64::MIN_POSITIVE)),
                rounded(tolerance)
            )
        }
        Expected::AtLeast(low) => below(low),
        Expected::Between(low, _) if measured < low => below(low),
        Expected::AtMost(high) | Expected::Between(_, high) => above(high),
    };
    let meaning = match c.expectation.kind {
        Kind::Theory => {
            "The expected value follows from the vehicle file, so either values of the file contradict each other, or the formula \
             omits an effect of this vehicle."
        }
        Kind::Published => {
            "The expected value is from the real vehicle, so mass, tyres, gearing or engine of the file may differ from it."
        }
        Kind::Chrono => {
            "Project Chrono models the same vehicle with other tyres and another driveline; docs/validation.md documents its own \
             variation."
        }
        Kind::Convergence => {
            "The result depends on the time step: use a smaller --time-step for this vehicle."
        }
    };
    format!("The measurement is {off}. {meaning}")
}
