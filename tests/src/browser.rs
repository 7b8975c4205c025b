//! Pages in a real browser: headless Chromium, spoken to by the DevTools protocol over its pipes.
//!
//! The protocol is JSON messages that end in a zero byte; the few commands that the tests need are no reason for a library
//! with a runtime of its own.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use base64::Engine as _;
use serde_json::{Value, json};

/// A browser with one page.
#[derive(Debug)]
pub struct Browser {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    sent: u64,
    session: Option<String>,
    /// What the page's console said of errors.
    errors: Vec<String>,
    loaded: bool,
    _profile: tempfile::TempDir,
}

/// Pixels of a screenshot, RGB or RGBA.
#[derive(Debug)]
pub struct Picture {
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Share of the pixels that don't have the most frequent colour, in [0, 1]: 0 for a blank page.
    #[must_use]
    pub fn content(&self) -> f64 {
        let mut sorted = self.pixels.clone();
        sorted.sort_unstable();
        let most = sorted.chunk_by(|a, b| a == b).map(<[_]>::len).max().unwrap_or(0);
        1.0 - most as f64 / sorted.len() as f64
    }

    /// Mean brightness, 0 to 255.
    #[must_use]
    pub fn brightness(&self) -> f64 {
        let sum: u64 = self.pixels.iter().flatten().map(|&c| u64::from(c)).sum();
        sum as f64 / (3 * self.pixels.len()) as f64
    }
}

/// The browser's program: `VB_BROWSER`, or what Debian and others call it.
fn program() -> Option<String> {
    if let Ok(program) = std::env::var("VB_BROWSER") {
        return Some(program);
    }
    let runs = |p: &str| {
        let mut command = Command::new(p);
        command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|s| s.success())
    };
    ["chromium", "chromium-browser", "google-chrome", "chrome"]
        .into_iter()
        .find(|p| runs(p))
        .map(str::to_owned)
}

fn address(file: &Path) -> String {
    format!("file://{}", std::path::absolute(file).unwrap().display())
}

impl Browser {
    /// Starts a browser with a window of this size; says so and gives none where there is no browser.
    #[must_use]
    pub fn start(width: u32, height: u32) -> Option<Self> {
        Self::launch(width, height, &["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
    }

    /// The same, of a browser whose pages have no WebGL.
    #[must_use]
    pub fn start_without_webgl(width: u32, height: u32) -> Option<Self> {
        Self::launch(width, height, &["--disable-gpu", "--disable-3d-apis"])
    }

    fn launch(width: u32, height: u32, graphics: &[&str]) -> Option<Self> {
        let Some(program) = program() else {
            vb_testing::skip("no Chromium (install it, or set VB_BROWSER)");
            return None;
        };
        let profile = tempfile::tempdir().unwrap();
        // The browser reads from its descriptor 3 and writes to 4.
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1", &program]);
        command.args([
            "--headless",
            "--no-sandbox",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--remote-debugging-pipe",
        ]);
        command.args(graphics);
        command.arg(format!("--window-size={width},{height}"));
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let input = child.stdin.take().unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let mut browser = Self {
            child,
            input,
            output,
            sent: 0,
            session: None,
            errors: Vec::new(),
            loaded: false,
            _profile: profile,
        };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let session =
            browser.call("Target.attachToTarget", json!({"targetId": target["targetId"], "flatten": true}));
        browser.session = session["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    /// Sends a command and returns its result.
    fn call(&mut self, method: &str, params: Value) -> Value {
        self.sent += 1;
        let id = self.sent;
        let mut message = json!({"id": id, "method": method, "params": params});
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        self.input.write_all(format!("{message}\0").as_bytes()).unwrap();
        self.input.flush().unwrap();
        loop {
            let answer = self.read();
            if answer["id"] == id {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
        }
    }

    /// The next message; what it tells of the page is noted.
    fn read(&mut self) -> Value {
        let mut bytes = Vec::new();
        self.output.read_until(0, &mut bytes).unwrap();
        assert_eq!(bytes.pop(), Some(0), "the browser ended");
        let message: Value = serde_json::from_slice(&bytes).unwrap();
        let p = &message["params"];
        match message["method"].as_str() {
            Some("Page.loadEventFired") => self.loaded = true,
            Some("Runtime.exceptionThrown") => self.errors.push(p["exceptionDetails"].to_string()),
            Some("Runtime.consoleAPICalled") if p["type"] == "error" => {
                self.errors.push(p["args"].to_string())
            }
            Some("Log.entryAdded") if p["entry"]["level"] == "error" => {
                self.errors.push(p["entry"]["text"].to_string());
            }
            _ => {}
        }
        message
    }

    /// Opens a file and waits until it is loaded.
    pub fn open(&mut self, file: &Path) {
        self.open_url(&address(file));
    }

    /// Opens a file anew at a fragment of its address, such as `#t=3`, and waits until it is loaded.
    pub fn open_at(&mut self, file: &Path, fragment: &str) {
        // From another page: a change of the fragment alone would load nothing.
        self.open_url("about:blank");
        self.open_url(&format!("{}{fragment}", address(file)));
    }

    /// Opens a page by its address and waits until it has loaded.
    pub fn open_url(&mut self, url: &str) {
        self.loaded = false;
        let result = self.call("Page.navigate", json!({"url": url}));
        assert!(result["errorText"].is_null(), "{url}: {result}");
        while !self.loaded {
            self.read();
        }
    }

    /// Waits until the page has loaded that something done to the present one leads to.
    pub fn wait_for_page(&mut self, act: impl FnOnce(&mut Self)) {
        self.loaded = false;
        act(self);
        while !self.loaded {
            self.read();
        }
    }

    /// The value of an expression in the page; a promise is waited for.
    pub fn eval(&mut self, expression: &str) -> Value {
        let params = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let result = self.call("Runtime.evaluate", params);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {result}");
        result["result"]["value"].clone()
    }

    /// Presses the mouse at the middle of the first element that a selector finds.
    pub fn click(&mut self, selector: &str) {
        let script = format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{block: 'center'}}); \
             const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()"
        );
        let at = self.eval(&script);
        self.mouse(at[0].as_f64().unwrap(), at[1].as_f64().unwrap());
    }

    /// Presses and releases the mouse at a point of the window.
    pub fn mouse(&mut self, x: f64, y: f64) {
        for kind in ["mousePressed", "mouseReleased"] {
            let params =
                json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1});
            self.call("Input.dispatchMouseEvent", params);
        }
    }

