//! The page: filters, a card a world, the larger view, tables and plots.

use super::plot::{Curve, plot};
use crate::statistics::tables::EMPTY;
use crate::statistics::{Histogram, Relief, SuiteStatistics, Summary, Table, WorldStatistics};
use std::fmt::Write as _;
use vb_page::map::{
    Colour, EXAGGERATION, FRICTION, GRIPS, HEIGHTS, SLOPES, SPREADS, STEEP, Sources, map, pictures,
};
use vb_page::{Page, escape, number};
use vb_world::{Density, Elevation, Terrain, TerrainClass, World};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

fn swatch(colour: Colour) -> String {
    let [r, g, b] = colour;
    format!("<i class=\"swatch\" style=\"background:rgb({r},{g},{b})\"></i>")
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    Summary::of(values).map(|s| s.mean)
}

/// A world's card: map, labels, key figures, and what the larger view adds.
pub(super) fn card(world: &World, w: &WorldStatistics, side: usize) -> String {
    let id = escape(&w.id);
    let detour = mean(w.tasks.iter().map(|t| t.ratio));
    let mut s = String::new();
    let _ = write!(
        s,
        "<article class=\"card\" id=\"{id}\" data-elevation=\"{e}\" data-terrain=\"{t}\" data-density=\"{d}\" \
         data-slope=\"{:.3}\" data-relief=\"{:.4}\" data-detour=\"{:.5}\"><button class=\"open\" type=\"button\" \
         aria-label=\"Show {id} larger\">{}</button><h3>{id} {}</h3><dl>",
        w.slopes.p95,
        w.height_std,
        detour.unwrap_or(0.0),
        map(world, &Sources::inline(&pictures(world, side)), ""),
        labels(w),
        e = w.elevation.name(),
        t = w.terrain.name(),
        d = w.density.name(),
    );
    let mut figure = |name: &str, value: String| {
        let _ = write!(s, "<div><dt>{name}</dt><dd>{value}</dd></div>");
    };
    figure("spread", format!("{} m", number(w.height_std, 2)));
    figure("slope p95", format!("{}°", number(w.slopes.p95, 1)));
    figure("obstacles", w.obstacles.total().to_string());
    figure(
        "detour",
        detour.map_or_else(|| EMPTY.to_owned(), |d| format!("{} %", number(100.0 * (d - 1.0), 1))),
    );
    s.push_str("</dl>");
    ground_bar(&mut s, w);
    s.push_str("<template>");
    more(&mut s, w);
    s.push_str("</template></article>");
    s
}

fn labels(w: &WorldStatistics) -> String {
    format!(
        "<span class=\"chips\"><span class=\"chip {e}\">{e}</span><span class=\"chip\">{}</span><span class=\"chip\">{}</span></span>",
        w.terrain.name(),
        w.density.name(),
        e = w.elevation.name(),
    )
}

/// The shares of the classes as a bar.
fn ground_bar(s: &mut String, w: &WorldStatistics) {
    s.push_str("<div class=\"ground\" aria-hidden=\"true\">");
    for c in &w.classes {
        let [r, g, b] = c.class.colour();
        let soil = c.soil.map_or_else(String::new, |l| format!(", {}", l.name()));
        let _ = write!(
            s,
            "<i style=\"flex:{:.4};background:rgb({r},{g},{b})\" title=\"{} {} %{soil}\"></i>",
            c.fraction,
            c.class.name(),
            number(100.0 * c.fraction, 0)
        );
    }
    s.push_str("</div>");
}

