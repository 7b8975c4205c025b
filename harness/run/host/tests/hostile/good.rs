//! Planners that do their work, and what they do when they are alone.

use std::path::Path;
use std::sync::OnceLock;

use vb_host::{FuelMeter, Limits, Plugin, Session};
use vb_sdk::{LogLevel, Observation};

use crate::common::{self, keeper};
use crate::{options, wasm};

/// Steps of a good planner's task.
pub const STEPS: u32 = 10;

/// All that the harness learns from a planner: the bits of its commands, its log and its fuel.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    commands: Vec<[u64; 3]>,
    lines: Vec<(LogLevel, String)>,
    fuel: Option<FuelMeter>,
}

/// A planner that does its work.
pub struct Good {
    plugin: Plugin,
    /// Its record from a plugin loaded for nothing else.
    pub alone: Record,
}

pub struct AtWork {
    session: Session,
    lines: common::Lines,
    commands: Vec<[u64; 3]>,
}

impl Good {
    /// Two different ones for each kind there is here, with a state in memory and a line in the log every step.
    pub fn planners() -> &'static [Good] {
        static PLANNERS: OnceLock<Vec<Good>> = OnceLock::new();
        let make = || {
            let kinds =
                [(in_wasm as fn(f64) -> Option<Plugin>, 0.5), (in_wasm, 0.25), (in_c, 0.5), (in_c, 0.25)];
            kinds.into_iter().filter_map(|(load, part)| Good::new(load, part)).collect()
        };
        PLANNERS.get_or_init(make)
    }

    fn new(load: fn(f64) -> Option<Plugin>, part: f64) -> Option<Self> {
        let alone = begin(&load(part)?).finish();
        // The definition of the planner, in f64 as it is there.
        let mut sum = 0.0;
        let expected = (0..STEPS).map(|i| {
            sum = sum * part + f64::from(i) * 0.1;
            [sum, f64::from(i + 1), 0.0].map(f64::to_bits)
        });
        assert_eq!(alone.commands, expected.collect::<Vec<_>>());
        Some(Self { plugin: load(part)?, alone })
    }

    /// Whether native planners here are held by seccomp.
    pub fn seccomp() -> bool {
        Self::planners().iter().any(|good| good.plugin.sandbox().is_some_and(|report| report.seccomp))
    }

    pub fn begin(&self) -> AtWork {
        begin(&self.plugin)
    }
}

fn begin(plugin: &Plugin) -> AtWork {
    let (sink, lines) = keeper();
    AtWork { session: plugin.start(&common::task(), sink).unwrap(), lines, commands: Vec::new() }
}

impl AtWork {
    pub fn step(&mut self) {
        let time = self.commands.len() as f64 * 0.1;
        let command = self.session.step(&Observation { time, ..common::observation() }).unwrap();
        self.commands.push([command.steering, command.throttle, command.brake].map(f64::to_bits));
    }

    pub fn half(mut self) -> Self {
        (0..STEPS / 2).for_each(|_| self.step());
        self
    }

    pub fn finish(mut self) -> Record {
        while self.commands.len() < STEPS as usize {
            self.step();
        }
        let fuel = self.session.fuel();
        drop(self.session);
        Record { commands: self.commands, lines: self.lines.lock().unwrap().clone(), fuel }
    }
}

fn in_wasm(part: f64) -> Option<Plugin> {
    let step = format!(
        "(f64.store (i32.const 3008)
           (f64.add (f64.mul (f64.load (i32.const 3008)) (f64.const {part})) (f64.load offset=8 (local.get $args))))
         (call $log (i32.const 2) (i32.const 16) (i32.const 9))
         (call $ok_command (f64.load (i32.const 3008)) (f64.convert_i32_u (global.get $calls)) (f64.const 0))"
    );
    Some(common::plugin(wasm::OK, &step, &Limits::default()))
}

fn in_c(part: f64) -> Option<Plugin> {
    // Files of libraries stay for the processes that are started later.
    static FILES: OnceLock<tempfile::TempDir> = OnceLock::new();
    let path = FILES.get_or_init(|| tempfile::tempdir().unwrap()).path().join(format!("{part}.so"));
    common::compile_c(Path::new("steady.c"), &path, &[&format!("PART={part}")])?;
    Some(Plugin::load_with(&path, &Limits::default(), None, &options()).unwrap())
}
