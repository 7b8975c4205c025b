//! Figures and tables for papers.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use common::{HOSTILE, header, tasks, write};
use vb_report::{Beside, Paper, PaperError, Report, ReportError, Runs};
use vb_score::TaskRecord;

/// What TeX would read as commands.
const TEX: &str = r"\input{x} & 50 % _^~ #1 $x$";

fn paper() -> Paper {
    Paper::new([3.5, 7.16], 8.0).unwrap()
}

fn read(dirs: &[PathBuf]) -> Report {
    Report::new(Runs::read(dirs).unwrap())
}

/// So many runs of planners that succeed in different tasks.
fn several(dir: &Path, count: usize) -> Vec<PathBuf> {
    let make = |k: usize| {
        let name = format!("planner-{k}");
        write(&dir.join(&name), &header(&name, 36), tasks(9, |w, t| (w + t) % (k + 2) != 0))
    };
    (0..count).map(make).collect()
}

fn names(report: &Report) -> Vec<&'static str> {
    report.paper_figures(&paper()).iter().map(|f| f.name).collect()
}

/// The texts of an SVG, each as its readers see it.
fn texts(svg: &str) -> Vec<String> {
    let parts = svg.split("<text ").skip(1);
    let shown = |part: &str| {
        let text = part.split_once('>').unwrap().1.split_once("</text>").unwrap().0;
        assert!(!text.contains('<'), "markup in a text: {text}");
        ["&lt;", "&gt;", "&quot;", "&#39;", "&amp;"]
            .iter()
            .zip(["<", ">", "\"", "'", "&"])
            .fold(text.to_owned(), |t, (from, to)| t.replace(from, to))
    };
    parts.map(shown).collect()
}

#[test]
fn there_is_a_figure_for_all_that_the_runs_have() {
    let dir = tempfile::tempdir().unwrap();
    let runs = several(dir.path(), 10);
    let all = ["results", "comparison", "profiles", "distributions", "causes"];
    assert_eq!(names(&read(&runs)), all);
    assert_eq!(names(&read(&runs[..2])), all);
    // One run is compared with nobody.
    assert_eq!(names(&read(&runs[..1])), ["results", "distributions", "causes"]);
    let files = |report: &Report| report.latex().into_iter().map(|(name, _)| name).collect::<Vec<_>>();
    assert_eq!(files(&read(&runs)), ["results", "comparison", "causes"]);
    assert_eq!(files(&read(&runs[..1])), ["results", "causes"]);
    // Nothing fails, so there are no causes; in one world there are no intervals.
    let good = write(&dir.path().join("good"), &header("good", 4), tasks(1, |_, _| true));
    assert_eq!(
        (names(&read(std::slice::from_ref(&good))), files(&read(&[good]))),
        (vec!["results", "distributions"], vec!["results"])
    );
    // Nothing succeeds, so there are no times.
    let bad = write(&dir.path().join("bad"), &header("bad", 12), tasks(3, |_, _| false));
    assert_eq!(names(&read(&[bad])), ["results", "distributions", "causes"]);
}

#[test]
fn figures_have_the_widths_of_the_paper_and_stay_on_its_pages() {
    let dir = tempfile::tempdir().unwrap();
    let runs = several(dir.path(), 10);
    for count in [1, 2, 4, 10] {
        let report = read(&runs[..count]);
        for [column, page, font] in [[3.5, 7.16, 8.0], [5.5, 5.5, 9.0]] {
            for found in report.paper_figures(&Paper::new([column, page], font).unwrap()) {
                let wide = if matches!(found.name, "profiles" | "causes") { column } else { page };
                let [width, height] = found.figure.size;
                assert!((width - 72.0 * wide).abs() < 1e-9, "{}: {width} pt", found.name);
                // A letter's page has 9 inches between its margins; what is longer than that is no figure.
                assert!(height > 72.0 && height < 9.6 * 72.0, "{} of {count} runs: {height} pt", found.name);
                let body = &found.figure.body;
                assert!(!body.contains("NaN") && !body.contains("inf"), "{}", found.name);
            }
        }
    }
}

#[test]
fn the_same_runs_give_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let runs = several(dir.path(), 3);
    let bytes = || -> Vec<Vec<u8>> {
        let report = read(&runs);
        let figures = report.paper_figures(&paper());
        let files = figures.into_iter().flat_map(|f| {
            [f.figure.svg().into_bytes(), f.figure.pdf().unwrap(), f.figure.png(300.0).unwrap()]
        });
        files.chain(report.latex().into_iter().map(|(_, t)| t.into_bytes())).collect()
    };
    assert_eq!(bytes(), bytes());
}