/// What the larger view shows beside the map.
fn more(s: &mut String, w: &WorldStatistics) {
    s.push_str("<table class=\"figures\"><tbody>");
    let mut row = |name: &str, value: String| {
        let _ = write!(s, "<tr><th>{name}</th><td>{value}</td></tr>");
    };
    row(
        "size",
        format!("{} × {} m, resolution {} m", number(w.extent[0], 0), number(w.extent[1], 0), w.resolution),
    );
    row(
        "heights",
        format!(
            "mean {} m, standard deviation {} m, relief {} m",
            number(w.height_mean, 2),
            number(w.height_std, 3),
            number(w.relief, 2)
        ),
    );
    let slopes = [w.slopes.p50, w.slopes.p95, w.slopes.p99, w.slopes.max].map(|v| number(v, 1));
    row(
        "slope over 1 m",
        format!("p50 {}°, p95 {}°, p99 {}°, max {}°", slopes[0], slopes[1], slopes[2], slopes[3]),
    );
    let kinds =
        [(w.obstacles.boulders, "boulders"), (w.obstacles.boxes, "boxes"), (w.obstacles.trunks, "trunks")];
    let kinds: Vec<_> = kinds.iter().filter(|k| k.0 > 0).map(|(n, name)| format!("{n} {name}")).collect();
    let kinds = if kinds.is_empty() { "none".to_owned() } else { kinds.join(", ") };
    row("obstacles", format!("{kinds}; {} % of the area", number(100.0 * w.covered, 1)));
    if let Some(f) = w.friction {
        let figures = [f.mean, f.min, f.max].map(|v| number(v, 2));
        row("friction", format!("mean {}, {} to {}", figures[0], figures[1], figures[2]));
    }
    s.push_str("</tbody></table><ul class=\"classes\">");
    for c in &w.classes {
        let soil = c.soil.map_or_else(String::new, |l| format!(", {}", l.name()));
        let fraction = number(100.0 * c.fraction, 0);
        let _ = write!(s, "<li>{}{} {fraction} %{soil}</li>", swatch(c.class.colour()), c.class.name());
    }
    s.push_str("</ul>");
    if w.tasks.is_empty() {
        return;
    }
    s.push_str(
        "<table class=\"tasks\"><thead><tr><th>task</th><th class=\"n\">path m</th><th class=\"n\">detour</th>\
         <th class=\"n\">clearance m</th><th class=\"n\">ascent m</th><th class=\"n\">steepest</th></tr></thead><tbody>",
    );
    for t in &w.tasks {
        let id = escape(&t.id);
        let unproven = match t.proven {
            Some(false) => " <abbr title=\"no solvability certificate\">?</abbr>",
            _ => "",
        };
        let _ = write!(
            s,
            "<tr data-task=\"{id}\" tabindex=\"0\"><td>{id}{unproven}</td><td class=\"n\">{}</td><td class=\"n\">{} %</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td><td class=\"n\">{}°</td></tr>",
            number(t.length, 1),
            number(100.0 * (t.ratio - 1.0), 1),
            t.clearance.map_or_else(|| EMPTY.to_owned(), |c| number(c, 2)),
            number(t.ascent, 1),
            number(t.steepest, 1)
        );
    }
    s.push_str("</tbody></table>");
}

pub(super) fn page(cards: &[String], statistics: &SuiteStatistics) -> String {
    let name = escape(&statistics.name);
    let mut s = String::with_capacity(cards.iter().map(String::len).sum::<usize>() + 100_000);
    let _ = write!(
        s,
        "<header><h1>{name} <small>{}</small></h1><p>{}</p><p class=\"meta\">{} worlds, {} tasks, \
         {}; hash <code title=\"{hash}\">{}</code>; Verti-Bench in Rust {}</p></header><main>",
        escape(&statistics.version),
        escape(&statistics.description),
        statistics.world_count,
        statistics.task_count,
        escape(&statistics.provenance),
        escape(statistics.hash.get(..16).unwrap_or(&statistics.hash)),
        env!("CARGO_PKG_VERSION"),
        hash = escape(&statistics.hash),
    );
    bar(&mut s, statistics);
    legends(&mut s, statistics);
    s.push_str("<section class=\"worlds\" id=\"worlds\" aria-label=\"Worlds\">");
    cards.iter().for_each(|card| s.push_str(card));
    s.push_str("<p class=\"none\" hidden>No world has these labels.</p></section>");
    figures(&mut s, statistics);
    s.push_str(
        "</main><dialog id=\"large\" aria-labelledby=\"large-title\"><header><h2 id=\"large-title\"></h2><nav>\
         <button type=\"button\" data-go=\"-1\" aria-label=\"Previous world\">‹</button>\
         <button type=\"button\" data-go=\"1\" aria-label=\"Next world\">›</button>\
         <button type=\"button\" data-go=\"0\" aria-label=\"Close\">×</button></nav></header>\
         <div class=\"view\"><div class=\"stage\"></div><div class=\"side\"></div></div></dialog>",
    );
    Page {
        title: &format!("Suite {}", statistics.name),
        styles: &[vb_page::map::STYLE, STYLE],
        attributes: "data-ground=\"classes\"",
        body: &s,
        script: SCRIPT,
        ..Page::default()
    }
    .html()
}

