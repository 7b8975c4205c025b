//! Tasks in lockstep or in real time.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use vb_files::lock;
use vb_host::{External, ExternalLog, ExternalSession, FaultCause, Limits, Plugin, PluginKind};
use vb_rosmsg::convert::seconds;
use vb_sdk::{Command, Gear, LogLevel, Observation, Task};

use crate::actuator::{Actuator, Setpoint};
use crate::link::{Incoming, Link, StepCall};
use crate::tick::{publish_end, publish_task, publish_tick, start_of};
use crate::{Options, OptionsError, Pace};

/// The period of checks for nodes in the domain.
const LOOK: Duration = Duration::from_millis(100);
/// A node that has not got a new endpoint for so long is complete.
const COMPLETE: Duration = Duration::from_millis(500);
/// A tick is published again after so long without an answer: its first messages may have been sent before a node could hear them.
const AGAIN: Duration = Duration::from_secs(1);
/// In real time, a vehicle without a new command for so long stops (the default `cmd_vel_timeout` of ros2_controllers' drive controllers).
const HOLD: Duration = Duration::from_millis(500);

/// A planner that is a node of ROS 2. The domain is joined with the first task.
///
/// # Errors
/// Returns an error if an option is wrong.
pub fn plugin(options: Options, limits: &Limits) -> Result<Plugin, OptionsError> {
    options.check()?;
    let (metadata, identity) = (options.metadata(), options.identity());
    let planner = Planner { options: Arc::new(options), link: Arc::default() };
    Ok(Plugin::external(PluginKind::Ros, metadata, &identity, limits, Arc::new(planner)))
}

#[derive(Debug)]
struct Planner {
    options: Arc<Options>,
    link: Arc<Mutex<Shared>>,
}

/// The link of all tasks, which one task at a time has.
#[derive(Debug, Default)]
struct Shared {
    link: Option<Link>,
    is_taken: bool,
}

impl External for Planner {
    fn start(&self, task: &Task, log: ExternalLog) -> Result<Box<dyn ExternalSession>, FaultCause> {
        let mut link = self.take()?;
        let ready = ready(&mut link, &self.options, task);
        let start = match ready {
            Ok(start) => start,
            Err(fault) => {
                give_back(&self.link, link);
                return Err(fault);
            }
        };
        let actuator = Actuator::new(&task.vehicle, task.control_period);
        Ok(Box::new(Session {
            options: Arc::clone(&self.options),
            shared: Arc::clone(&self.link),
            link: Some(link),
            task: task.clone(),
            start,
            log,
            actuator,
            setpoint: None,
            speed: 0.0,
            late: 0,
            calls: VecDeque::new(),
            next_tick: None,
            fresh: None,
        }))
    }

    fn departures(&self) -> Vec<String> {
        match self.options.pace {
            Pace::Lockstep => Vec::new(),
            Pace::RealTime { deadline } => {
                vec![format!("real time: the deadline of commands was {deadline} s of wall-clock time")]
            }
        }
    }
}

impl Planner {
    /// Takes the link; there is only one.
    fn take(&self) -> Result<Link, FaultCause> {
        let mut shared = lock(&self.link);
        if shared.is_taken {
            let message = "a ROS 2 node can run one task at a time (run with one job)".to_owned();
            return Err(FaultCause::Worker { message });
        }
        let link = match shared.link.take() {
            Some(link) => link,
            None => Link::open(&self.options)?,
        };
        shared.is_taken = true;
        Ok(link)
    }
}

fn give_back(shared: &Mutex<Shared>, link: Link) {
    let mut shared = lock(shared);
    shared.link = Some(link);
    shared.is_taken = false;
}

/// The wall clock: it decides when a wait ends, and in real time also which commands count.
#[expect(clippy::disallowed_methods, reason = "waits end by it; in lockstep no score depends on it")]
fn wall() -> Instant {
    Instant::now()
}

/// Waits for a node that can command, and publishes the task. Returns the time on `/clock` at which it starts, ns.
fn ready(link: &mut Link, options: &Options, task: &Task) -> Result<i64, FaultCause> {
    let deadline = wall() + options.start_timeout;
    // Those of the task before have got all that they need.
    let mut known = std::mem::take(&mut link.known);
    let mut changed: Option<Instant> = None;
    loop {
        let peers = link.peers();
        if let Some(message) = &peers.unusable {
            return Err(FaultCause::PeerProtocol { message: message.clone() });
        }
        let now = wall();
        if peers != known {
            (known, changed) = (peers, Some(now));
        }
        if !known.participants.is_empty() && changed.is_none_or(|at| now >= at + COMPLETE) {
            break;
        }
        if now >= deadline {
            let addresses: Vec<String> = options.addresses().iter().map(ToString::to_string).collect();
            return Err(FaultCause::PeerMissing {
                message: format!(
                    "no node publishes on /cmd_vel or /ackermann_cmd, or calls /vertibench/step, in domain {} on {} within {} s",
                    options.domain,
                    addresses.join(", "),
                    options.start_timeout.as_secs_f64(),
                ),
            });
        }
        link.wait(LOOK)?;
        link.start_count();
        // Nothing that comes before the task begins is for it, but a flood is found out.
        while link.next()?.is_some() {}
    }
    link.known = known;
    let start = start_of(options, &task.id);
    publish_task(&link.out, options, task, start)?;
    Ok(start)
}

