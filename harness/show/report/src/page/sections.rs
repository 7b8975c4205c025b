//! The sections of the page but figure, comparison and tasks.

use crate::drawing::series::{self, sample};
use crate::drawing::{PAGE_FIGURE, Quantity, Scale, distribution};
use crate::figures::{Estimate, Measure, heat};
use crate::runs::Run;
use crate::{Beside, Report};
use std::fmt::Write as _;
use vb_page::{escape, grouped, number};
use vb_score::{Extent, Flag, FuelUse, Outcome, Ride};
use vb_world::{Density, Elevation, Terrain};

/// Worlds beyond this number are not drawn one by one.
const WORLDS: usize = 3000;

/// Notes about incomplete and incomparable results.
pub(super) fn notes(s: &mut String, report: &Report) {
    let mut notes = Vec::new();
    for run in &report.runs.runs {
        let name = escape(&run.label);
        if run.missing() > 0 {
            notes.push(format!(
                "{name}: {} of {} tasks are pending; the results cover the others.",
                grouped(run.missing()),
                grouped(run.header.tasks)
            ));
        }
        if run.host_errors() > 0 {
            notes.push(format!(
                "{name}: {} tasks failed because of the harness or the machine, and are excluded (run --resume re-runs them).",
                run.host_errors()
            ));
        }
        let failed = run.rows.iter().filter(|r| r.outcome == Outcome::SimError).count();
        if failed > 0 {
            notes.push(format!("{name}: the simulation of {failed} tasks failed; they count as failures."));
        }
        if !run.header.plugin.eligible_for_ranking {
            notes.push(format!("{name}: a command; results of commands are not ranked."));
        }
    }
    notes.extend(report.settings_notes().iter().map(|note| escape(note)));
    for (what, values) in report.runs.differences() {
        let values: Vec<String> = values.iter().map(|v| escape(&crate::runs::one_line(v, 120))).collect();
        notes.push(format!("The runs differ in {what}: {}.", values.join("; ")));
    }
    let sets: Vec<usize> = report.runs.runs.iter().map(|r| r.rows.len()).collect();
    if let Some(c) = &report.comparison
        && let Some(pair) = c.pairs.iter().find(|p| p.common < sets[p.a].max(sets[p.b]) as u64)
    {
        notes.push(format!(
            "The runs contain different tasks ({} are common to {} and {}): overview and figures use all tasks of each run, \
             comparisons the common tasks.",
            grouped(pair.common),
            escape(&report.runs.runs[pair.a].label),
            escape(&report.runs.runs[pair.b].label)
        ));
    }
    if !notes.is_empty() {
        let _ = write!(s, "<ul class=\"notes\"><li>{}</li></ul>", notes.join("</li><li>"));
    }
}

/// The runs' names with how they look.
pub(super) fn legend(s: &mut String, report: &Report) {
    if report.runs.runs.len() > 1 {
        series::legend(s, report.runs.runs.iter().map(|run| run.label.as_str()));
    }
}

/// A mean with its interval: `25.1 [24.0, 26.3]`.
pub(crate) fn with_interval(e: Option<Estimate>, measure: Measure) -> String {
    let Some(e) = e else { return "–".into() };
    let v = |v: f64| number(measure.shown(v), 1);
    match e.interval {
        Some(i) => format!("{} <small>[{}, {}]</small>", v(e.mean), v(i.low), v(i.high)),
        None => v(e.mean),
    }
}

pub(super) fn overview(s: &mut String, report: &Report) {
    let many = report.runs.runs.len() > 1;
    s.push_str("<div class=\"cards\">");
    for (k, (run, f)) in report.runs.runs.iter().zip(&report.figures).enumerate() {
        let h = &run.header;
        let rate = f.all.mean(Measure::Success);
        let _ = write!(
            s,
            "<article class=\"card\"><h3>{}{}</h3><p class=\"big\">{}<small> %</small></p><p class=\"sub\">{} of {} \
             tasks succeed{}</p>",
            if many { sample(k) } else { String::new() },
            escape(&run.label),
            rate.map_or_else(|| "–".into(), |e| number(100.0 * e.mean, 1)),
            grouped(f.all.count(Outcome::Success)),
            grouped(f.all.tasks),
            rate.and_then(|e| e.interval).map_or_else(String::new, |i| format!(
                "; 95 %: {} to {} %",
                number(100.0 * i.low, 1),
                number(100.0 * i.high, 1)
            )),
        );
        stack(s, f.all.outcomes, f.all.tasks);
        s.push_str("<dl>");
        for measure in [Measure::Time, Measure::Roll, Measure::Pitch] {
            let _ = write!(
                s,
                "<div><dt>{}, {}</dt><dd>{}</dd></div>",
                measure.name(),
                measure.unit(),
                with_interval(f.all.mean(measure), measure)
            );
        }
        let _ = write!(
            s,
            "</dl><p class=\"sub\">{}, {}; {}; vehicle {}, rules {}{}</p></article>",
            escape(&crate::runs::one_line(&h.planner(), 240)),
            h.plugin.kind,
            escape(&crate::runs::one_line(&h.scope(), 240)),
            escape(&h.vehicle.name),
            escape(&h.rules.name),
            if h.scale == 1.0 { String::new() } else { format!(", scale {}", number(h.scale, 3)) },
        );
    }
    s.push_str("</div>");
}