    /// Presses the mouse at a point of the window, moves it to another and releases it.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        for (kind, [x, y]) in [("mousePressed", from), ("mouseMoved", to), ("mouseReleased", to)] {
            let params =
                json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1});
            self.call("Input.dispatchMouseEvent", params);
        }
    }

    /// Turns the mouse's wheel at a point of the window by so many pixels, downwards if positive.
    pub fn scroll(&mut self, [x, y]: [f64; 2], by: f64) {
        let params = json!({"type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": by});
        self.call("Input.dispatchMouseEvent", params);
    }

    /// Presses and releases a key, by the name that a page sees: `a`, `?`, `ArrowLeft`.
    pub fn press(&mut self, key: &str) {
        let mut down = json!({"type": "keyDown", "key": key});
        if key.chars().count() == 1 {
            down["text"] = key.into();
        }
        self.call("Input.dispatchKeyEvent", down);
        self.call("Input.dispatchKeyEvent", json!({"type": "keyUp", "key": key}));
    }

    /// Types text into what has the focus.
    pub fn type_text(&mut self, text: &str) {
        self.call("Input.insertText", json!({"text": text}));
    }

    /// Whether the page shall be dark.
    pub fn prefer_dark(&mut self, dark: bool) {
        let value = if dark { "dark" } else { "light" };
        let features = json!([{"name": "prefers-color-scheme", "value": value}]);
        self.call("Emulation.setEmulatedMedia", json!({"features": features}));
    }

    /// Shows the page as a phone of this size does.
    pub fn phone(&mut self, width: u32, height: u32) {
        let metrics = json!({"width": width, "height": height, "deviceScaleFactor": 2, "mobile": true});
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    /// What the window shows. On a busy machine the browser may give a frame on which nothing has been painted yet: then it is asked
    /// again.
    pub fn screenshot(&mut self) -> Picture {
        let blank = |picture: &Picture| picture.content() == 0.0;
        (0..5).map(|_| self.frame()).find(|picture| !blank(picture)).unwrap_or_else(|| self.frame())
    }

    /// What the window shows in this moment.
    fn frame(&mut self) -> Picture {
        // What has just changed is painted with the next frame, which takes its time on a busy machine.
        self.eval(
            "Promise.race([new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(0)))), \
             new Promise(done => setTimeout(() => done(0), 2000))])",
        );
        let data = self.call("Page.captureScreenshot", json!({"format": "png"}));
        let bytes = base64::engine::general_purpose::STANDARD.decode(data["data"].as_str().unwrap()).unwrap();
        // For people who look at what the tests see.
        if let Some(dir) = std::env::var_os("VB_SCREENSHOTS") {
            std::fs::write(Path::new(&dir).join(format!("{}.png", self.sent)), &bytes).unwrap();
        }
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        let channels = info.color_type.samples();
        assert!(channels >= 3, "{info:?}");
        let pixels = data[..info.buffer_size()].chunks_exact(channels).map(|p| [p[0], p[1], p[2]]).collect();
        Picture { pixels }
    }

    /// Errors that the page's console told so far.
    #[must_use]
    pub fn errors(&self) -> &[String] {
        &self.errors
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