/// The toolbar with filters and display options.
fn bar(s: &mut String, statistics: &SuiteStatistics) {
    s.push_str("<div class=\"bar\" role=\"toolbar\" aria-label=\"Display options\">");
    let mut group = |key: &str, names: &[&str]| {
        let _ = write!(s, "<fieldset data-filter=\"{key}\"><legend>{key}</legend>");
        for name in names {
            let n = statistics.worlds.iter().filter(|w| {
                [w.elevation.name(), w.terrain.name(), w.density.name()][match key {
                    "elevation" => 0,
                    "terrain" => 1,
                    _ => 2,
                }] == *name
            });
            let n = n.count();
            let off = if n == 0 { " disabled" } else { "" };
            let _ = write!(
                s,
                "<button type=\"button\" aria-pressed=\"false\" value=\"{name}\"{off}>{name} <small>{n}</small></button>"
            );
        }
        s.push_str("</fieldset>");
    };
    group("elevation", &Elevation::ALL.map(Elevation::name));
    group("terrain", &Terrain::ALL.map(Terrain::name));
    group("density", &Density::ALL.map(Density::name));
    s.push_str("<fieldset data-choice=\"ground\"><legend>terrain map</legend>");
    for (value, name) in [
        ("classes", "classes"),
        ("heights", "heights"),
        ("slopes", "slope"),
        ("friction", "friction"),
        ("relief", "relief only"),
    ] {
        let pressed = value == "classes";
        let _ =
            write!(s, "<button type=\"button\" aria-pressed=\"{pressed}\" value=\"{value}\">{name}</button>");
    }
    s.push_str(
        "</fieldset><fieldset data-toggles><legend>overlay</legend>\
         <button type=\"button\" aria-pressed=\"true\" value=\"obstacles\">obstacles</button>\
         <button type=\"button\" aria-pressed=\"true\" value=\"tasks\">paths</button></fieldset>\
         <fieldset class=\"sort\"><legend>order</legend><select aria-label=\"Order\"><option value=\"\">as in the suite</option>\
         <option value=\"relief\">flattest first</option><option value=\"slope\">gentlest slopes first</option>\
         <option value=\"detour\">straightest paths first</option></select></fieldset>",
    );
    let _ = write!(
        s,
        "<p class=\"count\" aria-live=\"polite\"><b>{n}</b> of {n} worlds <a href=\"#figures\">figures ↓</a></p></div>",
        n = statistics.world_count
    );
}

fn legends(s: &mut String, statistics: &SuiteStatistics) {
    s.push_str("<div class=\"legends\"><ul class=\"legend\" data-for=\"classes\">");
    for class in TerrainClass::ALL {
        if statistics.classes.iter().any(|c| c.class == class) {
            let _ = write!(s, "<li>{}{}</li>", swatch(class.colour()), class.name());
        }
    }
    s.push_str("</ul>");
    let mut scale = |key: &str, colours: &[Colour], low: &str, high: &str| {
        let stops: Vec<_> = colours.iter().map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
        let _ = write!(
            s,
            "<p class=\"legend\" data-for=\"{key}\">{low} <i class=\"scale\" style=\"background:linear-gradient(90deg,{})\"></i> {high}</p>",
            stops.join(",")
        );
    };
    scale(
        "heights",
        &HEIGHTS,
        &format!("−{SPREADS} standard deviations"),
        &format!("+{SPREADS} standard deviations from each world's mean height"),
    );
    scale("slopes", &SLOPES, "level", &format!("{STEEP}° or steeper, over 1 m"));
    let [low, high] = FRICTION.map(|f| number(f, 1));
    scale("friction", &GRIPS, &format!("friction {low}"), &format!("{high}; grey: deformable"));
    let _ = write!(
        s,
        "<ul class=\"legend signs\"><li><svg viewBox=\"-3 -3 6 6\"><path class=\"boulder\" d=\"M-2 -1L0 -2.2L2.1 -.6L1.6 1.8L-1.4 2Z\"/></svg>boulder, box</li>\
         <li><svg viewBox=\"-3 -3 6 6\"><circle class=\"trunk\" r=\"1.6\"/></svg>tree</li>\
         <li><svg viewBox=\"-3 -3 6 6\"><path class=\"start\" d=\"M2.6 0L-1.4 -1.4L-.7 0L-1.4 1.4Z\"/></svg>start</li>\
         <li><svg viewBox=\"-3 -3 6 6\"><circle class=\"goal\" r=\"1.9\"/></svg>goal</li>\
         <li><svg viewBox=\"-6 -3 12 6\" class=\"wide\"><path class=\"casing\" d=\"M-6 0H6\"/><path class=\"line\" d=\"M-6 0H6\"/></svg>global path</li>\
         <li>north is up; sun from the north-west; heights ×{EXAGGERATION} in the shading</li></ul></div>"
    );
}

