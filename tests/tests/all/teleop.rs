//! Driving by hand, in a real browser. Without Chromium the tests say so and pass.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;

use vb_tests::{Bench, Browser, Watched};

/// A place to drive in, with its address.
fn serve(bench: &Bench) -> (Watched, String) {
    let args =
        ["dataset", "teleop", "--worlds", "1", "--tasks", "w001/t00-t01", "--no-browser", "--out", "d"];
    let mut serving = bench.watch(&args);
    let address = serving.until("serving")["address"].as_str().expect("an address").to_owned();
    (serving, address)
}

/// What a server answers to a request, up to its end or a second's silence.
fn answer(address: &str, path: &str, headers: &[&str]) -> String {
    let host = address.trim_start_matches("http://").split('/').next().expect("a host").to_owned();
    let mut stream = TcpStream::connect(&host).expect("a server");
    stream.set_read_timeout(Some(std::time::Duration::from_secs(1))).expect("a time-out");
    let own = format!("Host: {host}");
    let mut head = vec![format!("GET {path} HTTP/1.1")];
    if !headers.iter().any(|h| h.starts_with("Host:")) {
        head.push(own);
    }
    head.extend(headers.iter().map(|h| (*h).to_owned()));
    stream.write_all((head.join("\r\n") + "\r\n\r\n").as_bytes()).expect("sent");
    let mut text = Vec::new();
    let mut piece = [0; 4096];
    while let Ok(n @ 1..) = stream.read(&mut piece) {
        text.extend_from_slice(&piece[..n]);
        if text.len() > 1 << 20 {
            break;
        }
    }
    String::from_utf8_lossy(&text).into_owned()
}

#[test]
fn strangers_get_nothing() {
    let bench = Bench::new();
    let (serving, address) = serve(&bench);
    let path = format!("/{}", address.splitn(4, '/').nth(3).expect("a path"));
    let port = address.split([':', '/']).nth(4).expect("a port").to_owned();
    assert!(answer(&address, &path, &[]).starts_with("HTTP/1.1 200 OK"));
    // A wrong token, no token, another name for this machine, nonsense.
    assert!(answer(&address, "/00000000000000000000000000000000/", &[]).starts_with("HTTP/1.1 404"));
    assert!(answer(&address, "/", &[]).starts_with("HTTP/1.1 404"));
    assert!(answer(&address, &path, &["Host: evil.example"]).starts_with("HTTP/1.1 403"));
    assert!(answer(&address, &path, &[&format!("Host: evil.example:{port}")]).starts_with("HTTP/1.1 403"));
    // A page of another origin that knows the address, and one that doesn't say its origin.
    let drive = format!("{path}drive");
    let upgrade = [
        "Connection: Upgrade",
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
    ];
    let with = |origin: &str| answer(&address, &drive, &[&upgrade[..], &[origin]].concat());
    assert!(with("Origin: http://evil.example").starts_with("HTTP/1.1 403"));
    assert!(answer(&address, &drive, &upgrade).starts_with("HTTP/1.1 403"));
    // The key's answer is that of RFC 6455, section 1.3.
    let own = with(&format!("Origin: http://127.0.0.1:{port}"));
    assert!(own.starts_with("HTTP/1.1 101") && own.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{own}");
    let done = serving.interrupt();
    assert!(done.error(130).contains("without an episode"));
}

#[test]
fn keys_move_the_vehicle_and_what_is_driven_is_kept() {
    let Some(mut browser) = Browser::start(900, 600) else { return };
    let bench = Bench::new();
    let (mut serving, address) = serve(&bench);
    browser.open_url(&address);
    let wait = |browser: &mut Browser, what: &str, seconds: u32| {
        let until = format!(
            "new Promise(done => {{ const begun = performance.now(); const look = () => {what} ? done(true) \
             : performance.now() - begun > {seconds}000 ? done(false) : setTimeout(look, 20); look(); }})"
        );
        assert_eq!(browser.eval(&until), true, "{what}: {}", browser.eval("JSON.stringify(teleop.state)"));
    };
    let key = |browser: &mut Browser, kind: &str, code: &str| {
        browser.eval(&format!(
            "void dispatchEvent(new KeyboardEvent('{kind}', {{code: '{code}', bubbles: true}}))"
        ));
    };
    wait(&mut browser, "teleop.ready", 20);
    browser.eval("void document.querySelector('#start').click()");
    wait(&mut browser, "teleop.driving && teleop.state.length > 15", 20);
    // Throttle: it gets under way, as a vehicle does within some seconds.
    key(&mut browser, "keydown", "KeyW");
    wait(&mut browser, "teleop.state[8] > 1", 15);
    key(&mut browser, "keydown", "ArrowLeft");
    wait(&mut browser, "teleop.state[11] > 0.3", 10);
    assert!(browser.eval("teleop.frames").as_f64() > Some(1.0), "it draws");
    for code in ["KeyW", "ArrowLeft"] {
        key(&mut browser, "keyup", code);
    }
    // Time goes as the clock goes, or slower on a busy machine.
    let passed = browser.eval(
        "new Promise(done => { const [t, at] = [teleop.state[0], performance.now()]; \
         setTimeout(() => done((teleop.state[0] - t) / ((performance.now() - at) / 1000)), 1000); })",
    );
    assert!(passed.as_f64().is_some_and(|rate| rate > 0.1 && rate < 1.2), "{passed}");
    // Given up: it isn't kept.
    browser.eval("void document.querySelector('#reset').click()");
    assert_eq!(serving.until("episode")["episodes"], 0);
    wait(&mut browser, "!teleop.driving", 5);
    // Who closes the tab keeps what was driven.
    browser.eval("void document.querySelector('#start').click()");
    wait(&mut browser, "teleop.driving && teleop.state.length > 15 && teleop.state[0] < 2", 20);
    key(&mut browser, "keydown", "KeyW");
    wait(&mut browser, "teleop.state[8] > 1", 15);
    drop(browser);
    let episode = serving.until("episode");
    assert_eq!((&episode["outcome"], &episode["episodes"]), (&"ended".into(), &1.into()));
    // It is a whole dataset by now, whatever comes.
    serving.kill();
    bench.ok(&["dataset", "validate", "d"]);
    let card = std::fs::read_to_string(bench.path("d/README.md")).expect("a card");
    assert!(card.contains("driven by a person") && card.contains("can't be reproduced"), "{card}");
    // And more can be added, which stand still until the rules say that they are stuck.
    let args = [
        "dataset",
        "teleop",
        "--worlds",
        "1",
        "--tasks",
        "w001/t00-t01",
        "--no-browser",
        "--out",
        "d",
        "--resume",
    ];
    let mut serving = bench.watch(&args);
    let address = serving.until("serving")["address"].as_str().expect("an address").to_owned();
    let Some(mut browser) = Browser::start(900, 600) else { return };
    browser.open_url(&address);
    wait(&mut browser, "teleop.ready && teleop.kept === 1", 20);
    browser.eval("void document.querySelector('#start').click()");
    let episode = serving.until("episode");
    assert_eq!((&episode["outcome"], &episode["episodes"]), (&"stuck".into(), &2.into()));
    wait(&mut browser, "teleop.kept === 2 && !teleop.driving", 20);
    let done = serving.interrupt();
    assert_eq!(done.status.code(), Some(0), "{}", done.stderr);
    bench.ok(&["dataset", "validate", "d"]);
}