#[test]
fn files_open_and_have_their_font_and_their_resolution() {
    let dir = tempfile::tempdir().unwrap();
    let report = read(&several(dir.path(), 2));
    for found in report.paper_figures(&paper()) {
        let pdf = found.figure.pdf().unwrap();
        let text = String::from_utf8_lossy(&pdf);
        assert!(
            text.starts_with("%PDF-") && text.contains("/FontFile2 ") && text.contains("+LiberationSans/")
        );
        let png = found.figure.png(300.0).unwrap();
        assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
        let width = u32::from_be_bytes(png[16..20].try_into().unwrap());
        let inches = if matches!(found.name, "profiles" | "causes") { 3.5 } else { 7.16 };
        assert_eq!(width, (300.0_f64 * inches).round() as u32, "{}", found.name);
        assert!(texts(&found.figure.svg()).iter().any(|t| t.contains("planner-1")), "{}", found.name);
    }
}

#[test]
fn foreign_names_are_texts_in_figures_and_tables() {
    let dir = tempfile::tempdir().unwrap();
    let make = |folder: &str, name: &str| {
        write(&dir.path().join(folder), &header(name, 36), tasks(9, |w, t| (w + t) % 3 != 0))
    };
    let runs = [make("a", "<script>"), make("b", TEX), make("c", HOSTILE)];
    let report = read(&runs).titled("</title><script>alert(1)</script>");
    for found in report.paper_figures(&paper()) {
        let svg = found.figure.svg();
        assert!(!svg.contains("<script") && !svg.contains("<img"), "{}", found.name);
        assert_eq!(svg.matches("</title>").count(), svg.matches("<title>").count(), "{}", found.name);
        let texts = texts(&svg);
        assert!(texts.iter().any(|t| t.contains("<script>")), "{}: {texts:?}", found.name);
        found.figure.pdf().unwrap();
    }
    for (name, table) in report.latex() {
        assert!(!table.contains(r"\input") && !table.contains("$x$"), "{name}: {table}");
        let rows = table.lines().filter(|l| !l.starts_with('%'));
        // Outside of comments, each percent sign, number sign and low line is escaped.
        for row in rows {
            let bare = row.replace("\\%", "").replace("\\#", "").replace("\\_", "");
            assert!(!bare.contains(['%', '#', '_', '~']), "{name}: {row}");
        }
        let tex = r"\textbackslash{}input\{x\} \& 50 \% \_\textasciicircum{}\textasciitilde{} \#1 \$x\$";
        assert!(table.contains(tex) && table.contains(r"\textless{}script\textgreater{}"), "{name}: {table}");
    }
}

#[test]
fn the_best_is_bold_only_if_the_test_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let run = |name: &str, worlds: usize, share: usize| {
        let folder = dir.path().join(format!("{name}-{worlds}"));
        write(&folder, &header(name, 36), tasks(worlds, |_, t| t < share))
    };
    let table = |worlds: usize| {
        let report = read(&[run("bad", worlds, 1), run("good", worlds, 3)]);
        report.latex().into_iter().map(|(_, t)| t).collect::<Vec<_>>()
    };
    // In nine worlds p is 2 · 2⁻⁹ = 0.0039; in three worlds it can't be below 0.25.
    let tables = table(9);
    let [results, comparison, causes] = &tables[..] else { panic!("three tables") };
    assert!(
        results.contains("1 & good & 36 & \\textbf{75.0} [") && results.contains("2 & bad & 36 & 25.0 ["),
        "{results}"
    );
    assert!(
        comparison.contains("good $-$ bad & success, points & \\textbf{+50.00} & [")
            && comparison.contains("& 0.004 & better")
    );
    assert!(
        results.contains(
            "\\begin{tabular}{@{}rlrrrrrrrr@{}}\n\\toprule\nrank & planner & tasks & success, \\% "
        ),
        "{results}"
    );
    assert!(causes.contains("all failures & 27 (75.0\\,\\%) & 9 (25.0\\,\\%)"), "{causes}");
    let [results, comparison, _] = &table(3)[..] else { panic!("three tables") };
    assert!(!results.contains("\\textbf") && !comparison.contains("\\textbf"), "{results}{comparison}");
    assert!(comparison.contains("& -- & too few worlds"), "{comparison}");
    // As many fields in each row.
    for table in tables {
        let rows: Vec<&str> = table.lines().filter(|l| l.ends_with("\\\\")).collect();
        let fields = |row: &str| row.replace("\\&", "").matches('&').count();
        assert!(rows.len() > 2 && rows.iter().all(|r| fields(r) == fields(rows[0])), "{table}");
    }
}

