//! Replays in a real browser. Without Chromium the tests say so and pass.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use vb_tests::{Bench, Browser, pid, root};

use crate::pages::run;

/// A promise that is kept after so many milliseconds: the page writes its address after a while.
fn rest(milliseconds: u32) -> String {
    format!("new Promise(done => setTimeout(done, {milliseconds}))")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().filter_map(Value::as_f64).collect()
}

fn number(browser: &mut Browser, what: &str) -> f64 {
    browser.eval(what).as_f64().unwrap_or_else(|| panic!("no number: {what}"))
}

/// A replay of one task on soft ground, driven at 5 and at 3 m/s: wheels leave ruts.
/// The page lies in the folder that is given with it, and stays as long as that.
fn fast_and_slow() -> (Bench, PathBuf) {
    let bench = Bench::new();
    run(&bench, "a", "5", "w007/t02");
    run(&bench, "b", "3", "w007/t02");
    bench.ok(&["replay", "a", "b", "--task", "w007/t02", "--out", "replay.html"]);
    let page = bench.path("replay.html");
    (bench, page)
}

#[test]
fn a_replay_shows_what_the_sensors_measured_where_the_ground_is() {
    let Some(mut browser) = Browser::start(1280, 900) else { return };
    let bench = Bench::new();
    let pid = pid();
    let pid = pid.to_str().expect("paths of tests are text");
    bench.ok(&["--plugin", pid, "--suite", "smoke", "--tasks", "w001/t03", "--out", "run"]);
    // The planner had neither: what would they have seen?
    bench.ok(&[
        "replay",
        "run",
        "--task",
        "w001/t03",
        "--sensors",
        "lidar,depth,local-map",
        "--out",
        "r.html",
    ]);
    browser.open(&bench.path("r.html"));
    browser.eval("replay.seek(5)");
    let mut number = |what: &str| number(&mut browser, what);
    assert!(number("replay.sensed().points") > 1000.0);
    assert!(number("replay.sensed().cells") > 1000.0);
    assert_eq!(number("Number(replay.sensed().depth)"), 1.0);
    // Points lie on the ground, but for those on obstacles and the lift that keeps them in sight.
    let off = "(() => { const n = replay.sensed().points; let near = 0; for (let k = 0; k < n; k += 1) { \
        const [x, y, z] = replay.sensed().point(k); if (Math.abs(z - replay.height(x, y)) < 0.12) near += 1; } return near / n; })()";
    let near = number(off);
    assert!(near > 0.9, "{near}");
    assert_eq!(number("(document.querySelector('input[name=lidar]').click(), replay.sensed().points)"), 0.0);
    let extent = "[...replay.obstacles().map(a => a.length / 9), ...[0, 1].flatMap(axis => { const all = \
        replay.obstacles().flat().filter((_, k) => k % 3 === axis); return [Math.min(...all), Math.max(...all)]; })]";
    let extent = numbers(&browser.eval(extent));
    // Obstacles are where the suite has them: the same outline from above, to half a unit of 0.2 mm and what f32 holds of 64 m.
    let suite = vb_world::Suite::open(root().join("tasks/smoke")).expect("the suite");
    let world = suite.load_world("w001").expect("a world");
    let outline: Vec<[f64; 2]> = world.obstacles.iter().flat_map(vb_world::Obstacle::footprint).collect();
    for (axis, seen) in extent[2..].chunks(2).enumerate() {
        let least = outline.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let most = outline.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        assert!(
            (seen[0] - least).abs() < 1.2e-4 && (seen[1] - most).abs() < 1.2e-4,
            "{extent:?} {least} {most}"
        );
    }
    // A body of n points and triangles alone has 2n − 4 of these.
    let trunk = |o: &&vb_world::Obstacle| matches!(o.kind, vb_world::ObstacleKind::Trunk { .. });
    let stones = world.obstacles.iter().filter(|o| !trunk(o)).count();
    assert!(stones > 0 && extent[0] >= 4.0 * stones as f64 && extent[1] > 0.0, "{extent:?}");

    // What is shown of the sensors is in the address, and is shown again by it.
    browser.eval(&rest(700));
    assert_eq!(browser.eval("location.hash"), "#t=5&view=follow&hide=lidar");
    let state = "JSON.stringify([replay.sensed().points > 0, replay.sensed().cells > 0, replay.sensed().depth, replay.sensed().labels, \
                 document.querySelector('#trail').value])";
    assert_eq!(browser.eval(state), "[false,true,true,true,\"speed\"]");
    browser.press("m");
    browser.eval("document.querySelector('#depth').click()");
    browser.press("t");
    browser.eval(&rest(700));
    let fragment = browser.eval("location.hash").as_str().expect("text").to_owned();
    assert_eq!(fragment, "#t=5&view=follow&trail=roll&hide=lidar,map&depth=distance");
    browser.open_at(&bench.path("r.html"), "#t=5");
    assert_eq!(browser.eval(state), "[true,true,true,true,\"speed\"]");
    browser.open_at(&bench.path("r.html"), &fragment);
    assert_eq!(browser.eval(state), "[false,false,true,false,\"roll\"]");
    // An address that a person changes is obeyed; names of nothing hide nothing, and what is hidden is what it says.
    browser.eval("location.hash = '#hide=depth,nothing&depth=kinds&trail=nothing'");
    browser.eval(&rest(100));
    assert_eq!(browser.eval(state), "[true,true,false,true,\"roll\"]");
    browser.eval("location.hash = '#hide='");
    browser.eval(&rest(100));
    assert_eq!(browser.eval(state), "[true,true,true,true,\"roll\"]");
    assert_eq!(browser.errors(), [] as [String; 0]);
    let e = bench.run(&["replay", "run", "--task", "w001/t03", "--sensors", "radar", "--out", "x.html"]);
    assert!(e.error(2).contains("unknown sensor `radar`"));
}