/// Shares of the outcomes as a bar.
fn stack(s: &mut String, outcomes: [u64; Outcome::ALL.len()], tasks: u64) {
    s.push_str("<div class=\"stack\">");
    for (k, n) in outcomes.iter().enumerate().filter(|(_, n)| **n > 0) {
        let _ = write!(
            s,
            "<i class=\"o{k}\" style=\"flex:{n}\" title=\"{}: {n} ({} %)\"></i>",
            label(Outcome::ALL[k]),
            number(100.0 * *n as f64 / tasks as f64, 1)
        );
    }
    s.push_str("</div>");
}

/// The name of an outcome for people.
pub(super) fn label(outcome: Outcome) -> String {
    outcome.name().replace('_', " ")
}

pub(super) fn outcomes(s: &mut String, report: &Report) {
    let used: Vec<usize> = (0..Outcome::ALL.len())
        .filter(|k| *k < 3 || report.figures.iter().any(|f| f.all.outcomes[*k] > 0))
        .collect();
    s.push_str(
        "<div class=\"scroll\"><table class=\"sortable\"><thead><tr><th>run</th><th class=\"n\">tasks</th>",
    );
    for &k in &used {
        let _ = write!(s, "<th class=\"n\"><i class=\"swatch o{k}\"></i>{}</th>", label(Outcome::ALL[k]));
    }
    let told: Vec<Flag> = Flag::ALL
        .into_iter()
        .filter(|flag| report.figures.iter().any(|f| f.all.flagged(*flag).is_some()))
        .collect();
    for flag in &told {
        let _ = write!(s, "<th class=\"n\" title=\"{}\">{}</th>", escape(flag.about()), escape(flag.title()));
    }
    s.push_str("<th class=\"n\">success % (95 %)</th></tr></thead><tbody>");
    for (run, f) in report.runs.runs.iter().zip(&report.figures) {
        let _ = write!(s, "<tr><th>{}</th><td class=\"n\">{}</td>", escape(&run.label), grouped(f.all.tasks));
        for &k in &used {
            let n = f.all.outcomes[k];
            let fraction = 100.0 * n as f64 / f.all.tasks.max(1) as f64;
            let _ = write!(
                s,
                "<td class=\"n\" data-v=\"{n}\">{} <small>{} %</small></td>",
                grouped(n),
                number(fraction, 1)
            );
        }
        for flag in &told {
            let cell = f.all.flagged(*flag).zip(f.all.flagged_percent(*flag)).map_or_else(
                || "<td class=\"n\" data-v=\"-1\">–</td>".to_owned(),
                |(n, percent)| {
                    let (n, percent) = (grouped(n), number(percent, 1));
                    format!("<td class=\"n\">{n} <small>{percent} %</small></td>")
                },
            );
            s.push_str(&cell);
        }
        let rate = f.all.mean(Measure::Success);
        let _ = write!(
            s,
            "<td class=\"n\" data-v=\"{}\">{}</td></tr>",
            rate.map_or(0.0, |e| e.mean),
            with_interval(rate, Measure::Success)
        );
    }
    s.push_str(
        "</tbody></table></div><p class=\"about\">Errors of planner and simulation count as failures. The columns after the outcomes count \
         tasks of any outcome and do not affect ranks: a tilt above 30° is the rollover rule of the authors' evaluation scripts; a strict \
         success also ends upright on loaded wheels, without a shock above 2.5 g.</p>",
    );
    ride(s, report);
}

/// The head of a measure's column: its name with its unit behind a comma.
fn heading(name: &str) -> String {
    let units = [("_m_per_s2", ", m/s²"), ("_fraction", ""), ("_g", ", g"), ("_w", ", W"), ("_j", ", J")];
    let unit = units.iter().find(|(end, _)| name.ends_with(end));
    let (end, unit) = unit.copied().unwrap_or(("", ""));
    name.strip_suffix(end).unwrap_or(name).replace('_', " ") + unit
}