/// A task in which a node drives.
struct Session {
    options: Arc<Options>,
    shared: Arc<Mutex<Shared>>,
    /// There until the session ends.
    link: Option<Link>,
    task: Task,
    /// ns.
    start: i64,
    log: ExternalLog,
    actuator: Actuator,
    /// The setpoint that holds; none before the first.
    setpoint: Option<Setpoint>,
    /// The last known forward speed, m/s.
    speed: f64,
    /// Commands that were for an earlier tick.
    late: u64,
    /// Calls of `step` that no tick has taken.
    calls: VecDeque<StepCall>,
    /// In real time: when the next tick is due.
    next_tick: Option<Instant>,
    /// In real time: when the last command came.
    fresh: Option<Instant>,
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Session({})", self.task.id)
    }
}

impl ExternalSession for Session {
    fn step(&mut self, observation: &Observation) -> Result<Command, FaultCause> {
        let Some(mut link) = self.link.take() else {
            return Ok(Actuator::stop());
        };
        let result = self.tick(&mut link, observation);
        self.link = Some(link);
        result
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let Some(link) = self.link.take() else { return };
        // The next task reports the same failure.
        let _ = publish_end(&link.out, &self.task.id);
        give_back(&self.shared, link);
    }
}

/// The meaning of a message for the tick that is waiting.
enum Meaning {
    /// It answers the tick.
    Answer(Setpoint),
    /// It was for an earlier one.
    Late,
    /// It is no command.
    Nothing,
}

impl Session {
    fn tick(&mut self, link: &mut Link, observation: &Observation) -> Result<Command, FaultCause> {
        self.speed = forward_speed(observation, &self.task).unwrap_or(self.speed);
        match self.options.pace {
            Pace::Lockstep => self.lockstep(link, observation),
            Pace::RealTime { deadline } => {
                self.real_time(link, observation, Duration::from_secs_f64(deadline))
            }
        }
    }

    fn publish(&self, link: &Link, observation: &Observation) -> Result<(), FaultCause> {
        publish_tick(&link.out, &self.options, &self.task, self.start, observation)
    }

    /// The time of an observation on `/clock`, ns.
    fn now(&self, observation: &Observation) -> i64 {
        self.start + seconds(observation.time)
    }

    fn lockstep(&mut self, link: &mut Link, observation: &Observation) -> Result<Command, FaultCause> {
        let now = self.now(observation);
        link.start_count();
        // A command that has come since the last answer can't be one to this tick; a call of `step` is.
        while let Some(incoming) = link.next()? {
            match incoming {
                Incoming::Gear(gear) => self.engage(gear)?,
                Incoming::Step(call) => self.calls.push_back(call),
                Incoming::Twist(..) | Incoming::Drive(..) => self.late += 1,
            }
        }
        self.publish(link, observation)?;
        let deadline = wall() + self.options.answer_timeout;
        let (mut look, mut again) = (wall() + LOOK, wall() + AGAIN);
        loop {
            while let Some(incoming) = link.next()? {
                match self.meaning(incoming, now)? {
                    Meaning::Answer(setpoint) => return Ok(self.obey(Some(setpoint))),
                    Meaning::Late => self.late += 1,
                    Meaning::Nothing => {}
                }
            }
            if let Some(call) = self.calls.pop_front() {
                link.reply(&call, format!("t = {:.3} s", observation.time))?;
                return Ok(self.obey(self.setpoint));
            }
            let time = wall();
            if time >= deadline {
                return Err(self.no_answer(observation));
            }
            if time >= look {
                self.look(link)?;
                look = time + LOOK;
            }
            if time >= again {
                (self.log)(LogLevel::Debug, "no answer for 1 s: the tick is published again");
                self.publish(link, observation)?;
                again = time + AGAIN;
            }
            link.wait(LOOK.min(deadline - time))?;
        }
    }

    fn no_answer(&self, observation: &Observation) -> FaultCause {
        let late = match self.late {
            0 => String::new(),
            n => format!("; commands for earlier ticks: {n}"),
        };
        FaultCause::PeerLate {
            message: format!(
                "no command answered the tick at t = {:.2} s within {} s of wall-clock time{late}",
                observation.time,
                self.options.answer_timeout.as_secs_f64(),
            ),
        }
    }

