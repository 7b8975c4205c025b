//! Drives by recorded commands, which repeat a run's trial exactly.

use std::iter::Peekable;
use std::slice::Iter;

use vb_record::{Sample, Trace};
use vb_sdk::{Command, Observation, Task};
use vb_sim::SAMPLE_PERIOD;
use vb_trial::{Driver, DriverFault, Log, commanded_gear, planner_gear};

/// Gives the commands of a trace again. It decides at every sample, so that it doesn't matter how often the planner did.
pub(crate) struct Playback<'a> {
    name: String,
    samples: Peekable<Iter<'a, Sample>>,
    last: Command,
}

impl<'a> Playback<'a> {
    pub(crate) fn new(name: String, trace: &'a Trace) -> Self {
        Self { name, samples: trace.samples.iter().peekable(), last: Command::default() }
    }
}

impl Driver for Playback<'_> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn start(&mut self, _: &Task, _: Log) -> Result<(), DriverFault> {
        Ok(())
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, DriverFault> {
        // A sample has the command that was applied up to it.
        let next = observation.time + SAMPLE_PERIOD;
        while self.samples.next_if(|s| s.time < next - 0.25 * SAMPLE_PERIOD).is_some() {}
        if let Some(s) = self.samples.peek() {
            let gear = planner_gear(commanded_gear(s.gear));
            let Sample { steering, throttle, brake, .. } = **s;
            self.last = Command { steering, throttle, brake, gear, debug: Vec::new() };
        }
        Ok(self.last.clone())
    }
}
