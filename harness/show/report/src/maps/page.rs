//! The page of a map.

use std::fmt::Write as _;

use vb_page::{Page, TABLE_STYLE, escape, number};
use vb_world::World;

use vb_page::map::Sources;

use super::{MAP_SIDE, MapLinks, Way, WorldMap};
use crate::Report;
use crate::drawing::series::{colour, marker, sample};
use crate::drawing::{DRAWING_STYLE, PAGE_STYLE};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

pub(super) fn of_world(map: &WorldMap<'_>, links: &MapLinks<'_>) -> String {
    let WorldMap { report, world, ways } = map;
    let name = escape(&world.id);
    let mut head = format!(
        "<h1>{name} <small>{} relief, {} ground, {} obstacles</small></h1><p class=\"meta\">{}</p><nav>",
        world.elevation.name(),
        world.terrain.name(),
        world.density.name(),
        escape(&report.runs.scope()),
    );
    for (text, href) in &links.above {
        let _ = write!(head, "<a href=\"{}\">{}</a>", escape(href), escape(text));
    }
    let _ = write!(head, "<a href=\"{}#worlds\">Report</a>", escape(links.report));
    for (link, rel, text) in [(links.previous, "prev", "previous world"), (links.next, "next", "next world")]
    {
        if let Some(other) = link {
            let other = escape(other);
            let _ = write!(head, "<a rel=\"{rel}\" href=\"{other}.html\">{text} ({other})</a>");
        }
    }
    head.push_str("</nav>");
    let mut s = String::from("<div class=\"view\"><div class=\"stage\">");
    let drawn = drawn(report, world, ways);
    s.push_str(&match &links.pictures {
        Some(beside) => vb_page::map::map(world, beside, &drawn),
        None => vb_page::map::map(world, &Sources::inline(&vb_page::map::pictures(world, MAP_SIDE)), &drawn),
    });
    s.push_str("</div><div class=\"side\">");
    controls(&mut s, report);
    table(&mut s, report, world, ways, links);
    s.push_str("</div></div>");
    let title = format!("{} on {}", world.id, report.runs.scope());
    Page {
        title: &title,
        styles: &[TABLE_STYLE, DRAWING_STYLE, PAGE_STYLE, vb_page::map::STYLE, STYLE],
        attributes: "data-ground=\"classes\"",
        body: &format!("<header>{head}</header><main>{s}</main>"),
        script: SCRIPT,
        images_beside: links.pictures.is_some(),
        ..Page::default()
    }
    .html()
}

/// Ways first, and over all of them the places where they ended.
fn drawn(report: &Report, world: &World, ways: &[Way<'_>]) -> String {
    let half = [world.heightfield.half_x(), world.heightfield.half_y()];
    let unit = half[0].max(half[1]) / 64.0;
    let mut s = String::from("<g class=\"ways\">");
    let open = |s: &mut String, w: &Way<'_>| {
        let _ = write!(
            s,
            "<g data-task=\"{}\" data-run=\"{}\" data-done=\"{}\">",
            w.row.task.task(),
            w.run,
            w.row.succeeded()
        );
    };
    for w in ways.iter().filter(|w| w.points.len() > 1) {
        open(&mut s, w);
        let d = points(&w.points);
        let (colour, dash) = (colour(w.run), w.run % 5);
        let _ = write!(
            s,
            "<path class=\"under\" d=\"{d}\"/><path class=\"way s{colour} d{dash}\" d=\"{d}\"><title>{}</title></path></g>",
            escape(&told(report, w))
        );
    }
    for w in ways {
        // Where the way of a success leads to is seen. Of others the outcome stands where they ended, or else at the goal.
        let seen = w.points.len() > 1 && w.row.succeeded();
        let Some(([x, y], known)) = w.end().filter(|_| !seen) else { continue };
        let alone = report.runs.runs.len() == 1;
        // A ring around the sign of the goal, or one of several beside it, each with the marker of its run.
        let (at, radius) = match known || alone {
            true => ([x, -y], if known { 2.1 } else { 2.9 }),
            false => (beside([x, -y], w.run, report.runs.runs.len(), half), 2.1),
        };
        open(&mut s, w);
        let outcome = w.row.outcome.index();
        let title = told(report, w);
        let _ = write!(
            s,
            "<circle class=\"end{} e{outcome}\" cx=\"{:.2}\" cy=\"{:.2}\" r=\"{:.2}\"><title>{}</title></circle>",
            if known { "" } else { " unplaced" },
            at[0],
            at[1],
            radius * unit,
            escape(&title)
        );
        if known || !alone {
            marker(&mut s, w.run, at, 1.3 * unit, &title);
        }
        s.push_str("</g>");
    }
    s.push_str("</g>");
    s
}