#[test]
fn a_replay_moves_the_vehicle_with_the_slider_and_plays() {
    let Some(mut browser) = Browser::start(1280, 800) else { return };
    let (bench, page) = fast_and_slow();
    browser.open(&page);
    assert_eq!(browser.eval("document.querySelector('#task').textContent"), "w007/t02");
    assert_eq!(browser.eval("document.querySelectorAll('#runs li').length"), 2);
    let position = "JSON.stringify(replay.position())";
    let wheel = "JSON.stringify(replay.wheel(0))";
    let (at_start, wheel_at_start) = (browser.eval(position), browser.eval(wheel));
    let first = browser.screenshot();
    assert!(first.content() > 0.3, "a view without content: {}", first.content());

    let track = browser.eval("(() => { const b = document.querySelector('#slider').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()");
    let track: Vec<f64> =
        track.as_array().expect("a box").iter().filter_map(serde_json::Value::as_f64).collect();
    browser.mouse(track[0] + 0.5 * track[2], track[1] + 0.5 * track[3]);
    let time = browser.eval("replay.time").as_f64().expect("a time");
    let end = browser.eval("replay.end").as_f64().expect("a time");
    assert!((time - 0.5 * end).abs() < 0.05 * end, "{time} of {end}");
    assert_ne!(browser.eval(position), at_start, "the vehicle moves");
    assert_ne!(browser.eval(wheel), wheel_at_start, "its wheels turn");
    // The trace's own position at that time.
    let moved: Vec<f64> =
        serde_json::from_str(browser.eval(position).as_str().expect("text")).expect("numbers");
    let rows = bench.parquet("a/traces/w007/t02.parquet");
    let near = rows.iter().min_by(|p, q| {
        let far = |r: &serde_json::Value| (r["time"].as_f64().unwrap_or(f64::MAX) - time).abs();
        far(p).total_cmp(&far(q))
    });
    let near = near.expect("samples");
    let far = |k: usize, name: &str| (moved[k] - near[name].as_f64().expect("a number")).abs();
    assert!(far(0, "x") < 0.4 && far(1, "y") < 0.4 && far(2, "z") < 0.2, "{moved:?} {near}");

    // Software rendering may take its time for a frame.
    let plays = "new Promise(done => { const from = replay.time, begun = performance.now(); \
        const look = () => replay.time > from + 0.2 ? done(true) : performance.now() - begun > 30000 ? done(false) \
        : setTimeout(look, 20); look(); })";
    browser.eval("replay.seek(1)");
    browser.click("#play");
    assert_eq!(browser.eval(plays), true, "it plays");
    browser.click("#play");
    for camera in ["chase", "cockpit", "top", "world", "follow"] {
        browser.click(&format!("#camera button[value={camera}]"));
        assert!(browser.screenshot().content() > 0.3, "{camera}");
    }
    browser.eval("replay.seek(replay.end)");
    assert_eq!(browser.eval("document.querySelector('#banner').hidden"), false, "how it ended is said");
    // Where it stands at the start it has sunk in already.
    let ruts = browser.eval("replay.ruts().cells").as_f64().expect("a number");
    browser.eval("replay.seek(0)");
    let at_start = browser.eval("replay.ruts().cells").as_f64().expect("a number");
    assert!(ruts > 500.0 && at_start < 0.2 * ruts, "wheels leave ruts: {at_start} {ruts}");
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn the_top_view_of_a_replay_is_a_map_and_the_address_says_what_is_seen() {
    let Some(mut browser) = Browser::start(1280, 800) else { return };
    let (_bench, page) = fast_and_slow();
    browser.open_at(&page, "#t=12.5&run=2&view=top&at=3,-4&span=30");
    let seen = "[replay.time, replay.followed, replay.map().span, ...replay.map().at.slice(0, 2)]";
    let near =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.01);
    let first = numbers(&browser.eval(seen));
    assert!(near(&first, &[12.5, 1.0, 30.0, 3.0, -4.0]), "{first:?}");
    assert_eq!(browser.eval("replay.map().camera"), "OrthographicCamera");
    // A map: ten metres to the north are straight up, as long as ten metres to the east, wherever and however high.
    let tall = number(&mut browser, "document.querySelector('#view').clientHeight");
    for (x, y, z) in [(0.0, 0.0, 0.0), (9.0, -8.0, 3.0)] {
        let mut at = |x: f64, y: f64| numbers(&browser.eval(&format!("replay.project({x}, {y}, {z})")));
        let (here, north, east) = (at(x, y), at(x, y + 10.0), at(x + 10.0, y));
        let length = 10.0 / 30.0 * tall;
        assert!((north[0] - here[0]).abs() < 0.01 && (here[1] - north[1] - length).abs() < 0.01);
        assert!((east[1] - here[1]).abs() < 0.01 && (east[0] - here[0] - length).abs() < 0.01);
    }
    // The bar of the scale is as long as it says.
    let bar = number(&mut browser, "document.querySelector('#map-bar').getBoundingClientRect().width");
    let told = browser.eval("document.querySelector('#map-length').textContent");
    let metres: f64 =
        told.as_str().and_then(|t| t.strip_suffix(" m")).expect("metres").parse().expect("a number");
    assert!((bar - metres / 30.0 * tall).abs() < 1.0, "{bar} px for {told}");
    let north = "document.querySelector('#map svg').getBoundingClientRect().height > 20";
    assert_eq!(browser.eval(north), true);

    // The map is dragged and zoomed, and stays when time goes on; the address follows without new entries of the history.
    let entries = browser.eval("history.length");
    browser.drag([600.0, 400.0], [700.0, 400.0]);
    let moved = numbers(&browser.eval(seen));
    assert!(near(&moved, &[12.5, 1.0, 30.0, 3.0 - 100.0 * 30.0 / tall, -4.0]), "{moved:?}");
    browser.scroll([600.0, 400.0], -300.0);
    browser.eval(&rest(100));
    assert!(number(&mut browser, "replay.map().span") < 29.0, "it is nearer");
    browser.press("ArrowRight");
    browser.press("d");
    let last = numbers(&browser.eval(seen));
    assert!((last[0] - 12.6).abs() < 1e-9 && last[3] > moved[3], "{last:?}");
    for _ in 0..30 {
        browser.press("ArrowRight");
    }
    browser.eval(&rest(700));
    let last = numbers(&browser.eval(seen));
    let fragment = browser.eval("location.hash");
    let fragment = fragment.as_str().expect("text").to_owned();
    assert!(fragment.starts_with("#t=15.6&run=2&view=top&at="), "{fragment}");
    assert_eq!(browser.eval("history.length"), entries);
    browser.open_at(&page, &fragment);
    let again = numbers(&browser.eval(seen));
    assert!(near(&again, &last), "{again:?} {last:?}");
    // Back on the vehicle.
    browser.press("c");
    assert_eq!(browser.eval("replay.map().free"), false);
    let off =
        "Math.hypot(replay.map().at[0] - replay.position(1)[0], replay.map().at[1] - replay.position(1)[1])";
    assert!(number(&mut browser, off) < 1e-6);

    // An address that a person changes is obeyed, and one without sense is not.
    browser.eval("location.hash = '#t=3&run=1&view=follow&eye=-5,4,3&aim=0,0,0'");
    browser.eval(&rest(100));
    assert_eq!(browser.eval("[replay.time, replay.followed, replay.view].join()"), "3,0,follow");
    browser.open_at(&page, "#t=x&run=9&view=nowhere&at=1");
    assert_eq!(browser.eval("[replay.time, replay.followed, replay.view].join()"), "0,0,follow");
    assert_eq!(browser.eval("document.querySelector('#map').hidden"), true, "no scale in perspective");
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn a_replay_digs_its_ruts_and_its_links_follow_the_wheels() {
    let Some(mut browser) = Browser::start(1000, 700) else { return };
    let bench = Bench::new();
    let pid = pid();
    let pid = pid.to_str().expect("paths of tests are text");
    // Double wishbones on soil; steered beams; arms and a belt.
    for (vehicle, task, rods) in
        [("hmmwv", "w007/t02", 16), ("man5t", "w007/t02", 8), ("m113", "w007/t02", 0)]
    {
        bench.ok(&[
            "--plugin",
            pid,
            "--suite",
            "smoke",
            "--vehicle",
            vehicle,
            "--tasks",
            task,
            "--out",
            vehicle,
        ]);
        let file = format!("{vehicle}.html");
        bench.ok(&["replay", vehicle, "--task", task, "--out", &file]);
        browser.open(&bench.path(&file));
        // Rods are rigid: their lengths are those of the file, whatever the wheels do.
        let worst = "(() => { let worst = 0; for (let t = 0; t < replay.end; t += 0.5) { replay.seek(t); \
            for (const [is, was] of replay.rods()) worst = Math.max(worst, Math.abs(is - was)); } return worst; })()";
        assert_eq!(browser.eval("replay.rods().length"), rods, "{vehicle}");
        let worst = number(&mut browser, worst);
        // Beams are interpolated between solved travels, which costs millimetres.
        assert!(worst < 0.004, "{vehicle}: a rod is {worst} m too long or too short");
        if vehicle == "m113" {
            // The pivot of the first road wheel's arm by its file, which the hull holds.
            let pivots = browser.eval("replay.bars().filter(([role]) => role === 'spoke').map(([, a]) => a)");
            let pivots = pivots.as_array().expect("bars");
            let held = |p: &Value| {
                let wanted = [1.3335 + 0.288, 0.9595, 0.134];
                numbers(p).iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3)
            };
            assert!(pivots.iter().any(held), "{pivots:?}");
        }
        // The mesh itself sinks, as time goes on, and is whole again at the start.
        let sunk = "(replay.seek(replay.end), replay.ruts().sunk)";
        let (end, start) =
            (number(&mut browser, sunk), number(&mut browser, "(replay.seek(0), replay.ruts().sunk)"));
        assert!(end > 0.05 && start < end, "{vehicle}: {start} m, {end} m");
        let told = browser.eval("document.querySelector('#rut-end').textContent");
        let scale: f64 =
            told.as_str().and_then(|t| t.strip_suffix(" cm")).expect("cm").parse().expect("a number");
        assert!(100.0 * end <= scale + 1e-3, "the scale {told} ends at the deepest rut, {end} m");
        browser.press("f");
        assert_eq!(number(&mut browser, "(replay.seek(replay.end), replay.ruts().sunk)"), 0.0);
        browser.press("f");
        // A row an axle, with two wheels; together they bear the vehicle on the first frame, which stands.
        browser.eval("replay.seek(0)");
        let loads = "[...document.querySelectorAll('.wheel output')].map(e => parseFloat(e.title))";
        let loads = numbers(&browser.eval(loads));
        assert_eq!(loads.len() as f64, number(&mut browser, "2 * document.querySelectorAll('.axle').length"));
        let sum: f64 = loads.iter().sum();
        assert!((sum - 100.0).abs() < 3.0, "{vehicle}: {loads:?}");
    }
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn all_of_a_replay_is_reached_by_keys_that_a_question_mark_lists() {
    let Some(mut browser) = Browser::start(1280, 800) else { return };
    let (_bench, page) = fast_and_slow();
    browser.open(&page);
    browser.press("?");
    assert_eq!(browser.eval("document.querySelector('#help').open"), true);
    let listed =
        browser.eval("[...document.querySelectorAll('#key-list kbd')].map(e => e.textContent).join(' ')");
    let listed = listed.as_str().expect("text");
    for key in ["space", "←", "home", "<", "1", "5", "w", "+", "c", "t", "r", "n", "u", "?"] {
        assert!(listed.split(' ').any(|k| k == key), "{key} is not among {listed}");
    }
    browser.press("?");
    assert_eq!(browser.eval("document.querySelector('#help').open"), false);

    for (key, view) in ["follow", "chase", "cockpit", "top", "world"].into_iter().enumerate() {
        browser.press(&(key + 1).to_string());
        assert_eq!(browser.eval("replay.view"), view);
        assert_eq!(browser.eval("document.querySelector('#camera [aria-pressed=true]').value"), view);
    }
    browser.press("r");
    assert_eq!(browser.eval("replay.followed"), 1);
    assert_eq!(
        browser.eval("document.querySelector('#runs [aria-current=true] span').textContent"),
        "pid (speed 3)"
    );
    browser.press("End");
    assert_eq!(browser.eval("replay.time === replay.end"), true);
    browser.press("Home");
    browser.press(".");
    assert!((number(&mut browser, "replay.time") - 0.02).abs() < 1e-6, "a frame");
    browser.press(">");
    assert_eq!(browser.eval("document.querySelector('#speed').value"), "2");
    browser.press("t");
    assert_eq!(browser.eval("document.querySelector('#trail').value"), "roll");
    browser.press(" ");
    assert_eq!(browser.eval("replay.paused"), false);
    browser.press(" ");
    assert_eq!(browser.eval("replay.paused"), true);
    // Each box that is there says its key, is listed, and is turned by it.
    let boxes = browser.eval(
        "[...document.querySelectorAll('#toggles label:not([hidden])')].map(e => [e.title.at(-2), e.querySelector('input').name])",
    );
    let boxes = boxes.as_array().expect("boxes");
    assert!(boxes.len() >= 7, "{boxes:?}");
    for pair in boxes {
        let (key, name) = (pair[0].as_str().expect("a key"), pair[1].as_str().expect("a name"));
        assert!(listed.split(' ').any(|k| k == key), "{name} by {key} is not among {listed}");
        let checked = format!("document.querySelector('input[name={name}]').checked");
        browser.press(key);
        assert_eq!(browser.eval(&checked), false, "{name} by {key}");
        browser.press(key);
        assert_eq!(browser.eval(&checked), true, "{name} by {key}");
    }
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn a_replay_without_webgl_says_so_and_tells_all_else() {
    let Some(mut browser) = Browser::start_without_webgl(1280, 800) else { return };
    let bench = Bench::new();
    // It gets stuck.
    run(&bench, "a", "5", "w003/t01");
    bench.ok(&["replay", "a", "--task", "w003/t01", "--out", "replay.html"]);
    let page = bench.path("replay.html");
    for (width, dark) in [(1280, false), (390, true)] {
        browser.phone(width, 844);
        browser.prefer_dark(dark);
        browser.open_at(&page, "#t=3");
        let message = "(() => { const e = document.querySelector('#without'), b = e.getBoundingClientRect(); \
            return b.width > 200 && b.height > 80 && b.left >= 0 && b.right <= innerWidth ? e.innerText : ''; })()";
        let message = browser.eval(message);
        let message = message.as_str().expect("text");
        assert!(
            message.contains("WebGL 2") && message.contains("hardware acceleration"),
            "{width}: {message:?}"
        );
        assert_eq!(browser.eval("document.querySelector('#time').textContent.startsWith('3.00 /')"), true);
        // The curves are drawn: the plot of the speed has colours.
        let drawn = "(() => { const c = document.querySelector('#plots canvas'); \
            return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(v => v > 0); })()";
        assert_eq!(browser.eval(drawn), true, "{width}");
        let facts = browser.eval("document.querySelector('#facts').textContent");
        let facts = facts.as_str().expect("text");
        for text in ["stuck", "moved less than 1 m within 10 s", "hmmwv", "1:1", "paper"] {
            assert!(facts.contains(text), "{text} is not in {facts}");
        }
        assert_eq!(browser.eval("document.documentElement.scrollWidth <= innerWidth"), true, "{width}");
    }
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn replays_of_a_report_lead_to_their_neighbours_and_back_to_the_row() {
    let Some(mut browser) = Browser::start(1280, 800) else { return };
    let bench = Bench::new();
    run(&bench, "a", "5", "w001/t00-t02,w002/t03");
    bench.ok(&["report", "a", "--out", "page", "--replays", "w001/t00,w001/t02,w002/t03"]);
    browser.open(&bench.path("page/replays/w001/t02.html"));
    let links = "[...document.querySelectorAll('#links a')].map(a => a.getAttribute('href')).join(' ')";
    assert_eq!(
        browser.eval(links),
        "../../index.html#task=w001/t02 ../w001/t00.html ../w002/t03.html",
        "t01 has no replay"
    );
    browser.wait_for_page(|b| b.press("n"));
    assert_eq!(browser.eval("document.querySelector('#task').textContent"), "w002/t03");
    assert_eq!(browser.eval("document.querySelector('#next')"), Value::Null, "it is the last one");
    browser.wait_for_page(|b| b.press("p"));
    browser.wait_for_page(|b| b.click("#previous"));
    assert_eq!(browser.eval("document.querySelector('#task').textContent"), "w001/t00");
    assert_eq!(browser.eval("document.querySelector('#previous')"), Value::Null, "it is the first one");
    browser.wait_for_page(|b| b.press("u"));
    let rows = "[...document.querySelectorAll('#browser tbody tr')].map(r => r.textContent).join(' ')";
    let rows = browser.eval(rows);
    let rows = rows.as_str().expect("text");
    assert!(rows.contains("w001/t00") && !rows.contains("w001/t02"), "the task's own row: {rows}");
    browser.wait_for_page(|b| b.click("a.replay"));
    assert_eq!(browser.eval("document.querySelector('#task').textContent"), "w001/t00");
    assert_eq!(browser.errors(), [] as [String; 0]);

    // Pages of a report have one script; a page that was parted from it says what it needs, and one by itself has all it needs.
    assert!(bench.path("page/replays/replay.js").is_file());
    fs::rename(bench.path("page/replays/replay.js"), bench.path("replay.js")).unwrap();
    browser.open(&bench.path("page/replays/w001/t02.html"));
    let told = browser.eval("document.querySelector('#alone').textContent");
    assert!(told.as_str().is_some_and(|t| t.contains("needs the file replay.js")), "{told}");
    // That leads nowhere.
    bench.ok(&["replay", "a", "--task", "w001/t01", "--out", "alone.html"]);
    browser.open(&bench.path("alone.html"));
    assert_eq!(browser.eval("document.querySelector('#links').hidden"), true);
}
