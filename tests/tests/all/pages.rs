//! Reports, and what planners say in pages, in a real browser. Without Chromium the tests say so and pass.

use std::fs;

use vb_tests::{Bench, Browser, pid};

const HOSTILE: &str =
    "</script><script>document.title='owned'</script><img src=x onerror=\\\"document.title='owned'\\\">";

pub(crate) fn run(bench: &Bench, out: &str, speed: &str, tasks: &str) {
    let pid = pid();
    let plugin = pid.to_str().expect("paths of tests are text");
    let speed = format!("speed={speed}");
    bench.ok(&["--plugin", plugin, "--suite", "smoke", "--param", &speed, "--tasks", tasks, "--out", out]);
}

#[test]
fn a_report_is_shown_sorted_filtered_and_leads_to_replays() {
    let Some(mut browser) = Browser::start(1280, 900) else { return };
    let bench = Bench::new();
    run(&bench, "fast", "5", "w001/t00-t03,w003/t00-t01,w006/t08");
    run(&bench, "slow", "3", "w001/t00-t03,w003/t00-t01,w006/t08");
    bench.ok(&[
        "report",
        "fast",
        "slow",
        "--out",
        "page",
        "--replays",
        "w001/t00",
        "--csv",
        "page/tasks.csv",
    ]);
    let page = bench.path("page/index.html");
    browser.open(&page);
    let rows = "document.querySelectorAll('#browser tbody tr').length";
    assert_eq!(browser.eval(rows), 14);
    assert_eq!(browser.eval("document.querySelectorAll('.paper svg').length"), 12);
    assert!(browser.screenshot().content() > 0.1, "a page without content");

    // Sorted by time, the quickest comes first and then the slowest.
    let times =
        "[...document.querySelectorAll('#browser tbody tr')].map(r => Number(r.cells[6].textContent))";
    let sorted = |values: &serde_json::Value, up: bool| {
        let v: Vec<f64> =
            values.as_array().expect("a list").iter().filter_map(serde_json::Value::as_f64).collect();
        v.windows(2).all(|w| if up { w[0] <= w[1] } else { w[0] >= w[1] })
    };
    browser.click("#browser thead th:nth-child(7)");
    let found = browser.eval(times);
    assert!(sorted(&found, false), "{found}");
    browser.click("#browser thead th:nth-child(7)");
    let found = browser.eval(times);
    assert!(sorted(&found, true), "{found}");
    browser.click("#browser input");
    browser.type_text("w003/t01");
    assert_eq!(browser.eval(rows), 2);

    let link = browser.eval(
        "(() => { document.querySelector('#browser input').value = ''; \
        document.querySelector('#browser form').dispatchEvent(new Event('input')); \
        return document.querySelector('a.replay').getAttribute('href'); })()",
    );
    assert_eq!(link, "replays/w001/t00.html");
    assert!(bench.path("page/replays/w001/t00.html").is_file());

    let light = browser.screenshot().brightness();
    browser.prefer_dark(true);
    let dark = browser.screenshot().brightness();
    assert!(dark < 0.5 * light, "{dark} {light}");
    assert_eq!(browser.errors(), [] as [String; 0]);
}

/// The least contrast of a text with its ground by WCAG 2.2, with the text, in what a selector finds.
const CONTRAST: &str = "(selector => { const parts = c => (c.match(/[\\d.]+/g) || []).map(Number); \
    const linear = v => v <= 10.31475 ? v / 3294.6 : ((v / 255 + 0.055) / 1.055) ** 2.4; \
    const light = c => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]) + 0.05; \
    const ground = e => { for (; e; e = e.parentElement) { const c = parts(getComputedStyle(e).backgroundColor); \
      if (c.length === 3 || c[3] > 0) return c; } return [255, 255, 255]; }; \
    let least = [99, 'no text']; \
    for (const e of document.querySelectorAll(selector)) { \
      if (![...e.childNodes].some(n => n.nodeType === 3 && n.data.trim())) continue; \
      const style = getComputedStyle(e); \
      const [a, b] = [parts(e instanceof SVGElement ? style.fill : style.color), ground(e)].map(light); \
      const c = Math.max(a, b) / Math.min(a, b); \
      if (c < least[0]) least = [c, e.outerHTML.slice(0, 200)]; } return least; })";