/// A place at a goal (in SVG, y downwards) for one of several runs: their rings lie around it, so that none covers another, and
/// within the map, whose half extent is `half`.
fn beside([x, y]: [f64; 2], run: usize, runs: usize, half: [f64; 2]) -> [f64; 2] {
    let unit = half[0].max(half[1]) / 64.0;
    let (sin, cos) = vb_math::sin_cos(std::f64::consts::TAU * run as f64 / runs as f64);
    let away = 3.4 * unit;
    let within = |v: f64, half: f64| {
        let most = (half - 2.4 * unit).max(0.0);
        v.clamp(-most, most)
    };
    [within(x + away * sin, half[0]), within(y - away * cos, half[1])]
}

fn points(way: &[[f64; 2]]) -> String {
    let mut d = String::new();
    for (k, [x, y]) in way.iter().enumerate() {
        let _ = write!(d, "{}{x:.2} {:.2}", if k == 0 { 'M' } else { 'L' }, -y);
    }
    d
}

/// A one-sentence description of the result.
fn told(report: &Report, w: &Way<'_>) -> String {
    let outcome = w.row.outcome.name().replace('_', " ");
    let note = if w.row.note.is_empty() { String::new() } else { format!(": {}", w.row.note) };
    let label = &report.runs.runs[w.run].label;
    let place = match (w.points.is_empty(), w.row.metrics) {
        (true, Some(m)) => format!(", {} m from the goal", number(m.goal_distance_end_m, 1)),
        _ => String::new(),
    };
    format!("{label}, {}: {outcome} after {} s{place}{note}", w.row.task, number(w.row.time, 1))
}

fn controls(s: &mut String, report: &Report) {
    s.push_str("<form class=\"bar\" autocomplete=\"off\"><fieldset><legend>runs</legend>");
    for (k, run) in report.runs.runs.iter().enumerate() {
        let _ = write!(
            s,
            "<label><input type=\"checkbox\" name=\"run\" value=\"{k}\" checked>{}{}</label>",
            sample(k),
            escape(&run.label)
        );
    }
    s.push_str(
        "</fieldset><label>trajectories <select name=\"ways\"><option value=\"\">all</option><option value=\"false\">of failures</option><option \
         value=\"true\">of successes</option></select></label><label>terrain <select name=\"ground\"><option value=\"classes\">classes</option>\
         <option value=\"heights\">heights</option><option value=\"slopes\">slopes</option><option value=\"friction\">friction</option>\
         </select></label></form>",
    );
}

/// A row a task, a column a run.
fn table(s: &mut String, report: &Report, world: &World, ways: &[Way<'_>], links: &MapLinks<'_>) {
    s.push_str("<div class=\"scroll\"><table class=\"tasks\"><thead><tr><th>task</th>");
    for (k, run) in report.runs.runs.iter().enumerate() {
        let _ = write!(s, "<th>{}{}</th>", sample(k), escape(&run.label));
    }
    let replays = world.tasks.iter().any(|t| links.replays.contains(&world.task_id(t)));
    s.push_str(if replays { "<th>replay</th></tr></thead><tbody>" } else { "</tr></thead><tbody>" });
    let mut untraced = false;
    for task in &world.tasks {
        let full = world.task_id(task);
        let id = escape(&task.id);
        let _ = write!(
            s,
            "<tr data-task=\"{id}\" tabindex=\"0\"><th><a href=\"{}#task={}\" title=\"in the report\">{id}</a></th>",
            escape(links.report),
            full
        );
        for run in 0..report.runs.runs.len() {
            let Some(w) = ways.iter().find(|w| w.run == run && w.row.task == full) else {
                s.push_str("<td>–</td>");
                continue;
            };
            untraced |= w.points.is_empty();
            let outcome = w.row.outcome.index();
            let why =
                w.row.cause.map_or_else(|| w.row.outcome.name().replace('_', " "), |c| c.title().to_owned());
            let _ = write!(
                s,
                "<td title=\"{}\"><i class=\"swatch o{outcome}\"></i>{} <small>{} s</small></td>",
                escape(&told(report, w)),
                escape(&why),
                number(w.row.time, 1)
            );
        }
        if replays {
            let link = if links.replays.contains(&full) {
                format!("<a href=\"../replays/{}.html\">replay</a>", full)
            } else {
                String::new()
            };
            let _ = write!(s, "<td>{link}</td>");
        }
        s.push_str("</tr>");
    }
    s.push_str("</tbody></table></div>");
    if untraced {
        s.push_str(
            "<p class=\"about\">Some tasks have no trajectory on the map, because their traces were not recorded (run with --trace 10hz) or not included (a \
             submission contains traces of a few tasks). A ring marks their end. Tasks that ended before the first \
             sample have a dashed ring at the goal.</p>",
        );
    }
    s.push_str(
        "<p class=\"about\">A ring marks the end of a trajectory before the goal, in the colour of the outcome, with the run's marker. White \
         lines are the tasks' global paths. Click a task's row to show only its trajectories, or its name to open it in the report; ← and → open the previous and the next world.</p>",
    );
}
