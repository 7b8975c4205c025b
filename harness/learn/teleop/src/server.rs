//! The page's server: one page at a time, on this machine alone.

use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

use serde::Deserialize;
use tungstenite::handshake::server::create_response;
use tungstenite::http::{self, Request};
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, WebSocket};
use vb_files::lock;
use vb_sdk::Command;
use vb_trial::{numbered_gear, planner_gear};

use crate::wheel::Wheel;

/// The most bytes of a request's head.
const HEAD: usize = 16 << 10;
/// The most bytes of a message from the page.
const MESSAGE: usize = 4 << 10;
/// How long a browser may take to send its request, all in all.
const PATIENCE: Duration = Duration::from_secs(5);
/// Connections at a time: a browser opens some beside that of its page.
const CONNECTIONS: usize = 16;
/// How long the connection waits for the page before it looks for what is to be sent.
const LOOK: Duration = Duration::from_millis(2);

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TeleopError {
    #[error("cannot listen on port {port} of this machine: {source} (give another --port, or 0 for any)")]
    Listen { port: u16, source: std::io::Error },
    #[error("the system provides no random numbers for the page's address: {0}")]
    Random(getrandom::Error),
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
}

/// What the page asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ask {
    /// A page has connected, and waits for what there is to choose from.
    Hello,
    /// To drive this task, from its start.
    Start(String),
    /// To give up the drive, which is not kept.
    Reset,
    Gone,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum FromPage {
    /// Steering, throttle, brake, gear.
    Input(f64, f64, f64, i8),
    Start(String),
    Reset,
}

/// What the threads of the server share.
struct Shared {
    page: String,
    token: String,
    port: u16,
    wheel: Wheel,
    asks: mpsc::Sender<Ask>,
    /// Where what is to be sent goes; none without a page.
    out: Mutex<Option<mpsc::Sender<Out>>>,
    busy: AtomicBool,
    /// The number of connections that have a thread.
    connections: AtomicUsize,
}

enum Out {
    Text(String),
    Binary(Vec<u8>),
}

pub struct Server {
    shared: Arc<Shared>,
    asks: mpsc::Receiver<Ask>,
}

impl Server {
    /// Serves a page on a port of this machine; 0 for any.
    pub fn start(page: String, port: u16, wheel: Wheel) -> Result<Self, TeleopError> {
        let listen = |source| TeleopError::Listen { port, source };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(listen)?;
        let port = listener.local_addr().map_err(listen)?.port();
        let mut random = [0; 16];
        getrandom::fill(&mut random).map_err(TeleopError::Random)?;
        let token = random.iter().map(|b| format!("{b:02x}")).collect();
        let (asks, asked) = mpsc::channel();
        let (out, busy, connections) = (Mutex::default(), AtomicBool::new(false), AtomicUsize::new(0));
        let shared = Arc::new(Shared { page, token, port, wheel, asks, out, busy, connections });
        let own = Arc::clone(&shared);
        let accept = move || {
            for stream in listener.incoming().flatten() {
                let shared = Arc::clone(&own);
                // One that can't have a thread is let go.
                if let Some(place) = Place::take(shared) {
                    let _ = std::thread::Builder::new().spawn(move || place.0.serve(stream));
                }
            }
        };
        std::thread::Builder::new().spawn(accept).map_err(TeleopError::Thread)?;
        Ok(Self { shared, asks: asked })
    }

    /// The address of the page, which nobody can guess.
    #[must_use]
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.shared.port, self.shared.token)
    }

    /// What the page asks for next; `None` if it asked for nothing for a while.
    #[must_use]
    pub fn ask(&self, patience: Duration) -> Option<Ask> {
        self.asks.recv_timeout(patience).ok()
    }

    /// Sends JSON to the page.
    pub fn tell(&self, message: &serde_json::Value) {
        self.shared.send(Out::Text(message.to_string()));
    }

    #[must_use]
    pub fn motion(&self) -> Motion {
        Motion(Arc::clone(&self.shared))
    }
}

/// Where the motion of a drive goes: to the page, after all that it was told before.
#[derive(Clone)]
pub struct Motion(Arc<Shared>);

impl Motion {
    /// Sends numbers of 32 bits, little-endian; without a page they go nowhere.
    pub(crate) fn send(&self, values: &[f32]) {
        self.0.send(Out::Binary(values.iter().flat_map(|v| v.to_le_bytes()).collect()));
    }
}

/// A place among the connections, which is given back when it is dropped.
struct Place(Arc<Shared>);

impl Place {
    fn take(shared: Arc<Shared>) -> Option<Self> {
        // The place is there before it is counted, so that it is given back in any case.
        let place = Self(shared);
        (place.0.connections.fetch_add(1, Ordering::Relaxed) < CONNECTIONS).then_some(place)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::Relaxed);
    }
}

enum Wanted {
    Page,
    Drive(Box<Request<()>>),
    Nothing(&'static str),
}

impl Shared {
    fn send(&self, what: Out) {
        if let Some(out) = &*lock(&self.out) {
            let _ = out.send(what);
        }
    }