    fn real_time(
        &mut self,
        link: &mut Link,
        observation: &Observation,
        deadline: Duration,
    ) -> Result<Command, FaultCause> {
        let period = Duration::from_secs_f64(self.task.control_period);
        if let Some(due) = self.next_tick {
            let time = wall();
            if time > due + period {
                (self.log)(LogLevel::Warn, "the simulation is slower than real time: a tick is late");
            }
            while wall() < due {
                link.wait(due.saturating_duration_since(wall()))?;
            }
        }
        let began = wall();
        link.start_count();
        // A tick that is late doesn't make the next ones early.
        self.next_tick = Some(began + period);
        self.publish(link, observation)?;
        let now = self.now(observation);
        let mut is_answered = false;
        loop {
            while let Some(incoming) = link.next()? {
                if let Meaning::Answer(setpoint) = self.meaning(incoming, now)? {
                    (self.setpoint, self.fresh, is_answered) = (Some(setpoint), Some(wall()), true);
                }
            }
            // Time passes by itself.
            for call in std::mem::take(&mut self.calls) {
                link.reply(&call, format!("t = {:.3} s", observation.time))?;
            }
            let left = (began + deadline).saturating_duration_since(wall());
            if left.is_zero() {
                break;
            }
            link.wait(left)?;
        }
        self.look(link)?;
        if !is_answered {
            (self.log)(
                LogLevel::Warn,
                &format!("t = {:.2} s: no command within the deadline", observation.time),
            );
        }
        if self.fresh.is_none_or(|fresh| wall() > fresh + HOLD) {
            self.setpoint = None;
        }
        Ok(self.obey(self.setpoint))
    }

    /// Looks whether there still is a node that can command.
    fn look(&mut self, link: &Link) -> Result<(), FaultCause> {
        let peers = link.peers();
        if let Some(message) = peers.unusable {
            return Err(FaultCause::PeerProtocol { message });
        }
        if peers.participants.is_empty() {
            let message = "the node that published commands left the domain".to_owned();
            return Err(FaultCause::PeerLeft { message });
        }
        Ok(())
    }

    /// What a message means while the tick at `now` (ns) waits.
    fn meaning(&mut self, incoming: Incoming, now: i64) -> Result<Meaning, FaultCause> {
        let invalid = |(field, value): (&'static str, f64)| FaultCause::InvalidOutput {
            field,
            value: if value.is_nan() { "NaN".to_owned() } else { value.to_string() },
        };
        let (stamp, setpoint) = match incoming {
            Incoming::Gear(gear) => {
                self.engage(gear)?;
                return Ok(Meaning::Nothing);
            }
            Incoming::Step(call) => {
                self.calls.push_back(call);
                return Ok(Meaning::Nothing);
            }
            Incoming::Twist(stamp, twist) => (stamp, Setpoint::of_twist(&twist).map_err(invalid)?),
            Incoming::Drive(stamp, drive) => (stamp, Setpoint::of_drive(&drive).map_err(invalid)?),
        };
        match stamp {
            Some(stamp) if stamp < now && self.options.pace == Pace::Lockstep => Ok(Meaning::Late),
            Some(stamp) if stamp > now => Err(FaultCause::PeerProtocol {
                message: format!(
                    "a command is stamped {:.3} s, which is after the time on /clock, {:.3} s (set use_sim_time on the node)",
                    stamp as f64 * 1e-9,
                    now as f64 * 1e-9,
                ),
            }),
            _ => Ok(Meaning::Answer(setpoint)),
        }
    }

    fn engage(&mut self, gear: i8) -> Result<(), FaultCause> {
        let gear = match gear {
            -1 => Gear::Reverse,
            0 => Gear::Neutral,
            1 => Gear::Forward,
            other => {
                let message = format!(
                    "a message on /gear is {other}; it must be -1 (reverse), 0 (neutral) or 1 (forward)"
                );
                return Err(FaultCause::PeerProtocol { message });
            }
        };
        self.actuator.engage(gear);
        Ok(())
    }

    /// The command for a setpoint; without one, the vehicle stands.
    fn obey(&mut self, setpoint: Option<Setpoint>) -> Command {
        self.setpoint = setpoint;
        setpoint.map_or_else(Actuator::stop, |setpoint| self.actuator.follow(setpoint, self.speed))
    }
}

/// The forward speed, m/s, of the pose estimate or of the wheels; none if neither was measured.
fn forward_speed(observation: &Observation, task: &Task) -> Option<f64> {
    if let Some(pose) = &observation.pose {
        return Some(pose.linear_velocity.x);
    }
    let n = observation.wheels.len();
    let sum: f64 = observation.wheels.iter().map(|wheel| wheel.spin).sum();
    (n > 0).then(|| sum / n as f64 * task.vehicle.wheel_radius)
}
