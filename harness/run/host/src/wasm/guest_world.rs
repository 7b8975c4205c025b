//! What a planner's WASI functions work on: its clock, its randomness, its streams.

use vb_sdk::rng::Rng;

/// Sets WASI's random numbers apart from those that a planner makes of the same seed.
const STREAM: u64 = 0x5741_5349_2d72_6e67;

/// What WASI's functions work on.
#[derive(Debug)]
pub(super) struct Wasi {
    pub(super) rng: Rng,
    pub(super) time_ns: u64,
    /// Lines that haven't ended yet, of standard output and error.
    pub(super) out: Vec<u8>,
    pub(super) err: Vec<u8>,
    /// Standard error of the call so far, for the text of a panic, which spans lines.
    pub(super) report: Vec<u8>,
}

impl Wasi {
    pub(super) fn new(seed: u64) -> Self {
        let rng = Rng::new(seed ^ STREAM);
        Self { rng, time_ns: 0, out: Vec::new(), err: Vec::new(), report: Vec::new() }
    }

    /// Sets the clocks to simulated time, s, as a call begins.
    pub(super) fn set_time(&mut self, time: f64) {
        self.time_ns = (time * 1e9).round() as u64;
        self.report.clear();
    }

    pub(super) fn random(&mut self, count: usize) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(count + 7);
        while bytes.len() < count {
            bytes.extend(self.rng.next_u64().to_le_bytes());
        }
        bytes.truncate(count);
        bytes
    }
}