#[test]
fn the_result_is_said_first_and_the_tasks_that_part_two_runs_are_listed() {
    let Some(mut browser) = Browser::start(1280, 900) else { return };
    let bench = Bench::new();
    // The fast one succeeds in the first two and in w002/t06 and w004/t08, the slow one in the first two and in w002/t05.
    let tasks = "w001/t00-t01,w002/t05-t06,w004/t08";
    run(&bench, "fast", "5", tasks);
    run(&bench, "slow", "3", tasks);
    let done = bench.run(&["report", "fast", "slow", "--out", "page", "--markdown", "page/report.md"]);
    let page = bench.path("page/index.html");
    browser.open(&page);
    let said = "pid (speed 5) has the highest success rate: 80.0 % of 5 tasks, but its lead over pid (speed 3) is not significant: 3 worlds \
                are too few (1 differs, 6 needed; run the 100 worlds of vb-100).";
    assert_eq!(browser.eval("document.querySelector('main > p.lead').textContent"), said);
    assert!(done.stderr.contains(said), "{}", done.stderr);
    let read = |file: &str| fs::read_to_string(bench.path(file)).expect("a file of the report");
    assert!(read("page/report.md").starts_with(said), "{}", read("page/report.md"));

    // By hand in the form, and by a click on a cell of the matrix.
    let listed =
        "[...document.querySelectorAll('#browser tbody tr')].map(r => r.cells[1].textContent).join(' ')";
    let choose = "(() => { const form = document.querySelector('#browser form'); form.does.value = '0'; form.not.value = '1'; \
        form.dispatchEvent(new Event('input')); })()";
    browser.eval(choose);
    assert_eq!(browser.eval(listed), "w002/t06 w004/t08 w002/t06 w004/t08");
    assert_eq!(browser.eval("document.querySelector('#browser output').textContent"), "4 of 10");
    browser.click(".matrix button[data-does='1'][data-not='0']");
    assert_eq!(browser.eval(listed), "w002/t05 w002/t05");
    browser.click("#comparison button[data-does='0'][data-not='1']");
    assert_eq!(browser.eval(listed), "w002/t06 w004/t08 w002/t06 w004/t08");
    // One of them is enough, too: what the slow one fails, of all runs.
    browser.eval(
        "(() => { const form = document.querySelector('#browser form'); form.does.value = ''; \
        form.dispatchEvent(new Event('input')); })()",
    );
    assert_eq!(browser.eval(listed), "w002/t06 w004/t08 w002/t06 w004/t08");

    // Every look that a cell can have is legible, in light and dark and on paper.
    let looks = "(() => { const looks = ['better', 'better strong', 'worse', 'worse strong', 'open', 'open rather-better', \
        'open rather-worse']; document.querySelector('details').open = true; \
        [...document.querySelectorAll('.matrix td:not(.none)')].forEach((e, k) => { if (e.textContent) e.className = looks[k % 7]; }); \
        return document.querySelectorAll('.matrix td.strong').length; })()";
    assert!(browser.eval(looks).as_f64() >= Some(2.0));
    for dark in [false, true] {
        browser.prefer_dark(dark);
        let texts =
            ".lead, .ranking *, .matrix *, .verdict, .key, .about, .about *, figure text, summary, .link";
        let found = browser.eval(&format!("{CONTRAST}({texts:?})"));
        assert!(found[0].as_f64() >= Some(4.5) && found[0].as_f64() < Some(30.0), "dark {dark}: {found}");
    }
    assert!(browser.screenshot().content() > 0.03, "a page without content");
    for width in [1400, 390] {
        browser.phone(width, 844);
        let over = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
        assert_eq!(browser.eval(over), 0, "at {width} the page is as wide as the window");
        browser.eval("document.querySelector('.matrix').scrollIntoView()");
        assert!(browser.screenshot().content() > 0.03, "a page without content");
    }
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn texts_of_a_planner_never_run_in_a_page() {
    let Some(mut browser) = Browser::start(1000, 800) else { return };
    let bench = Bench::new();
    run(&bench, "r", "5", "w001/t00");
    for (file, from) in [("r/run.json", "\"name\": \"pid\""), ("r/tasks.jsonl", "\"reason\":\"")] {
        let text = fs::read_to_string(bench.path(file)).expect("a file of the run");
        assert!(text.contains(from), "{file}");
        let to = if file.ends_with("json") {
            format!("\"name\": \"{HOSTILE}\"")
        } else {
            format!("{from}{HOSTILE}")
        };
        bench.write(file, text.replacen(from, &to, 1));
    }
    // They are against accidents: a forger deletes them.
    fs::remove_file(bench.path("r/checksums.txt")).expect("checksums");
    bench.ok(&["report", "r", "--out", "page", "--replays", "w001/t00"]);
    for page in ["page/index.html", "page/replays/w001/t00.html"] {
        browser.open(&bench.path(page));
        // Whatever would run has run by then.
        browser.eval("new Promise(done => setTimeout(done, 300))");
        assert_ne!(browser.eval("document.title"), "owned", "{page}");
        assert_eq!(browser.eval("document.querySelectorAll('img').length"), 0, "{page}");
        let text = browser.eval("document.body.textContent");
        assert!(text.as_str().is_some_and(|t| t.contains("<img src=x")), "{page}: shown as it is");
    }
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn what_cannot_be_shown_is_refused_with_its_reason() {
    let bench = Bench::new();
    run(&bench, "r", "5", "w001/t00");
    let done = bench.run(&["report", "r", "r", "--out", "page"]).error(2);
    assert!(done.contains("given twice"), "{done}");
    let done = bench.run(&["replay", "r", "--task", "w001/t09", "--out", "x.html"]).error(2);
    assert!(
        done.contains("w001/t09 is not one of its 1 finished tasks") && done.contains("w001/t00"),
        "{done}"
    );
    let elsewhere = ["replay", "r", "--task", "w001/t00", "--suite", "vb-100", "--out", "x.html"];
    let done = bench.run(&elsewhere).error(3);
    assert!(done.contains("suite smoke of the run") && done.contains("--suite"), "{done}");
    let text = fs::read_to_string(bench.path("r/run.json")).expect("a header");
    bench.write("r/run.json", text.replace("\"schema\": 3", "\"schema\": 4"));
    let done = bench.run(&["report", "r", "--out", "page"]).error(3);
    assert!(done.contains("schema 4 is not supported"), "{done}");
    assert!(!bench.path("page/index.html").exists(), "nothing is left behind that looks like a report");
}