    fn serve(&self, mut stream: TcpStream) {
        let _ = stream.set_read_timeout(Some(PATIENCE));
        let _ = stream.set_write_timeout(Some(PATIENCE));
        let _ = stream.set_nodelay(true);
        if !stream.peer_addr().is_ok_and(|a: SocketAddr| a.ip().is_loopback()) {
            return;
        }
        let Some(head) = read_head(&mut stream) else { return };
        let wanted = self.wanted(&head);
        let mut answer = |status: &str, kind: &str, body: &str| {
            let text = format!(
                "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
                 Referrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
                 Content-Security-Policy: frame-ancestors 'none'\r\nX-Frame-Options: DENY\r\nConnection: close\r\n\r\n{body}",
                body.len()
            );
            let _ = stream.write_all(text.as_bytes());
        };
        match wanted {
            Wanted::Page => answer("200 OK", "text/html", &self.page),
            Wanted::Nothing(status) => answer(status, "text/plain", status),
            Wanted::Drive(request) => {
                if self.busy.swap(true, Ordering::Relaxed) {
                    answer("409 Conflict", "text/plain", "another tab is already driving");
                    return;
                }
                self.connected(stream, &request);
                *lock(&self.out) = None;
                self.busy.store(false, Ordering::Relaxed);
                let _ = self.asks.send(Ask::Gone);
            }
        }
    }

    /// What a request's head asks for. Whoever doesn't know the address, and pages of other origins, get nothing.
    fn wanted(&self, head: &[u8]) -> Wanted {
        const NOT_FOUND: &str = "404 Not Found";
        let mut headers = [httparse::EMPTY_HEADER; 64];
        let mut parsed = httparse::Request::new(&mut headers);
        if !parsed.parse(head).is_ok_and(|s| s.is_complete()) || parsed.method != Some("GET") {
            return Wanted::Nothing("400 Bad Request");
        }
        let header = |name: &str| {
            let found = parsed.headers.iter().find(|h| h.name.eq_ignore_ascii_case(name));
            found.map(|h| String::from_utf8_lossy(h.value).into_owned())
        };
        let hosts = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        // A name that another site has pointed here is refused as well.
        if !header("host").is_some_and(|host| hosts.contains(&host)) {
            return Wanted::Nothing("403 Forbidden");
        }
        let is_own = |origin: String| hosts.iter().any(|host| origin == format!("http://{host}"));
        match parsed.path.unwrap_or_default().strip_prefix(&format!("/{}/", self.token)) {
            Some("") => Wanted::Page,
            Some("drive") if !header("origin").is_some_and(is_own) => Wanted::Nothing("403 Forbidden"),
            Some("drive") => {
                let mut request =
                    Request::builder().method("GET").uri("/drive").version(http::Version::HTTP_11);
                for h in parsed.headers.iter() {
                    request = request.header(h.name, h.value);
                }
                request.body(()).map_or(Wanted::Nothing("400 Bad Request"), |r| Wanted::Drive(Box::new(r)))
            }
            _ => Wanted::Nothing(NOT_FOUND),
        }
    }

    /// Speaks with a page until it is gone.
    fn connected(&self, mut stream: TcpStream, request: &Request<()>) {
        let Ok(response) = create_response(request) else { return };
        let mut text = String::from("HTTP/1.1 101 Switching Protocols\r\n");
        for (name, value) in response.headers() {
            text += &format!("{name}: {}\r\n", value.to_str().unwrap_or_default());
        }
        if stream.write_all((text + "\r\n").as_bytes()).is_err() {
            return;
        }
        let _ = stream.set_read_timeout(Some(LOOK));
        let config = WebSocketConfig::default().max_message_size(Some(MESSAGE)).max_frame_size(Some(MESSAGE));
        let mut socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
        let (sender, receiver) = mpsc::channel();
        *lock(&self.out) = Some(sender);
        let _ = self.asks.send(Ask::Hello);
        loop {
            for out in receiver.try_iter() {
                let message = match out {
                    Out::Text(text) => Message::text(text),
                    Out::Binary(bytes) => Message::binary(bytes),
                };
                if socket.send(message).is_err() {
                    return;
                }
            }
            match socket.read() {
                Ok(Message::Text(text)) => {
                    if let Ok(message) = serde_json::from_str(&text) {
                        self.take(message);
                    }
                }
                Ok(Message::Close(_)) => return,
                Ok(_) => {}
                // Nothing has come yet.
                Err(tungstenite::Error::Io(e))
                    if matches!(e.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) => {}
                Err(_) => return,
            }
        }
    }

    fn take(&self, message: FromPage) {
        match message {
            FromPage::Input(steering, throttle, brake, gear) => {
                let gear = planner_gear(numbered_gear(f64::from(gear)));
                self.wheel.set(Command { steering, throttle, brake, gear, debug: Vec::new() });
            }
            FromPage::Start(task) => drop(self.asks.send(Ask::Start(task))),
            FromPage::Reset => drop(self.asks.send(Ask::Reset)),
        }
    }
}

#[allow(clippy::disallowed_methods, reason = "for patience with a browser: nothing of it reaches a score")]
fn now() -> Instant {
    Instant::now()
}

/// The head of a request, up to its empty line, if it comes in time.
fn read_head(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let end = now() + PATIENCE;
    let mut head = Vec::new();
    let mut byte = [0];
    // Byte by byte: what follows the head belongs to the connection.
    while !head.ends_with(b"\r\n\r\n") {
        let left = end.saturating_duration_since(now());
        // A timeout of 0 would be none.
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return None;
        }
        if head.len() == HEAD || stream.read(&mut byte).ok()? == 0 {
            return None;
        }
        head.push(byte[0]);
    }
    Some(head)
}