/// The means of shock and ride, if there are any.
fn ride(s: &mut String, report: &Report) {
    let told: Vec<usize> = (0..Ride::MEASURES.len())
        .filter(|k| report.figures.iter().any(|f| f.all.ride[*k].is_some()))
        .collect();
    if told.is_empty() {
        return;
    }
    s.push_str(
        "<h3>Shock and ride at the driver's seat, means over tasks</h3><div class=\"scroll\"><table class=\"sortable\"><thead><tr><th>run</th>",
    );
    for &k in &told {
        let measure = &Ride::MEASURES[k];
        let _ = write!(
            s,
            "<th class=\"n\" title=\"{}\">{}</th>",
            escape(measure.about),
            escape(&heading(measure.name))
        );
    }
    s.push_str("</tr></thead><tbody>");
    for (run, f) in report.runs.runs.iter().zip(&report.figures) {
        let _ = write!(s, "<tr><th>{}</th>", escape(&run.label));
        for &k in &told {
            let mean = f.all.ride[k];
            let _ = write!(
                s,
                "<td class=\"n\" data-v=\"{}\">{}</td>",
                mean.unwrap_or(-1.0),
                mean.map_or_else(|| "–".into(), |v| number(v, 2))
            );
        }
        s.push_str("</tr>");
    }
    s.push_str("</tbody></table></div>");
}

pub(super) fn worlds(s: &mut String, report: &Report, beside: &Beside) {
    if report.runs.worlds.len() > WORLDS {
        let _ = write!(s, "<p>Not drawn for {} worlds.</p>", grouped(report.runs.worlds.len() as u64));
        return;
    }
    let many = report.runs.runs.len() > 1;
    s.push_str("<div class=\"heats\">");
    for (k, (run, f)) in report.runs.runs.iter().zip(&report.figures).enumerate() {
        let _ = write!(
            s,
            "<div class=\"heat\"><h3>{}{}</h3><table><thead><tr><td></td>",
            if many { sample(k) } else { String::new() },
            escape(&run.label)
        );
        for e in Elevation::ALL {
            let _ = write!(s, "<th>{}</th>", e.name());
        }
        s.push_str("</tr></thead><tbody>");
        for terrain in Terrain::ALL {
            let _ = write!(s, "<tr><th>{}</th>", terrain.name());
            for elevation in Elevation::ALL {
                s.push_str("<td>");
                for density in Density::ALL {
                    for (w, (done, all)) in report.runs.worlds.iter().zip(&f.worlds) {
                        let here = (w.elevation, w.terrain, w.density) == (elevation, terrain, density);
                        if !here || *all == 0 {
                            continue;
                        }
                        let name = escape(&w.name);
                        let _ = write!(
                            s,
                            "<button type=\"button\" class=\"w h{} {}\" data-world=\"{name}\" data-run=\"{k}\" title=\"{name}, {}: {done} of \
                             {all} tasks\">{done}</button>",
                            heat((*done, *all)),
                            density.name(),
                            density.name()
                        );
                    }
                }
                s.push_str("</td>");
            }
            s.push_str("</tr>");
        }
        s.push_str("</tbody></table></div>");
    }
    s.push_str(
        "</div><p class=\"about\">One square per world, with its number of successes. Columns: elevation level; rows: terrain; \
         the bar below a square shows the obstacle density, which increases from left to right. Click a square to list the world's tasks.</p><p class=\"key\">no success",
    );
    for k in 0..6 {
        let _ = write!(s, "<i class=\"w h{k}\"></i>");
    }
    s.push_str("all tasks</p>");
    if !beside.maps.is_empty() {
        let links: Vec<String> =
            beside.maps.iter().map(|w| format!("<a href=\"maps/{0}.html\">{0}</a>", escape(w))).collect();
        let _ = write!(
            s,
            "<p class=\"about\">Maps with all trajectories, their ends and outcomes: {}.</p>",
            links.join(", ")
        );
    }
}

pub(super) fn distributions(s: &mut String, report: &Report) {
    s.push_str("<div class=\"plots\">");
    let drawn = Quantity::all(Extent::Pages);
    let drawn = drawn.iter().filter_map(|of| distribution(report, of, Scale::Linear, PAGE_FIGURE));
    drawn.for_each(|drawing| drawing.show(s));
    s.push_str("</div>");
}