#[test]
fn causes_add_up_and_say_what_is_unknown() {
    let dir = tempfile::tempdir().unwrap();
    // Of four tasks a world t00 succeeds, t01 and t02 dig in, t03 is high-centred.
    let run = write(&dir.path().join("r"), &header("pid", 20), tasks(5, |_, t| t == 0));
    let figure = |report: &Report| {
        let all = report.paper_figures(&paper());
        texts(&all.into_iter().find(|f| f.name == "causes").unwrap().figure.svg())
    };
    let shown = figure(&read(&[run]));
    for told in ["a", "spinning on soil", "b", "high-centred", "75.0\u{2009}%", "all tasks", "elevation: low"]
    {
        assert!(shown.iter().any(|t| t == told), "{told}: {shown:?}");
    }
    let old = tasks(5, |_, t| t == 0).into_iter().map(|r| TaskRecord { cause: None, ..r });
    let old = write(&dir.path().join("old"), &header("pid", 20), old);
    let shown = figure(&read(&[old]));
    assert!(shown.iter().any(|t| t == "stuck, cause unknown"), "{shown:?}");
}

#[test]
fn runs_are_called_as_the_user_calls_them() {
    let dir = tempfile::tempdir().unwrap();
    let runs = several(dir.path(), 3);
    let label = |labels: &[&str]| {
        let mut all = Runs::read(&runs).unwrap();
        let given: Vec<String> = labels.iter().map(|l| (*l).to_owned()).collect();
        all.relabel(&given).map(|()| all)
    };
    let whole = format!("{}=PID, 5 m/s = fast", runs[1].display());
    let all = label(&["planner-0=Ours", &whole]).unwrap();
    let labels: Vec<&str> = all.runs.iter().map(|r| r.label.as_str()).collect();
    assert_eq!(labels, ["Ours", "PID, 5 m/s = fast", "planner-2"]);
    let report = Report::new(all).titled("A title");
    let page = report.page(&Beside::default());
    assert!(page.contains("<h1>A title <small>") && page.contains("Ours") && !page.contains(">planner-0<"));
    assert!(report.latex()[0].1.contains("& Ours &") && report.latex()[0].1.starts_with("% A title\n"));
    let svg = report.paper_figures(&paper())[0].figure.svg();
    assert!(texts(&svg).contains(&"A title".to_owned()) && texts(&svg).contains(&"Ours".to_owned()));
    // Two may change their names with each other.
    assert!(label(&["planner-0=planner-1", "planner-1=planner-0"]).is_ok());

    let message = |labels: &[&str]| label(labels).unwrap_err().to_string();
    assert!(matches!(label(&["nobody=x"]), Err(ReportError::Label { .. })));
    assert!(message(&["nobody=x"]).contains("planner-2"), "the runs that there are");
    assert!(message(&["planner-0"]).contains("RUN=TEXT"));
    assert!(message(&["planner-0="]).contains("text is empty"));
    assert!(message(&["planner-0=x", "planner-0=y"]).contains("already has the label `x`"));
    assert!(message(&["planner-0=planner-1"]).contains("has the same label"));
}

#[test]
fn widths_and_sizes_that_leave_no_room_are_refused() {
    assert!(matches!(Paper::new([3.5, 7.16], 3.0), Err(PaperError::Font(_))));
    assert!(matches!(Paper::new([3.5, 7.16], f64::NAN), Err(PaperError::Font(_))));
    let message = Paper::new([3.5, 3.5], 8.0).unwrap_err().to_string();
    // 480 units of 8/12 pt are 4.45 in.
    assert!(message.contains("across the page of 3.5 in") && message.contains("needs 4.45 in"), "{message}");
    assert!(Paper::new([2.41, 4.45], 8.0).is_ok());
    assert!(matches!(Paper::new([1.0, 7.16], 8.0), Err(PaperError::Narrow { what: "in a column", .. })));
}

#[test]
fn unknown_parameters_in_names_do_no_harm() {
    let dir = tempfile::tempdir().unwrap();
    let mut odd = header("pid", 36);
    odd.params = BTreeMap::from([("speed".into(), "\u{4e2d}\u{202e}\n\u{1f600}".into())]);
    let runs = [
        write(&dir.path().join("a"), &odd, tasks(9, |_, t| t < 2)),
        write(&dir.path().join("b"), &header("pid", 36), tasks(9, |_, t| t < 3)),
    ];
    for found in read(&runs).paper_figures(&paper()) {
        // What the font lacks is drawn as a box, and stays a text in the SVG.
        assert!(found.figure.svg().contains('\u{4e2d}') && !found.figure.svg().contains('\u{202e}'));
        found.figure.pdf().unwrap();
        found.figure.png(72.0).unwrap();
    }
}