fn figures(s: &mut String, statistics: &SuiteStatistics) {
    s.push_str("<section id=\"figures\"><h2>Figures</h2><div class=\"plots\">");
    let by_level = |histogram: fn(&Relief) -> &Histogram| -> Vec<Curve<'_>> {
        let mut curves = Vec::new();
        for r in &statistics.relief {
            let (name, colour) = (r.elevation.name(), r.elevation as usize);
            curves.push(Curve { name, colour, histogram: histogram(r) });
        }
        curves
    };
    if !statistics.relief.is_empty() {
        s.push_str(&plot("Heights relative to each world's mean", "m", &by_level(|r| &r.heights)));
        s.push_str(&plot("Slope over 1 m", "degrees", &by_level(|r| &r.slope_histogram)));
    }
    if !statistics.tasks_by_density.is_empty() {
        let by_density = statistics.tasks_by_density.iter();
        let curves: Vec<_> = by_density
            .map(|(d, t)| Curve { name: d.name(), colour: *d as usize, histogram: &t.lengths })
            .collect();
        s.push_str(&plot("Length of the global paths", "m", &curves));
    }
    s.push_str("</div><div class=\"tables\">");
    let mut tables = statistics.tables();
    tables.push(statistics.world_table());
    for t in &tables {
        table(s, t, statistics);
    }
    s.push_str("</div></section>");
}

fn table(s: &mut String, t: &Table, statistics: &SuiteStatistics) {
    let _ = write!(
        s,
        "<div class=\"table\"><h3>{}</h3><p class=\"about\">{}</p><div class=\"scroll\"><table><thead><tr>",
        escape(t.title),
        escape(t.about)
    );
    // A column is one of numbers if its cells are.
    let numeric: Vec<bool> = (0..t.head.len())
        .map(|c| {
            c > 0
                && t.rows
                    .iter()
                    .filter_map(|r| r.get(c))
                    .all(|cell| cell.is_empty() || cell == EMPTY || cell.parse::<f64>().is_ok())
        })
        .collect();
    let class = |c: usize| if numeric[c] { " class=\"n\"" } else { "" };
    for (c, head) in t.head.iter().enumerate() {
        let _ = write!(s, "<th{}>{}</th>", class(c), escape(head));
    }
    s.push_str("</tr></thead><tbody>");
    for row in &t.rows {
        s.push_str("<tr>");
        for (c, cell) in row.iter().enumerate() {
            let link = c == 0 && t.title == "Worlds" && statistics.worlds.iter().any(|w| w.id == *cell);
            let text = escape(cell);
            let swatch = TerrainClass::ALL
                .into_iter()
                .find(|k| c == 0 && k.name() == cell)
                .map_or_else(String::new, |k| swatch(k.colour()));
            let empty = cell == EMPTY;
            let class = match (numeric[c], empty) {
                (true, true) => " class=\"n empty\"",
                (true, false) => " class=\"n\"",
                (false, true) => " class=\"empty\"",
                (false, false) => "",
            };
            let _ = if link {
                write!(s, "<td{class}><a href=\"#{text}\">{text}</a></td>")
            } else {
                write!(s, "<td{class}>{swatch}{text}</td>")
            };
        }
        s.push_str("</tr>");
    }
    s.push_str("</tbody></table></div></div>");
}