pub(super) fn fuel(s: &mut String, report: &Report) {
    let metered = |run: &Run| run.counted().any(|r| r.fuel.is_some());
    if !report.runs.runs.iter().any(metered) {
        s.push_str(
            "<p>No planner of these runs is metered: native planners and commands have no fuel metering.</p>",
        );
        return;
    }
    s.push_str(
        "<div class=\"scroll\"><table class=\"sortable\"><thead><tr><th>run</th><th class=\"n\">init, maximum</th><th class=\"n\">step, median</th>\
         <th class=\"n\">step, 99th percentile</th><th class=\"n\">step, maximum</th><th class=\"n\">% of the limit</th><th class=\"n\">memory, MiB</th>\
         <th class=\"n\">clamped commands</th></tr></thead><tbody>",
    );
    for run in &report.runs.runs {
        let used: Vec<_> = run.counted().filter_map(|r| r.fuel).collect();
        let _ = write!(s, "<tr><th>{}</th>", escape(&run.label));
        if used.is_empty() {
            s.push_str("<td class=\"n\" colspan=\"6\">not metered</td>");
        } else {
            let mut medians: Vec<u64> = used.iter().map(|f| f.p50_step).collect();
            medians.sort_unstable();
            let most = |f: fn(&FuelUse) -> u64| used.iter().map(f).max().unwrap_or(0);
            for v in
                [most(|f| f.init), medians[medians.len() / 2], most(|f| f.p99_step), most(|f| f.max_step)]
            {
                let _ = write!(s, "<td class=\"n\" data-v=\"{v}\">{}</td>", grouped(v));
            }
            let fraction = used.iter().map(|f| f.max_fraction).fold(0.0, f64::max);
            let memory = most(|f| f.memory_bytes) as f64 / f64::from(1 << 20);
            let _ = write!(
                s,
                "<td class=\"n\">{}</td><td class=\"n\">{}</td>",
                number(100.0 * fraction, 4),
                number(memory, 1)
            );
        }
        let clamped: u64 = run.counted().map(|r| r.clamped).sum();
        let _ = write!(s, "<td class=\"n\" data-v=\"{clamped}\">{}</td></tr>", grouped(clamped));
    }
    s.push_str("</tbody></table></div><div class=\"plots\">");
    let fuel = Quantity {
        title: "Fuel per step, 99th percentile of a task",
        unit: "units, logarithmic",
        value: Box::new(|r| r.fuel.map(|f| f.p99_step as f64)),
    };
    let time = Quantity { title: "Simulated time of a task", unit: "s", value: Box::new(|r| Some(r.time)) };
    let drawn = [(fuel, Scale::Logarithmic), (time, Scale::Linear)];
    for drawing in drawn.iter().filter_map(|(of, scale)| distribution(report, of, *scale, PAGE_FIGURE)) {
        drawing.show(s);
    }
    s.push_str(
        "</div><p class=\"about\">Fuel is about one unit per instruction and identical on every machine, so it is comparable. \
         Wall-clock times are not recorded, because they depend on the machine.</p>",
    );
}

pub(super) fn about(s: &mut String, report: &Report) {
    s.push_str("<div class=\"scroll\"><table><thead><tr><th>run</th><th>directory</th><th>tasks</th><th>plugin</th><th>sha256</th><th>vehicle</th><th>rules</th><th>soils</th><th class=\"n\">scale</th><th class=\"n\">seed</th><th>trace</th><th>harness</th><th>started</th></tr></thead><tbody>");
    for run in &report.runs.runs {
        let h = &run.header;
        let short = |t: &str| escape(t.get(..12).unwrap_or(t));
        let text = |t: &str| escape(&crate::runs::one_line(t, 120));
        let _ = write!(
            s,
            "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}, {}</td><td><code title=\"{}\">{}</code></td><td>{} <code>{}</code></td><td>{} <code>{}</code></td>\
             <td>{} <code>{}</code></td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&run.label),
            text(&run.dir.display().to_string()),
            text(&h.scope()),
            text(&h.planner()),
            h.plugin.kind,
            escape(&h.plugin.sha256),
            short(&h.plugin.sha256),
            text(&h.vehicle.name),
            short(&h.vehicle.hash),
            text(&h.rules.name),
            short(&h.rules.hash),
            text(&h.soils.name),
            short(&h.soils.hash),
            h.scale,
            h.seed,
            h.trace.name(),
            text(&format!("{}, commit {}", h.harness_version, h.harness_commit)),
            text(&h.started_at),
        );
    }
    s.push_str(
        "</tbody></table></div><p class=\"about\">Intervals: bias-corrected and accelerated bootstrap (Efron 1987) that resamples whole worlds, \
         10 000 resamples, fixed seed. Test: sign flips of whole worlds (Fisher 1935; Good 2005), exact up to 18 worlds, otherwise 99 999 \
         random flips (Phipson and Smyth 2010), with Holm's correction (1979) within each measure. Ranks: Mogstad, Romano, Shaikh and Wilhelm (2024). Performance profiles follow Dolan and Moré (2002).</p>",
    );
}
